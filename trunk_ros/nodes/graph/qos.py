"""Quality of service: of publishers as a bag describes it, of a subscription that hears them all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.ros import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)
from trunk_ros.recording.messages.message_types import RELIABLE as DEFAULT

DEPTH = 200  # messages that a slow partner may be behind
RELIABLE = QoSProfile(depth=DEPTH)
SENSED = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ENDLESS = DEFAULT["deadline"]
LARGEST = 2**63 - 1


def described(profile: Any) -> dict[str, Any]:
    """A profile in the words of rosbag2's metadata, version 9."""
    return {
        "history": profile.history.name.lower(),
        "depth": int(profile.depth),
        "reliability": profile.reliability.name.lower(),
        "durability": profile.durability.name.lower(),
        "deadline": _span(profile.deadline.nanoseconds),
        "lifespan": _span(profile.lifespan.nanoseconds),
        "liveliness": profile.liveliness.name.lower(),
        "liveliness_lease_duration": _span(profile.liveliness_lease_duration.nanoseconds),
        "avoid_ros_namespace_conventions": bool(profile.avoid_ros_namespace_conventions),
    }


def _span(ns: int) -> dict[str, int]:
    return dict(ENDLESS) if ns in (0, LARGEST) else {"sec": ns // SECOND, "nsec": ns % SECOND}


def hearing_all(offered: Sequence[Any], depth: int) -> Any:
    """The strictest profile that every publisher still matches, so that no message is left out."""
    reliable = all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in offered)
    latched = all(latches(profile) for profile in offered)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def latches(profile: Any) -> bool:
    """Whether a publisher keeps its last messages for who comes later."""
    return bool(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL)


def recorded(profiles: Sequence[Any], depth: int, latched: bool = False) -> Any:
    """A profile to publish with, of recorded ones (rosbags' Qos); reliable where nothing was recorded.

    ``latched`` holds where there is no profile, as in bags of ROS 1.
    """
    best_effort = bool(profiles) and all(profile.reliability.name == "BEST_EFFORT" for profile in profiles)
    if profiles:
        latched = all(profile.durability.name == "TRANSIENT_LOCAL" for profile in profiles)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=max([depth, *(profile.depth for profile in profiles)]),
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def unique(publishers: Sequence[Any]) -> list[dict[str, Any]]:
    """The publishers' profiles in the words of rosbag2's metadata, each once."""
    found: list[dict[str, Any]] = []
    for each in publishers:
        profile = described(each.qos_profile)
        if profile not in found:
            found.append(profile)
    return found


def stricter(old: Any, new: Any) -> bool:
    """Whether an old profile shuts out publishers that a new one hears."""
    return bool(old.reliability != new.reliability or old.durability != new.durability)


def mismatch(topic: str, publishers: Sequence[Any], asked: Any) -> str:
    """Words about publishers that a subscription with this profile does not hear, "" where it hears all."""
    for each in publishers:
        compatibility, reason = qos_check_compatible(each.qos_profile, asked)
        if compatibility == QoSCompatibility.ERROR:
            return f"{topic} of {each.node_name} is not heard: {reason.removeprefix('ERROR: ').strip(' ;')}"
    return ""
