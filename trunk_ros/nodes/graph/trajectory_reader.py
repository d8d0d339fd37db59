"""JointTrajectories from their bytes: those with ten thousands of points must not stop the node's loop.

Where all points have the same numbers of values, and nearly always they do, all but the first lie at equal
distances, and one view reads them: 100 times as fast as rclpy, which makes an object of each.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.joint_state_reader import LITTLE_ENDIAN_CDR, aligned
from trunk_ros.nodes.graph.messages import nanoseconds, trajectory_of
from trunk_ros.nodes.graph.reader import unpacked
from trunk_ros.nodes.graph.ros import JointTrajectory
from trunk_ros.trajectory import Array, Trajectory

SEQUENCES = 4  # of a point: positions, velocities, accelerations, effort
MANY = 50  # points from which it pays


@dataclass(frozen=True)
class Order:
    """What a message asks for. ``begin`` [s]: its stamp, None on arrival; no ``trajectory``: stop."""

    begin: float | None
    trajectory: Trajectory | None


def read_order(raw: bytes) -> Order:
    """A message of its bytes [CDR]. Raises TrunkError for bytes that are none and points that do not fit."""
    try:
        return _read_regular(raw)
    except (IndexError, ValueError, struct.error):  # points that differ, and bytes that are no message
        return order_of(unpacked(raw, JointTrajectory))


def order_of(message: Any) -> Order:
    """An unpacked message. Raises TrajectoryError for points that do not fit together."""
    begin = nanoseconds(message.header.stamp) / SECOND or None
    return Order(begin, trajectory_of(message) if message.points else None)


def _read_regular(raw: bytes) -> Order:
    """Raises ValueError, IndexError or struct.error where the layout is another."""
    if raw[:4] != LITTLE_ENDIAN_CDR:
        raise ValueError
    begin = _pair(raw, 4)
    _, at = _text(raw, 12)
    number, at = _count(raw, at)
    if number > len(raw):
        raise ValueError
    joints = []
    for _ in range(number):
        joint, at = _text(raw, at)
        joints.append(joint)
    number, at = _count(raw, at)
    if number < MANY:
        raise ValueError
    time, sequences = _points(raw, at, number)
    position, velocity, acceleration = sequences[:3]
    given = [values if values.shape[1] else None for values in (velocity, acceleration)]
    return Order(begin or None, Trajectory(tuple(joints), time, position, *given))


def _points(raw: bytes, at: int, number: int) -> tuple[Array, list[Array]]:
    """Times (number,) s and the values of each sequence (number, count) of points that begin at ``at``."""
    counts, end = [], at
    for _ in range(SEQUENCES):
        count, end = _count(raw, end)
        end = _begin(end, count) + 8 * count
        counts.append(count)
    end += 8
    _, _, stop = _places(end, counts)
    stride = stop - end
    if not any(counts) or len(raw) < end + (number - 1) * stride:
        raise ValueError
    first = _cut(raw, at, 1, end - at, counts)
    others = _cut(raw, end, number - 1, stride, counts)
    time, *sequences = (np.concatenate(pair) for pair in zip(first, others, strict=True))
    return time, sequences


def _cut(raw: bytes, at: int, number: int, stride: int, counts: list[int]) -> list[Array]:
    """Times, and the values of each sequence, of points of equal length. Raises ValueError else."""
    rows = np.frombuffer(raw, np.uint8, number * stride, at).reshape(number, stride)

    def column(begin: int, size: int, kind: str) -> Any:
        return np.ascontiguousarray(rows[:, begin - at : begin - at + size]).view(kind)

    heads, bodies, end = _places(at, counts)
    for head, count in zip(heads, counts, strict=True):
        if (column(head, 4, "<u4") != count).any():
            raise ValueError
    seconds, rest = column(end - 8, 4, "<i4")[:, 0], column(end - 4, 4, "<u4")[:, 0]
    values = [column(body, 8 * count, "<f8") for body, count in zip(bodies, counts, strict=True)]
    return [seconds + rest / SECOND, *values]


def _places(at: int, counts: list[int]) -> tuple[list[int], list[int], int]:
    """Where the counts and values of a point are that begins at ``at``, and where it ends."""
    heads, bodies = [], []
    for count in counts:
        heads.append(at)
        bodies.append(_begin(at + 4, count))
        at = bodies[-1] + 8 * count
    return heads, bodies, at + 8


def _begin(at: int, count: int) -> int:
    return aligned(at, 8) if count else at


def _count(raw: bytes, at: int) -> tuple[int, int]:
    at = aligned(at, 4)
    return struct.unpack_from("<I", raw, at)[0], at + 4


def _text(raw: bytes, at: int) -> tuple[str, int]:
    length, at = _count(raw, at)
    return raw[at : at + length - 1].decode(), at + length


def _pair(raw: bytes, at: int) -> float:
    seconds, rest = struct.unpack_from("<iI", raw, at)
    return float(seconds + rest / SECOND)
