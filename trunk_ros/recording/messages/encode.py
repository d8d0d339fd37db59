"""Series to serialised messages in bulk: the bytes of one message, with the numbers of each sample set in."""

import struct

import numpy as np

from trunk_ros.recording.messages.block import Bytes, Whole
from trunk_ros.recording.recording import Floats, JointSeries, PoseSeries


def encode_joints(series: JointSeries, stamp_ns: Whole) -> Bytes:
    """(n, bytes): a JointState in little-endian CDR per sample; stamp_ns: (n,) ns since the epoch."""
    message = _Template(stamp_ns)
    message.text("")
    message.count(len(series.joints))
    for joint in series.joints:
        message.text(joint)
    for values in (series.position, series.velocity, series.effort):
        message.count(0 if values is None else values.shape[1])
        if values is not None:
            message.numbers(values)
    return message.join()


def encode_poses(series: PoseSeries, stamp_ns: Whole) -> Bytes:
    """(n, bytes): a PoseStamped in little-endian CDR per sample."""
    message = _Template(stamp_ns)
    message.text(series.frame)
    message.numbers(np.hstack([series.position, series.orientation]))
    return message.join()


class _Template:
    """Columns of bytes that grow to the right; widths of all rows are the same."""

    def __init__(self, stamp_ns: Whole) -> None:
        self.rows = len(stamp_ns)
        self.parts: list[Bytes] = []
        self.width = 0
        self._constant(b"\x00\x01\x00\x00")
        self._columns((stamp_ns // 10**9).astype("<i4"))
        self._columns((stamp_ns % 10**9).astype("<u4"))

    def text(self, value: str) -> None:
        data = value.encode() + b"\0"
        self.count(len(data))
        self._constant(data)

    def count(self, value: int) -> None:
        self._align(4)
        self._constant(struct.pack("<I", value))

    def numbers(self, values: Floats) -> None:
        """(n, count) float64."""
        self._align(8)
        self._columns(values.astype("<f8"))

    def join(self) -> Bytes:
        return np.hstack(self.parts)

    def _align(self, width: int) -> None:
        self._constant(bytes((4 - self.width) % width))  # CDR counts from after its four bytes of head

    def _constant(self, data: bytes) -> None:
        self.parts.append(np.tile(np.frombuffer(data, dtype=np.uint8), (self.rows, 1)))
        self.width += len(data)

    def _columns(self, values: "np.typing.NDArray[np.generic]") -> None:
        part = np.ascontiguousarray(values).reshape(self.rows, -1).view(np.uint8)
        self.parts.append(part.reshape(self.rows, -1))
        self.width += part.shape[1]
