"""Reads a rosbag2 file of the sqlite3 storage, also one whose write-ahead log was left behind."""

import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from urllib.parse import quote

from trunk_ros.recording.block import Block, Contents, DamageError, Progress, block_of

MAGIC = b"SQLite format 3\0"
_BATCH = 8192
_TABLES = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages')"
_TOPICS = "SELECT id, name, type, serialization_format FROM topics"
_MESSAGES = "SELECT id, timestamp, data FROM messages WHERE topic_id = ? ORDER BY id"


def read_sqlite(
    path: Path, wanted: Callable[[str], bool], contents: Contents, progress: Progress
) -> Iterator[Block]:
    """Blocks of a sqlite3 file, topic by topic; DamageError if it holds no recording."""
    log = path.with_name(path.name + "-wal")
    if not log.exists() or not log.stat().st_size:
        yield from _read(path, wanted, contents, progress)
        return
    with tempfile.TemporaryDirectory() as folder:  # replaying the log writes: never in the user's bag
        copy = Path(folder) / "copy.db3"
        shutil.copyfile(path, copy)
        shutil.copyfile(log, copy.with_name("copy.db3-wal"))
        yield from _read(copy, wanted, contents, progress, "mode=rw")


def _read(
    path: Path,
    wanted: Callable[[str], bool],
    contents: Contents,
    progress: Progress,
    mode: str = "mode=ro&immutable=1",
) -> Iterator[Block]:
    with closing(sqlite3.connect(f"file:{quote(str(path.resolve()))}?{mode}", uri=True)) as database:
        topics = _topics(database)
        contents.topics.update({name: kind for _, name, kind, _ in topics})
        for done, (number, name, kind, encoding) in enumerate(topics):
            if wanted(name):
                progress(done / len(topics))
                yield from _messages(database, number, (name, kind, encoding), contents)


def _topics(database: sqlite3.Connection) -> list[tuple[int, str, str, str]]:
    try:
        if database.execute(_TABLES).fetchone()[0] != 2:
            raise DamageError("is a database without the tables of a recording")
        rows = database.execute(_TOPICS).fetchall()
    except sqlite3.Error as error:
        raise DamageError(f"is a damaged database ({error})") from None
    return [(int(number), str(name), str(kind), str(encoding)) for number, name, kind, encoding in rows]


def _messages(
    database: sqlite3.Connection, number: int, topic: tuple[str, str, str], contents: Contents
) -> Iterator[Block]:
    try:
        cursor = database.execute(_MESSAGES, (number,))
        while rows := cursor.fetchmany(_BATCH):
            good = [row for row in rows if isinstance(row[2], bytes) and isinstance(row[1], int)]
            yield block_of(*topic, [row[2] for row in good], [row[1] for row in good])
    except sqlite3.Error as error:
        contents.damage.append(f"it is damaged ({error}): {topic[0]} is read up to there")
