"""Message types by name: the class that rclpy needs, the definition and hash that a bag carries."""

from __future__ import annotations

import importlib
import re
from functools import cache
from pathlib import Path
from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.graph.ros import PackageNotFoundError, get_package_share_directory
from trunk_ros.recording.messages.message_types import definition

RULE = "=" * 80
PLAIN = re.compile(r"^(bool|byte|char|float32|float64|u?int(8|16|32|64)|w?string)\b")


@cache
def message_class(kind: str) -> Any:
    """The class of ``package/msg/Name``. Raises TrunkError where its package is not installed."""
    package, *middle, name = kind.split("/")
    try:
        return getattr(importlib.import_module(".".join([package, *middle])), name)
    except (ImportError, AttributeError):
        raise TrunkError(f"the type {kind} is not installed here") from None


@cache
def message_definition(kind: str) -> tuple[str, str]:
    """Definition with all that it refers to, and RIHS01 hash ("" where unknown). Raises TrunkError."""
    try:
        return definition(kind)
    except Exception:
        return _installed_definition(kind), ""


def _installed_definition(kind: str) -> str:
    """The text of the installed .msg files, parts separated as rosbag2 does."""
    parts: dict[str, str] = {}
    waiting = [kind]
    while waiting:
        each = waiting.pop(0)
        if each in parts:
            continue
        parts[each] = _text(each)
        waiting += _references(parts[each], each.split("/")[0])
    first, *others = parts.items()
    return first[1] + "".join(f"\n{RULE}\nMSG: {_short(name)}\n{text}" for name, text in others)


def _text(kind: str) -> str:
    package, name = kind.split("/")[0], kind.split("/")[-1]
    try:
        return Path(get_package_share_directory(package), "msg", f"{name}.msg").read_text()
    except (PackageNotFoundError, OSError):
        raise TrunkError(f"the definition of {kind} is not installed here") from None


def _references(text: str, package: str) -> list[str]:
    found = []
    for line in text.splitlines():
        word = line.split("#")[0].strip().split(" ")[0].split("[")[0].split("<")[0]
        if word and not PLAIN.match(word):
            found.append(
                f"{package}/msg/{word}"
                if "/" not in word
                else f"{word.split('/')[0]}/msg/{word.split('/')[-1]}"
            )
    return found


def _short(kind: str) -> str:
    return f"{kind.split('/')[0]}/{kind.split('/')[-1]}"
