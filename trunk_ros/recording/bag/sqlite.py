"""Reads a rosbag2 file of the sqlite3 storage, also one whose write-ahead log was left behind."""

import os
import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import islice
from pathlib import Path
from typing import Any
from urllib.parse import quote

from trunk_ros.recording.allowance import Allowance
from trunk_ros.recording.messages.block import Block, Contents, DamageError, Progress, block_of

MAGIC = b"SQLite format 3\0"
_BATCH = 8192
_FROZEN = "mode=ro&immutable=1"
_LONGEST = 2**31 - 1  # bytes of a value that sqlite can be told
_TABLES = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages')"
_TOPICS = "SELECT id, name, type, serialization_format FROM topics"
_MESSAGES = "SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY id"


def read_sqlite(
    path: Path, wanted: Callable[[str], bool], contents: Contents, progress: Progress
) -> Iterator[Block]:
    """Blocks of a sqlite3 file, topic by topic; DamageError if it holds no recording."""
    log = path.with_name(path.name + "-wal")
    missing = _claimed_size(path) - path.stat().st_size
    contents.allowance.check(_claimed_size(path))
    if missing > 0:
        contents.damage.append(f"it breaks off: {missing} bytes are missing")
    logged = log.exists() and log.stat().st_size > 0
    if missing <= 0 and not logged:
        yield from _read(path, wanted, contents, progress)
        return
    with tempfile.TemporaryDirectory() as folder:  # mending writes: never in the user's bag
        copy = Path(folder) / "copy.db3"
        shutil.copyfile(path, copy)
        if missing > 0:  # sqlite opens no file that is shorter than it claims to be
            os.truncate(copy, _claimed_size(path))
        if logged:
            shutil.copyfile(log, copy.with_name("copy.db3-wal"))
        yield from _read(copy, wanted, contents, progress, "mode=rw")


def _claimed_size(path: Path) -> int:
    """Bytes of the database as its head says (https://sqlite.org/fileformat.html, 1.3)."""
    with path.open("rb") as stream:
        head = stream.read(32)
    size, pages = int.from_bytes(head[16:18], "big"), int.from_bytes(head[28:32], "big")
    return (65536 if size == 1 else size) * pages


def _read(
    path: Path,
    wanted: Callable[[str], bool],
    contents: Contents,
    progress: Progress,
    mode: str = _FROZEN,
) -> Iterator[Block]:
    with closing(_opened(path, contents.allowance, mode)) as database:
        topics = _topics(database, contents.allowance)
        contents.topics.update({name: kind for _, name, kind, _ in topics})
        for done, (number, name, kind, encoding) in enumerate(topics):
            if wanted(name):
                progress(done / len(topics))
                yield from _messages(database, number, (name, kind, encoding), contents)


def _opened(path: Path, allowance: Allowance, mode: str = _FROZEN) -> sqlite3.Connection:
    database = sqlite3.connect(f"file:{quote(str(path.resolve()))}?{mode}", uri=True)
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, min(allowance.most, _LONGEST))
    return database


def message_bytes(path: Path, allowance: Allowance) -> int:
    """Size of all messages of a file; DamageError where they cannot be counted.

    It may be more than the file's: rows may share what they hold, and columns may be computed.
    """
    with closing(_opened(path, allowance)) as database:
        _topics(database, allowance)
        try:
            return int(database.execute("SELECT total(length(data)) FROM messages").fetchone()[0])
        except sqlite3.Error as error:
            _refuse_long(error, allowance)
            raise DamageError(f"is a damaged database ({error})") from None


def _refuse_long(error: sqlite3.Error, allowance: Allowance) -> None:
    """RecordingError where a value is longer than the allowance."""
    if "too big" in str(error):
        allowance.check(_LONGEST)


def _topics(database: sqlite3.Connection, allowance: Allowance) -> list[tuple[int, str, str, str]]:
    database.text_factory = lambda text: text.decode(errors="replace")
    try:
        if database.execute(_TABLES).fetchone()[0] != 2:
            raise DamageError("is a database without the tables of a recording")
        topics = []
        for number, *words in database.execute(_TOPICS):
            name, kind, encoding = map(str, words)
            allowance.take(len(name) + len(kind) + len(encoding))
            topics.append((_number(number), name, kind, encoding))
        return topics
    except (sqlite3.Error, TypeError, ValueError, OverflowError) as error:
        raise DamageError(f"is a damaged database ({error})") from None


def _number(value: Any) -> int:
    """A topic's number, which sqlite would keep as such. OverflowError where it would not."""
    number = int(value)
    if number.bit_length() > 63:
        raise OverflowError("the number of a topic is too large")
    return number


def _messages(
    database: sqlite3.Connection, number: int, topic: tuple[str, str, str], contents: Contents
) -> Iterator[Block]:
    rows = _rows(database, number, topic[0], contents)
    while batch := list(islice(rows, _BATCH)):
        yield block_of(*topic, [data for _, data in batch], [log_ns for log_ns, _ in batch])


def _rows(
    database: sqlite3.Connection, number: int, topic: str, contents: Contents
) -> Iterator[tuple[int, bytes]]:
    """(log_ns, message) up to where the database is damaged."""
    try:
        for log_ns, data in database.execute(_MESSAGES, (number,)):
            if isinstance(log_ns, int) and isinstance(data, bytes):
                contents.allowance.take(len(data))
                yield log_ns, data
    except sqlite3.Error as error:
        _refuse_long(error, contents.allowance)
        contents.damage.append(f"it is damaged ({error}): {topic} is read up to there")
