"""A scene as an MCAP file with a layout: Foxglove and Lichtblick show what Rerun does."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from mcap.writer import Writer
from rosbags.typesys import Stores, get_typestore

from trunk_ros.arm.frames import Links
from trunk_ros.compiled import Array
from trunk_ros.recording.messages.encode import encode_joints
from trunk_ros.recording.messages.message_types import definition
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.topics import JOINT_STATE, STRING
from trunk_ros.show.ghosts import GHOSTS, ghost
from trunk_ros.show.layout import NEVER, WORLD, lanes, layout
from trunk_ros.show.scene import Scene, Spell

TF = "tf2_msgs/msg/TFMessage"
OFTEN = 1.0 / 30.0  # s between poses of the arm; curves have every sample
MOST = 20_000  # poses
MILLI = 1e3  # residuals are written in thousandths

Message: TypeAlias = tuple[int, str, str, bytes]
"""Time [ns], topic, type, content in CDR."""


def save_foxglove(path: Path, beside: Path, scene: Scene, urdf: str, reach: float, start_ns: int) -> None:
    """Write a scene to the MCAP file ``path`` and its layout to ``beside``.

    ``urdf`` names the joints as the scene does; ``reach`` [m] of the arm, 0 where it is not known;
    ``start_ns``: when the recording began. Raises ModelError for a URDF of another arm, OSError.
    """
    messages = [
        *_poses(scene, urdf, start_ns), *_curves(scene, start_ns), *_regimes(scene, start_ns),
    ]  # fmt: skip
    with path.open("wb") as stream:
        _write(stream, sorted(messages, key=lambda message: message[0]))
    beside.write_text(json.dumps(layout(scene, reach), indent=1) + "\n", encoding="utf-8")


def _write(stream: Any, messages: list[Message]) -> None:
    writer = Writer(stream)
    writer.start(profile="ros2", library="trunk_ros")
    kinds = {topic: kind for _, topic, kind, _ in messages}
    schemas = {
        kind: writer.register_schema(kind, "ros2msg", definition(kind)[0].encode())
        for kind in dict.fromkeys(kinds.values())
    }
    channels = {topic: writer.register_channel(topic, "cdr", schemas[kind]) for topic, kind in kinds.items()}
    for ns, topic, _, data in messages:
        writer.add_message(channels[topic], ns, data, ns)
    writer.finish()  # type: ignore[no-untyped-call]


def _curves(scene: Scene, start_ns: int) -> Iterator[Message]:
    """Angles of each kind and what they leave of the measured ones, in thousandths."""
    stamp_ns = _ns(start_ns, scene.stamp)
    values = {f"/{kind}/joint_states": getattr(scene, kind) for kind in GHOSTS}
    for kind in ("nominal", "fitted"):
        values[f"/residuals/{kind}"] = MILLI * (scene.measured - getattr(scene, kind))
    for topic, angles in values.items():
        rows = encode_joints(JointSeries(scene.stamp, scene.joints, angles), stamp_ns)
        for ns, row in zip(stamp_ns.tolist(), rows, strict=True):
            yield ns, topic, JOINT_STATE, row.tobytes()


def _poses(scene: Scene, urdf: str, start_ns: int) -> Iterator[Message]:
    """Each arm's look once, and where its links are over time, in frames with its kind before their name."""
    links = Links(urdf, scene.joints)
    children = {child for _, child in links.pairs}
    root = next(parent for parent, _ in links.pairs if parent not in children)
    yield start_ns, "/tf", TF, _transforms(start_ns, [(WORLD, f"{kind}/{root}") for kind in GHOSTS], _still())
    for kind, colour in GHOSTS.items():
        yield start_ns, f"/{kind}/robot_description", STRING, _text(ghost(urdf, colour))
        pairs = [(f"{kind}/{parent}", f"{kind}/{child}") for parent, child in links.pairs]
        for row in _shown(scene, getattr(scene, kind)):
            ns = int(_ns(start_ns, scene.stamp[row]))
            yield ns, "/tf", TF, _transforms(ns, pairs, links.transforms(getattr(scene, kind)[row]))


def _still() -> Array:
    return np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (len(GHOSTS), 1))


def _shown(scene: Scene, angles: Array) -> list[int]:
    """Rows in which the arm is drawn: all joints known, no more than 30 a second and MOST in all."""
    known = np.flatnonzero(np.isfinite(angles).all(axis=1))
    every = max(OFTEN, float(np.ptp(scene.stamp)) / MOST)
    tick = np.floor(scene.stamp[known] / every)
    return [int(row) for row in known[np.flatnonzero(np.diff(tick, prepend=-1.0))]]


def _regimes(scene: Scene, start_ns: int) -> Iterator[Message]:
    """A topic for each finding on each joint, which says when its regime holds."""
    first, last = float(scene.stamp[0]), float(scene.stamp[-1])
    for spell, topic in zip(scene.spells, lanes(scene), strict=True):
        for time, said in _changes(spell, first, last):
            yield int(_ns(start_ns, np.float64(time))), topic, STRING, _text(said)


def _changes(spell: Spell, first: float, last: float) -> Iterator[tuple[float, str]]:
    holds = spell.regime.replace("_", " ")
    if not spell.spans or spell.spans[0][0] > first:
        yield first, NEVER if spell.spans else holds
    for begin, end in spell.spans:
        yield begin, holds
        yield end, NEVER
    yield last, NEVER if spell.spans else holds


def _ns(start_ns: int, stamp: Any) -> Any:
    """Stamps [s] of a recording as ns since the epoch."""
    return start_ns + np.rint(stamp * 1e9).astype(np.int64)


def _transforms(ns: int, pairs: list[tuple[str, str]], values: Array) -> bytes:
    store = _types()
    make = store.types
    head = make["builtin_interfaces/msg/Time"](*divmod(ns, 10**9))
    told = [
        make["geometry_msgs/msg/TransformStamped"](
            make["std_msgs/msg/Header"](head, parent), child,
            make["geometry_msgs/msg/Transform"](
                make["geometry_msgs/msg/Vector3"](*move[:3]), make["geometry_msgs/msg/Quaternion"](*move[3:])
            ),
        )
        for (parent, child), move in zip(pairs, values.tolist(), strict=True)
    ]  # fmt: skip
    return bytes(store.serialize_cdr(make[TF](told), TF))


@cache
def _types() -> Any:
    return get_typestore(Stores.ROS2_JAZZY)


def _text(said: str) -> bytes:
    store = _types()
    return bytes(store.serialize_cdr(store.types[STRING](said), STRING))
