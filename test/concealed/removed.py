"""How much of the removable error a simulated recording removes, by the second nominal arm of this folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader

from test.concealed.hidden import Hidden
from test.concealed.nominal import COUNT, JOINTS, KP, V_MAX, Array, nominal_wire
from test.concealed.sensing import PERIOD
from test.concealed.servo import SUB, run_servo

SKIP = 3.0  # s that do not count: the play has not engaged


@dataclass(frozen=True)
class Angles:
    """Stamps (n,) ns and angles (n, 5) rad in the order joint_1 ... joint_5."""

    stamp: NDArray[np.int64]
    angle: Array


def read_angles(bag: Path, topic: str) -> Angles:
    """Positions of a JointState topic, whatever the order of its names."""
    with AnyReader([bag]) as reader:
        wanted = [c for c in reader.connections if c.topic.strip("/") == topic]
        raws = [(where.msgtype, raw) for where, _, raw in reader.messages(connections=wanted)]
        alike = _read_alike(reader, raws)
        if alike is not None:
            return alike
        return _joined([_one(reader.deserialize(raw, kind)) for kind, raw in raws])


def _one(message: Any) -> tuple[int, list[float]]:
    stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
    return stamp, [message.position[message.name.index(joint)] for joint in JOINTS]


def _joined(some: list[tuple[int, list[float]]]) -> Angles:
    return Angles(np.array([t for t, _ in some], dtype=np.int64), np.array([row for _, row in some]))


def _read_alike(reader: AnyReader, raws: list[tuple[str, bytes]]) -> Angles | None:
    """The same, many times faster, where all messages have the bytes of the first but for stamp and
    numbers.
    """
    if len(raws) < 2:
        return None
    kind, first = raws[0]
    message: Any = reader.deserialize(first, kind)
    at, size = _place_of_positions(first), 8 * len(message.position)
    same = first[12:at]
    if first[:2] != b"\x00\x01" or not all(len(raw) == len(first) and raw[12:at] == same for _, raw in raws):
        return None
    rows = np.frombuffer(b"".join(raw for _, raw in raws), np.uint8).reshape(len(raws), -1)
    seconds, parts = (rows[:, n : n + 4].copy().view("<u4")[:, 0].astype(np.int64) for n in (4, 8))
    position = rows[:, at : at + size].copy().view("<f8")
    order = [message.name.index(joint) for joint in JOINTS]
    return Angles(seconds * 10**9 + parts, position[:, order])


def _place_of_positions(raw: bytes) -> int:
    """Where the positions of a JointState begin in its CDR bytes: behind stamp, frame, names and their
    count.
    """

    def behind_text(at: int) -> int:
        at += -at % 4
        return at + 4 + int.from_bytes(raw[at : at + 4], "little")

    at = behind_text(12)
    at += -at % 4
    names, at = int.from_bytes(raw[at : at + 4], "little"), at + 4
    for _ in range(names):
        at = behind_text(at)
    at += -at % 4 + 4
    return at + -(at - 4) % 8  # numbers are aligned from the end of the four leading bytes on


def at_stamps(stamp: NDArray[np.int64], known: Angles) -> Array:
    """Angles at other stamps, straight between the known ones."""
    t, here = (stamp - known.stamp[0]) * 1e-9, (known.stamp - known.stamp[0]) * 1e-9
    return np.stack([np.interp(t, here, column) for column in known.angle.T], axis=1)


def servo_angles(bag: Path, own: tuple[float, float] = (KP, V_MAX)) -> Angles:
    """Gearbox angle of the nominal servo under the recorded setpoints: each holds until the next, over gaps
    too.

    own: Kp 1/s and top speed rad/s in the place of the nominal ones.
    """
    return servo_under(read_angles(bag, "trunk/setpoints"), own)


def servo_under(asked: Angles, own: tuple[float, float] = (KP, V_MAX)) -> Angles:
    """The same under setpoints that were read already, until half a second after the last."""
    ticks = int((asked.stamp[-1] - asked.stamp[0]) * 1e-9 / PERIOD) + 50
    grid = asked.stamp[0] + np.arange(ticks) * round(PERIOD * 1e9)
    held = asked.angle[np.searchsorted(asked.stamp, grid + 1000, side="right") - 1]
    hidden = (Hidden("servo_bandwidth", tuple(range(COUNT)), "gain", {"relative": own[0] / KP - 1}),
              Hidden("velocity_saturation", tuple(range(COUNT)), "clip", {"v_max": own[1]}))  # fmt: skip
    phi, _ = run_servo(hidden, held, 0.0)
    return Angles(asked.stamp[0] + np.arange(len(phi)) * round(PERIOD / SUB * 1e9), phi)


def nominal_angle(driven: Angles, stamp: NDArray[np.int64]) -> Array:
    """Nominal joint angle at the stamps, (n, 5) rad, from the gearbox angle."""
    fine = np.unique(np.concatenate([driven.stamp, stamp]))
    return at_stamps(stamp, Angles(fine, nominal_wire(at_stamps(fine, driven))))


def _rms(error: Array, noise: float) -> float:
    """Pooled over the joints, less what the noise of the comparison adds."""
    return float(np.sqrt(max((error**2).mean() - noise**2, 0.0)))


def removable(
    bag: Path, predicted: Path, clean: Array | None, source: str, noise: float
) -> tuple[float, float]:
    """Rms error before (nominal) and after (the predicted bag), rad, over a test run after its first 3 s.

    clean: the noise-free angle (n, 5) at the stamps of joint_states; None: the recorded one, whose noise (rad
    rms) is taken off. source: "gearbox_states" or "setpoints".
    """
    shown = read_angles(bag, "joint_states")
    truth = shown.angle if clean is None else clean
    driven = servo_angles(bag) if source == "setpoints" else read_angles(bag, "trunk/gearbox_states")
    nominal = nominal_angle(driven, shown.stamp)
    after = at_stamps(shown.stamp, read_angles(predicted, "joint_states"))
    late = shown.stamp - shown.stamp[0] > SKIP * 1e9
    left = noise if clean is None else 0.0
    return _rms((nominal - truth)[late], left), _rms((after - truth)[late], left)
