"""metadata.yaml of a rosbag2 folder, version 1 (Crystal) to 9 (Jazzy)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from trunk_ros.recording import plain_yaml
from trunk_ros.recording.messages.block import DamageError
from trunk_ros.recording.plain_yaml import scalar

FILE = "metadata.yaml"
NEWEST = 9
_KEY = "rosbag2_bagfile_information"
_STORAGES = ("mcap", "sqlite3")


@dataclass(frozen=True)
class BagFile:
    """A file as metadata.yaml describes it: first and last time of recording, ns since the epoch."""

    name: str
    start_ns: int
    end_ns: int
    messages: int


@dataclass(frozen=True)
class BagMetadata:
    """What a reader needs of metadata.yaml. files: names inside the folder. messages: count per topic.
    described: files as it describes them, where it does.
    """

    files: tuple[str, ...]
    storage: str
    compression: str = ""
    messages: dict[str, int] = field(default_factory=dict)
    custom: dict[str, str] = field(default_factory=dict)
    described: tuple[BagFile, ...] = ()


@dataclass(frozen=True)
class Topic:
    """A topic as metadata.yaml describes it."""

    name: str
    type: str
    messages: int
    hash: str = ""
    qos: Sequence[dict[str, Any]] = ()
    encoding: str = "cdr"


def read_metadata(folder: Path) -> BagMetadata:
    """metadata.yaml of a folder; DamageError in one clause if it is not one that can be read."""
    content = _load(folder / FILE)
    try:
        return _parse(content[_KEY])
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        missing = f" (no {error})" if isinstance(error, KeyError) else ""
        raise DamageError(f"has a damaged {FILE}{missing}: `recover` writes it anew") from None


def _load(path: Path) -> Any:
    try:
        return plain_yaml.load(path.read_bytes())
    except ValueError as error:
        where = str(error).removeprefix("is not YAML")
        raise DamageError(f"has a damaged {FILE}{where}: `recover` writes it anew") from None


def _parse(information: dict[str, Any]) -> BagMetadata:
    version = int(information["version"])
    if not 1 <= version <= NEWEST:
        raise DamageError(f"has metadata of version {version}: 1 to {NEWEST} can be read")
    storage = scalar(information["storage_identifier"])
    if storage not in _STORAGES:
        raise DamageError(f"is stored as {storage[:40]!r}: {' and '.join(_STORAGES)} can be read")
    compression = scalar(information.get("compression_mode") or "").lower().replace("none", "")
    method = scalar(information.get("compression_format") or "")
    if compression not in ("", "file", "message") or (compression and method != "zstd"):
        raise DamageError(f"is compressed as {(method + ' ' + compression)[:40]!r}: zstd can be read")
    custom = information.get("custom_data") or {}
    return BagMetadata(
        files=tuple(PurePosixPath(scalar(each)).name for each in information["relative_file_paths"]),
        storage=storage,
        compression=compression,
        messages=_message_counts(information),
        custom={scalar(key): scalar(value) for key, value in custom.items()},
        described=_described(information),
    )


def _described(information: dict[str, Any]) -> tuple[BagFile, ...]:
    """What is said of each file, which readers can do without; empty where it is missing or damaged."""
    try:
        return tuple(_file(each) for each in information.get("files") or [])
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError):
        return ()


def _file(entry: dict[str, Any]) -> BagFile:
    start_ns = int(entry["starting_time"]["nanoseconds_since_epoch"])
    end_ns = start_ns + int(entry["duration"]["nanoseconds"])
    return BagFile(PurePosixPath(scalar(entry["path"])).name, start_ns, end_ns, int(entry["message_count"]))


def _message_counts(information: dict[str, Any]) -> dict[str, int]:
    topics = information.get("topics_with_message_count") or []
    return {scalar(each["topic_metadata"]["name"]): int(each["message_count"]) for each in topics}


def write_metadata(folder: Path, content: dict[str, Any]) -> None:
    """Write metadata.yaml with what `information` gave; it is whole or as it was before. Raises OSError."""
    draft = folder / f".{FILE}"
    try:
        draft.write_text(plain_yaml.dump({_KEY: content}))
        draft.replace(folder / FILE)
    finally:
        draft.unlink(missing_ok=True)


def information(
    files: Sequence[BagFile], topics: Sequence[Topic], custom: dict[str, str] | None = None
) -> dict[str, Any]:
    """The entries of metadata.yaml for MCAP files; every key is required by the readers of Jazzy."""
    full = [each for each in files if each.messages]
    start_ns = min((each.start_ns for each in full), default=0)
    end_ns = max((each.end_ns for each in full), default=0)
    return {
        "version": NEWEST,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": end_ns - start_ns},
        "starting_time": {"nanoseconds_since_epoch": start_ns},
        "message_count": sum(each.messages for each in topics),
        "topics_with_message_count": [_topic_entry(each) for each in topics],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [each.name for each in files],
        "files": [_file_entry(each) for each in files],
        "custom_data": dict(custom) if custom else None,
        "ros_distro": "jazzy",
    }


def _file_entry(file: BagFile) -> dict[str, Any]:
    return {
        "path": file.name,
        "starting_time": {"nanoseconds_since_epoch": file.start_ns},
        "duration": {"nanoseconds": file.end_ns - file.start_ns},
        "message_count": file.messages,
    }


def _topic_entry(topic: Topic) -> dict[str, Any]:
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.type,
            "serialization_format": topic.encoding,
            "offered_qos_profiles": list(topic.qos),
            "type_description_hash": topic.hash,
        },
        "message_count": topic.messages,
    }
