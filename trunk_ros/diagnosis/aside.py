"""What nobody looks at for a while, out of memory."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from typing import IO

from trunk_ros.diagnosis.heap import RETURNED, give_back
from trunk_ros.recording.recording import Recording


@contextmanager
def aside(*lists: list[Recording]) -> Iterator[None]:
    """Lists of long recordings are empty within, and as they were afterwards: while a stage is searched that
    has all that it needs of them, they lie in the directory for temporary files. Short ones, and those for
    which there is no room, stay.
    """
    size = sum(series.position.nbytes for r in lists[0] for series in r.series.values())
    file = _written(lists) if size >= RETURNED else None
    if file is None:
        yield
        return
    for some in lists:
        some.clear()
    give_back()
    with file:
        try:
            yield
        finally:
            give_back()
            file.seek(0)
            for some, back in zip(lists, pickle.load(file), strict=True):
                some.extend(back)


def _written(lists: Sequence[list[Recording]]) -> IO[bytes] | None:
    with suppress(OSError), ExitStack() as closing:
        file: IO[bytes] = closing.enter_context(tempfile.TemporaryFile())
        pickle.dump(lists, file, pickle.HIGHEST_PROTOCOL)
        file.flush()  # a full disk shows here at the latest
        closing.pop_all()
        return file
    return None
