"""A bag whose recorder was killed becomes one that all readers open, and what was lost is said."""

import fcntl
import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from mcap.records import Metadata, Statistics
from mcap.summary import Summary

from trunk_ros.errors import RecordingError
from trunk_ros.recording import plain_yaml
from trunk_ros.recording.bag.bag import mcap_files
from trunk_ros.recording.bag.metadata import (
    FILE,
    BagFile,
    BagMetadata,
    Topic,
    information,
    read_metadata,
    write_metadata,
)
from trunk_ros.recording.mcap.records import HEADER, MAGIC, METADATA, parsed, record_at, records
from trunk_ros.recording.mcap.repair import Promised, is_whole, repair
from trunk_ros.recording.mcap.verify import is_intact
from trunk_ros.recording.messages.block import DamageError, mapped
from trunk_ros.recording.output import new_file


def recover(path: str | Path) -> list[str]:
    """Repair the rosbag2 folder or the .mcap file at `path` in place; sentences on what was done and lost.

    A file is replaced only once its repaired copy is complete. RecordingError if nothing can be repaired.
    """
    path = Path(path)
    if not path.exists():
        raise RecordingError(f"{path}: does not exist")
    files = mcap_files(path) if path.is_dir() else [path]
    if not files:
        raise RecordingError(f"{path}: holds no .mcap file: other storages cannot be repaired")
    try:
        said, lost = _recover_files(files, _promised(path))
        if path.is_dir():
            said += _recover_metadata(path, [each for each in files if each not in lost], bool(said))
    except DamageError as error:
        raise RecordingError(f"{path}: {error}") from None
    except OSError as error:
        raise RecordingError(f"{path}: cannot be repaired ({error.strerror or error})") from None
    return said or [f"{path}: is whole, nothing to repair"]


def _promised(path: Path) -> dict[str, Promised]:
    """What metadata.yaml, if any, says that each file holds."""
    with suppress(DamageError, OSError):
        described = read_metadata(path if path.is_dir() else path.parent).described
        return {each.name: Promised(each.messages, each.start_ns, each.end_ns) for each in described}
    return {}


def _recover_files(files: Sequence[Path], promised: dict[str, Promised]) -> tuple[list[str], list[Path]]:
    """What was done, and the files of a split bag that are lost; DamageError if that is all of them."""
    said: list[str] = []
    lost: dict[Path, DamageError] = {}
    for file in files:
        _refuse_live(file)
    for file in files:
        try:
            said += _recover_file(file, promised.get(file.name))
        except DamageError as error:
            lost[file] = error
    if len(lost) == len(files):
        raise next(iter(lost.values()))
    for file, reason in lost.items():
        file.rename(_damaged(file))
        said.append(f"{file}: {reason}; left out of the bag, kept as {_damaged(file).name}")
    return said, list(lost)


def _damaged(file: Path) -> Path:
    return file.with_name(f"{file.name}.damaged")


def _recover_file(file: Path, promised: Promised | None) -> list[str]:
    if is_intact(file):
        return []
    with new_file(file, overwrite=True) as draft:
        loss = repair(file, draft, promised)
        if not loss.messages and not _just_begun(file):
            raise DamageError("holds no whole message")
        if loss.skipped:  # somebody may get more out of the damaged chunks
            _damaged(file).unlink(missing_ok=True)
            os.link(file, _damaged(file))
    kept = f"; the old file is kept as {_damaged(file).name}" if loss.skipped else ""
    return [f"{file}: repaired, {loss.sentence()}{kept}"]


def _just_begun(file: Path) -> bool:
    """Whether there is a head and nothing else whole: its recorder was killed before the first chunk."""
    data = mapped(file)
    head = record_at(data, len(MAGIC), len(data))
    following = head and record_at(data, head.end, len(data))
    return head is not None and head.kind == HEADER and (following is None or following.end > len(data))


def unfinished(folder: Path) -> bool:
    """Whether a folder holds a bag that needs ``recover``. RecordingError: it is being recorded."""
    files = mcap_files(folder)
    try:
        for file in files:
            _refuse_live(file)
        return bool(files) and not ((folder / FILE).is_file() and all(map(is_whole, files)))
    except (DamageError, OSError) as error:
        raise RecordingError(f"{folder}: {error}") from None


def _refuse_live(file: Path) -> None:
    """A recorder holds a lock on the file that it writes."""
    with file.open("rb") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DamageError(f"is being recorded: {file.name} is locked by another process") from None
        except OSError:  # where a file system knows no locks, the recorder has none either
            return


def _recover_metadata(folder: Path, files: Sequence[Path], changed: bool) -> list[str]:
    """Write metadata.yaml from the files where it is missing, damaged, or says something else."""
    old = None
    with suppress(DamageError, OSError):
        old = read_metadata(folder)
    described = [_describe(file) for file in files]
    topics = _merged([topic for _, of_file in described for topic in of_file])
    if old is not None and not changed and _agrees(old, [file for file, _ in described], topics):
        return []
    custom = old.custom if old is not None and old.custom else _custom(files)
    write_metadata(folder, information([file for file, _ in described], topics, custom))
    return [f"{folder / FILE}: written anew"]


def _custom(files: Sequence[Path]) -> dict[str, str]:
    """What the recorder noted in the files."""
    custom: dict[str, str] = {}
    for file in files:
        data = mapped(file)
        for record in records(data, len(MAGIC), len(data)):
            noted = parsed(data, record, Metadata) if record.kind == METADATA else None
            custom.update(noted.metadata if noted and noted.name == "trunk_ros" else {})
    return custom


def _agrees(old: BagMetadata, files: Sequence[BagFile], topics: Sequence[Topic]) -> bool:
    counted = {topic.name: topic.messages for topic in topics if topic.messages}
    expected = {name: count for name, count in old.messages.items() if count}
    return old.files == tuple(each.name for each in files) and expected == counted


def _describe(file: Path) -> tuple[BagFile, list[Topic]]:
    """A whole file and its topics, from its summary."""
    summary, seen = _summary(file)
    topics = []
    for number, channel in summary.channels.items():
        schema = summary.schemas.get(channel.schema_id)
        count = seen.channel_message_counts.get(number, 0)
        noted = channel.metadata
        qos = _profiles(noted.get("offered_qos_profiles", ""))
        hash_ = noted.get("topic_type_hash", "")
        topics.append(
            Topic(channel.topic, schema.name if schema else "", count, hash_, qos, channel.message_encoding)
        )
    return BagFile(file.name, seen.message_start_time, seen.message_end_time, seen.message_count), topics


def _summary(file: Path) -> tuple[Summary, Statistics]:
    try:
        with file.open("rb") as stream:
            summary = make_reader(stream).get_summary()
    except OSError:
        raise
    except Exception:  # the mcap package raises whatever its parsing runs into
        summary = None
    if summary is None or summary.statistics is None:
        raise DamageError(f"has no summary that can be read in {file.name}")
    return summary, summary.statistics


def _profiles(text: str) -> list[dict[str, Any]]:
    with suppress(ValueError):
        profiles = plain_yaml.load(text.encode())
        if isinstance(profiles, list):
            return [each for each in profiles if isinstance(each, dict)]
    return []


def _merged(topics: Sequence[Topic]) -> list[Topic]:
    """Each topic once, with its messages of all files."""
    merged: dict[str, Topic] = {}
    for topic in topics:
        before = merged[topic.name].messages if topic.name in merged else 0
        merged[topic.name] = replace(topic, messages=topic.messages + before)
    return list(merged.values())
