"""Where the numbers of a JointState or a PoseStamped lie in its bytes, in CDR (ROS 2) and as ROS 1 has it.

Messages of one publisher mostly have the same names and lengths, so the same layout: found in one message, it
reads thousands at once. `fixed` are the bytes that must agree for that.
"""

import struct
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from trunk_ros.errors import printable
from trunk_ros.recording.messages.block import Bytes

MOST_JOINTS = 1000  # damaged names are new joints, and each is a column
_LONGEST_NAME = 1000  # bytes


@dataclass(frozen=True)
class Field:
    """`count` numbers of 8 bytes from byte `start` on."""

    start: int
    count: int


@dataclass(frozen=True)
class Layout:
    """Byte positions in a message. order: "<" or ">". fixed: where lengths and names are, and `expected`."""

    order: str
    stamp: int
    joints: tuple[str, ...]
    position: Field
    velocity: Field
    effort: Field
    end: int
    fixed: npt.NDArray[np.intp]
    expected: Bytes
    frame: str = ""


class _Cursor:
    """Walks over one message; ValueError where it ends too early."""

    def __init__(self, data: bytes, encoding: str) -> None:
        self.data = data
        self.cdr = encoding == "cdr"
        self.order = "<"
        self.at = 0
        self.fixed: list[tuple[int, int]] = []
        if self.cdr:
            if len(data) < 4 or data[0] != 0 or data[1] > 1:
                raise ValueError("not plain CDR")
            self.order = "<" if data[1] else ">"
            self.at = 4
            self.fixed.append((0, 2))

    def align(self, width: int) -> None:
        if self.cdr:
            self.at += (4 - self.at) % width

    def take(self, width: int) -> int:
        """Start of the next `width` bytes, which are passed."""
        start, self.at = self.at, self.at + width
        if self.at > len(self.data):
            raise ValueError("message ends too early")
        return start

    def count(self) -> int:
        self.align(4)
        start = self.take(4)
        self.fixed.append((start, self.at))
        return int(struct.unpack_from(self.order + "I", self.data, start)[0])

    def name(self) -> str:
        size = self.count()
        start = self.take(size)
        if size > _LONGEST_NAME:
            raise ValueError("a name without end")
        self.fixed.append((start, self.at))
        return printable(self.data[start : self.at].rstrip(b"\0").decode())

    def header(self) -> tuple[int, str]:
        """Where the stamp is, and the frame; of the frame only the length has to be the same."""
        stamp = self.take(8) if self.cdr else self.take(12) + 4
        size = self.count()
        start = self.take(size)
        return stamp, self.data[start : min(self.at, start + _LONGEST_NAME)].rstrip(b"\0").decode(
            errors="replace"
        )

    def constant(self) -> tuple[npt.NDArray[np.intp], Bytes]:
        """Positions and values of the bytes that give the layout."""
        at = np.concatenate([np.arange(*each) for each in self.fixed])
        return at, np.frombuffer(self.data, dtype=np.uint8)[at]

    def numbers(self) -> Field:
        count = self.count()
        if count:
            self.align(8)
        return Field(self.take(8 * count), count)


def joint_layout(data: bytes, encoding: str) -> Layout:
    """Layout of one serialised JointState; encoding "cdr" or "ros1". ValueError if it is none."""
    cursor = _Cursor(data, encoding)
    stamp, frame = cursor.header()
    count = cursor.count()
    if count > MOST_JOINTS:
        raise ValueError("more joints than an arm has")
    joints = tuple(cursor.name() for _ in range(count))
    position, velocity, effort = (cursor.numbers() for _ in range(3))
    if not joints or "" in joints or len(set(joints)) < len(joints):
        raise ValueError("joint names are missing or repeated")
    if any(each.count not in (0, len(joints)) for each in (position, velocity, effort)):
        raise ValueError("not as many values as joint names")
    fields = position, velocity, effort, cursor.at, *cursor.constant(), frame
    return Layout(cursor.order, stamp, joints, *fields)


POSE_AXES = ("x", "y", "z", "qx", "qy", "qz", "qw")


def pose_layout(data: bytes, encoding: str) -> Layout:
    """Layout of one serialised PoseStamped: its seven numbers as `position`. ValueError if it is none."""
    cursor = _Cursor(data, encoding)
    stamp, frame = cursor.header()
    cursor.align(8)
    pose = Field(cursor.take(8 * len(POSE_AXES)), len(POSE_AXES))
    none = Field(cursor.at, 0)
    return Layout(cursor.order, stamp, POSE_AXES, pose, none, none, cursor.at, *cursor.constant(), frame)
