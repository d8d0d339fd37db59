"""Any recording on disk as a stream of blocks: folders, bare files, compressed ones, known by content."""

import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np
import zstandard

from trunk_ros.recording.allowance import Allowance, is_lifted
from trunk_ros.recording.arrays import ELSEWHERE
from trunk_ros.recording.bag import metadata
from trunk_ros.recording.bag import ros1 as ros1_file
from trunk_ros.recording.bag import sqlite as sqlite_file
from trunk_ros.recording.bag.growth import check_growth
from trunk_ros.recording.mcap import records as mcap_records
from trunk_ros.recording.mcap.file import read_mcap
from trunk_ros.recording.messages.block import (
    Block,
    Bytes,
    Contents,
    DamageError,
    Progress,
    Storage,
    block_of,
    unzstd,
)

_ZSTD = b"\x28\xb5\x2f\xfd"
_STORAGES: dict[bytes, Storage] = {
    mcap_records.MAGIC: read_mcap,
    sqlite_file.MAGIC: sqlite_file.read_sqlite,
    ros1_file.MAGIC: ros1_file.read_ros1,
}


def read_blocks(
    path: Path, wanted: Callable[[str], bool], contents: Contents, progress: Progress
) -> Iterator[Block]:
    """Blocks of all files of the recording at `path` in order; DamageError if there is nothing to read."""
    if not path.exists():
        raise DamageError("does not exist")
    if path.name == metadata.FILE:
        path = path.parent
    files, message_compression = _files(path, contents)
    for done, file in enumerate(files):

        def part(fraction: float, done: int = done) -> None:
            progress((done + fraction) / len(files))

        for block in _read_file(file, len(files) > 1, wanted, contents, part):
            yield _unpacked(block, contents) if message_compression else block
    progress(1.0)


def check_size(path: Path) -> None:
    """Unpack a recording to nowhere, for readers that know no bounds. RecordingError where it grows too much.

    DamageError where it cannot be read.
    """
    if is_lifted():
        return
    contents = Contents(Allowance(path))
    files, message_compression = _files(path, contents)
    for file in files:
        with _plain(file, contents.allowance) as plain:
            check_growth(plain, _magic(plain), contents.allowance)
    if message_compression:
        for _ in read_blocks(path, lambda _: True, Contents(Allowance(path)), lambda _: None):
            pass


def _files(path: Path, contents: Contents) -> tuple[list[Path], bool]:
    """Files of a recording, and whether its messages are compressed one by one."""
    if path.is_file():
        return [path], False
    if not path.is_dir():
        raise DamageError("is neither a file nor a folder")
    if not (path / metadata.FILE).is_file():
        return _files_without_metadata(path, contents), False
    bag = metadata.read_metadata(path)
    contents.custom.update(bag.custom)
    contents.expected.update(bag.messages)
    if not bag.files:
        raise DamageError(f"has a {metadata.FILE} that names no file")
    for name in bag.files:
        if not (path / name).is_file():
            raise DamageError(f"lacks its file {name}")
    return [path / name for name in bag.files], bag.compression == "message"


def _files_without_metadata(path: Path, contents: Contents) -> list[Path]:
    files = mcap_files(path) or _sorted(path.glob("*.db3"))
    if not files:
        raise DamageError(f"is no recording: neither {metadata.FILE} nor .mcap, .db3 in the folder")
    contents.damage.append(f"it has no {metadata.FILE}: `recover` writes one")
    return files


def is_recording(path: Path) -> bool:
    """Whether `path` is a folder, or a file that begins as one of the kinds of recording does."""
    if not path.is_file():
        return path.is_dir()
    with path.open("rb") as stream:
        return stream.read(16).startswith((_ZSTD, *_STORAGES))


def mcap_files(folder: Path) -> list[Path]:
    """The MCAP files of a rosbag2 folder in the order of recording."""
    return _sorted(folder.glob("*.mcap"))


def _sorted(files: Iterable[Path]) -> list[Path]:
    return sorted((each for each in files if each.is_file() and each.name[0] != "."), key=_split_number)


def _split_number(file: Path) -> tuple[int, str]:
    """bag_10.mcap comes after bag_9.mcap."""
    number = file.stem.rpartition("_")[2]
    return int(number) if number.isascii() and number.isdigit() else 0, file.name


def _read_file(
    file: Path, several: bool, wanted: Callable[[str], bool], contents: Contents, progress: Progress
) -> Iterator[Block]:
    """Blocks of one file. One of several that cannot be read is a loss; a single one is an error."""
    begun = len(contents.damage)
    try:
        with _plain(file, contents.allowance) as plain:
            yield from _STORAGES[_magic(plain)](plain, wanted, contents, progress)
    except DamageError as error:
        if not several:
            raise
        contents.damage.append(f"its file {file.name} {error} and is left out")
        return
    if several:
        contents.damage[begun:] = [f"in its file {file.name} {each}" for each in contents.damage[begun:]]


def _magic(file: Path) -> bytes:
    """What files of its kind begin with; DamageError where it is of none."""
    with file.open("rb") as stream:
        head = stream.read(16)
    if not head:
        raise DamageError("is empty")
    for magic in _STORAGES:
        if head.startswith(magic):
            return magic
    raise DamageError(f"is no recording: neither MCAP, nor rosbag2 sqlite3, nor a ROS 1 bag; {ELSEWHERE}")


@contextmanager
def _plain(file: Path, allowance: Allowance) -> Iterator[Path]:
    """The file, or a temporary copy that is decompressed; a cut one as far as it is whole."""
    with file.open("rb") as stream:
        if stream.read(4) != _ZSTD:
            yield file
            return
        stream.seek(0)
        with tempfile.TemporaryDirectory() as folder:
            plain = Path(folder) / file.stem
            with plain.open("wb") as out:
                _decompress(stream, out, allowance)
            yield plain


def _decompress(stream: BinaryIO, out: BinaryIO, allowance: Allowance) -> None:
    with zstandard.ZstdDecompressor().stream_reader(stream, read_across_frames=True) as plain:
        try:
            while piece := plain.read(1 << 20):
                allowance.take(len(piece))
                out.write(piece)
        except zstandard.ZstdError as error:
            raise DamageError(f"holds zstd data that cannot be read ({error})") from None


def _unpacked(block: Block, contents: Contents) -> Block:
    """The block with each message decompressed."""
    payloads, log_ns = [], []
    for start, size, log in zip(block.start, block.size, block.log_ns, strict=True):
        try:
            payloads.append(unzstd(_slice(block.data, start, size), contents.allowance))
            log_ns.append(int(log))
        except DamageError as error:
            contents.damage.append(f"{block.topic} {error}")
    return block_of(block.topic, block.type, block.encoding, payloads, log_ns)


def _slice(data: Bytes, start: np.int64, size: np.int64) -> Bytes:
    return data[start : start + size]
