"""Messages that no sound node sends: on the right topics, of the right types, and bytes of no type at all."""

from __future__ import annotations

import random
from array import array
from typing import Any

import numpy as np

from test.nodes.graph import JOINTS

MARK = "hostile"  # frame of each, so that what a node answers can be told from it
TOPICS = (
    "trunk/setpoints",
    "trunk/reference",
    "trunk/gearbox_states",
    "joint_states",
    "trunk/joint_trajectory",
)
ODD = (float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 1e18, 1e6, -7.0, 5e-324)
NAMES = ("", "\x1b[31m", "joint_1", "elbow", "x" * 5000, "名前", "joint_1\0joint_2")


def message(topic: str, chance: random.Random, now: int) -> Any:
    """A message of the topic's type with something wrong in it, or with angles far from the last ones."""
    from trunk_ros.nodes.graph.ros import JointState, JointTrajectory, JointTrajectoryPoint

    names, rows = _names(chance), chance.choice((1, 1, 3, 200))
    if topic != "trunk/joint_trajectory":
        made = JointState(name=names, position=_numbers(len(names), chance))
        if chance.random() < 0.3:
            made.velocity = _numbers(chance.choice((len(names), 2)), chance)
            made.effort = _numbers(len(names), chance)
    else:
        made = JointTrajectory(joint_names=names)
        for k in range(rows):
            point = JointTrajectoryPoint(positions=_numbers(len(names), chance))
            point.time_from_start.sec = chance.choice((k, 0, -5, 2**31 - 1))
            made.points.append(point)
    made.header.frame_id = MARK
    made.header.stamp.sec, made.header.stamp.nanosec = _stamp(chance, now)
    return made


def _names(chance: random.Random) -> list[str]:
    kind = chance.random()
    if kind < 0.6:
        return list(JOINTS)
    if kind < 0.8:
        return chance.choices([*JOINTS, *NAMES], k=chance.choice((0, 1, 5, 40)))
    return chance.sample(JOINTS, k=chance.randint(1, 5))


def _numbers(count: int, chance: random.Random) -> Any:
    size = count if chance.random() < 0.8 else chance.choice((0, 1, 3, 1000))
    values = np.array([chance.uniform(-0.6, 0.6) for _ in range(size)])
    if size and chance.random() < 0.6:
        values[chance.randrange(size)] = chance.choice(ODD)
    return array("d", values.tolist())


def _stamp(chance: random.Random, now: int) -> tuple[int, int]:
    off = chance.choice((0, 0, 0, -3600, 10**6, -now // 10**9, 2**31 - 1 - now // 10**9))
    return min(max(now // 10**9 + off, 0), 2**31 - 1), chance.choice((now % 10**9, 0, 2**32 - 1))


def rubbish(chance: random.Random) -> bytes:
    """Bytes that are no message."""
    head = chance.choice((b"\x00\x01\x00\x00", b"\x00\x00\x00\x00", b"\xff\xff\xff\xff", b""))
    body = bytes(
        chance.choice((0, 255, chance.randrange(256))) for _ in range(chance.choice((0, 3, 40, 3000)))
    )
    return head + body
