"""What nobody looks at for a while, out of memory."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from typing import IO, Any

from trunk_ros.heap import RETURNED, give_back
from trunk_ros.recording.recording import Recording


def size_of(recordings: Sequence[Recording]) -> int:
    """Bytes of all joints' positions."""
    return sum(series.position.nbytes for r in recordings for series in r.series.values())


@contextmanager
def aside(size: int, *kept: list[Any] | dict[Any, Any]) -> Iterator[None]:
    """What is kept of recordings of so much ``size`` is gone within, and back afterwards: while nobody looks
    at it, it lies in the directory for temporary files. Of small ones, and where there is no room, it stays.
    """
    file = _written(kept) if size >= 4 * RETURNED else None
    if file is None:
        yield
        return
    for some in kept:
        some.clear()
    give_back(libraries=True)
    with file:
        try:
            yield
        finally:
            give_back()
            file.seek(0)
            for some, back in zip(kept, pickle.load(file), strict=True):
                some.update(back) if isinstance(some, dict) else some.extend(back)


def _written(kept: Sequence[list[Any] | dict[Any, Any]]) -> IO[bytes] | None:
    with suppress(OSError), ExitStack() as closing:
        file: IO[bytes] = closing.enter_context(tempfile.TemporaryFile())
        pickle.dump(kept, file, pickle.HIGHEST_PROTOCOL)
        file.flush()  # a full disk shows here at the latest
        closing.pop_all()
        return file
    return None
