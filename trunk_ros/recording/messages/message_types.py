"""Definitions, hashes and qualities of service that a bag of Jazzy carries for each topic."""

from functools import cache
from typing import Any

from rosbags.typesys import Stores, get_typestore

from trunk_ros.recording import plain_yaml

_ENDLESS = {"sec": 9223372036, "nsec": 854775807}

RELIABLE: dict[str, Any] = {
    "history": "keep_last",
    "depth": 10,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": _ENDLESS,
    "lifespan": _ENDLESS,
    "liveliness": "automatic",
    "liveliness_lease_duration": _ENDLESS,
    "avoid_ros_namespace_conventions": False,
}


@cache
def definition(kind: str) -> tuple[str, str]:
    """(message definition with all that it refers to, RIHS01 hash) of a type of Jazzy."""
    store = get_typestore(Stores.ROS2_JAZZY)
    text, _ = store.generate_msgdef(kind, ros_version=2)
    return str(text), str(store.hash_rihs01(kind))


def qos_text(profiles: list[dict[str, Any]]) -> str:
    """Offered profiles as an MCAP channel carries them."""
    return plain_yaml.dump(profiles).strip()
