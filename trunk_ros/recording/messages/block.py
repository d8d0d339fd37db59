"""Messages as they lie in a file: one buffer, and where in it each message of one topic begins."""

import io
import mmap
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, TypeAlias

import lz4.frame
import numpy as np
import numpy.typing as npt
import zstandard

from trunk_ros.recording.allowance import Allowance

Bytes: TypeAlias = npt.NDArray[np.uint8]
Whole: TypeAlias = npt.NDArray[np.int64]
Progress: TypeAlias = Callable[[float], None]


class DamageError(Exception):
    """A file that cannot be read at all; the text is a clause that completes `<file> ...`."""


@dataclass(frozen=True)
class Block:
    """Messages of one topic. data: (bytes,); start, size, log_ns (ns since the epoch): (messages,)."""

    topic: str
    type: str
    encoding: str
    data: Bytes
    start: Whole
    size: Whole
    log_ns: Whole


@dataclass
class Contents:
    """What became known of a file while its blocks were read, and how much it may still be unpacked to."""

    allowance: Allowance
    topics: dict[str, str] = field(default_factory=dict)
    damage: list[str] = field(default_factory=list)
    custom: dict[str, str] = field(default_factory=dict)
    expected: dict[str, int] = field(default_factory=dict)


class Storage(Protocol):
    """A file format: yields the blocks of the topics that `wanted` picks and notes the rest in `contents`."""

    def __call__(
        self, path: Path, wanted: Callable[[str], bool], contents: Contents, progress: Progress
    ) -> Iterator[Block]: ...


def mapped(path: Path) -> memoryview:
    """The bytes of a file without reading them all into memory."""
    with path.open("rb") as stream:
        if not path.stat().st_size:
            return memoryview(b"")
        return memoryview(mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ))


def integers(data: Bytes, start: Whole, kind: str) -> Whole:
    """(n,) the whole numbers of a numpy kind such as "<u2" that lie in `data` from each start on."""
    rows = np.lib.stride_tricks.sliding_window_view(data, np.dtype(kind).itemsize)[start]
    return np.ascontiguousarray(rows).view(kind)[:, 0].astype(np.int64)


def block_of(topic: str, kind: str, encoding: str, payloads: list[bytes], log_ns: list[int]) -> Block:
    """A block of messages that come one by one."""
    size = np.array([len(each) for each in payloads], dtype=np.int64)
    start = np.concatenate(([0], np.cumsum(size)[:-1])).astype(np.int64) if len(size) else size
    data = np.frombuffer(b"".join(payloads), dtype=np.uint8)
    return Block(topic, kind, encoding, data, start, size, np.array(log_ns, dtype=np.int64))


def unzstd(data: bytes | memoryview | Bytes, allowance: Allowance, size: int | None = None) -> bytes:
    """Decompress zstd, at most `size` bytes; a cut stream gives what is whole of it; else DamageError.

    RecordingError where that is more than the allowance.
    """
    limit = allowance.most if size is None else min(size, allowance.most)
    out = io.BytesIO()
    with zstandard.ZstdDecompressor().stream_reader(bytes(data)) as stream:
        try:
            while out.tell() < limit and (piece := stream.read(min(1 << 20, limit - out.tell()))):
                out.write(piece)
        except zstandard.ZstdError as error:
            raise DamageError(f"holds zstd data that cannot be read ({error})") from None
    allowance.take(out.tell())
    return out.getvalue()


def unlz4(data: bytes, allowance: Allowance, size: int) -> bytes:
    """The same for lz4."""
    try:
        plain = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=min(size, allowance.most))
    except (RuntimeError, EOFError) as error:
        raise DamageError(f"holds lz4 data that cannot be read ({error})") from None
    allowance.take(len(plain))
    return bytes(plain)
