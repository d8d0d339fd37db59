"""How much of the removable error a simulated recording removes, by the second nominal arm of this folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader

from test.concealed.nominal import JOINTS, Array, nominal_wire
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
    stamps, rows = [], []
    with AnyReader([bag]) as reader:
        wanted = [c for c in reader.connections if c.topic.strip("/") == topic]
        for where, _, raw in reader.messages(connections=wanted):
            message: Any = reader.deserialize(raw, where.msgtype)
            stamps.append(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)
            rows.append([message.position[message.name.index(joint)] for joint in JOINTS])
    return Angles(np.array(stamps, dtype=np.int64), np.array(rows))


def _at(stamp: NDArray[np.int64], known: NDArray[np.int64], angle: Array) -> Array:
    """Angles at other stamps, straight between the known ones."""
    t, here = (stamp - known[0]) * 1e-9, (known - known[0]) * 1e-9
    return np.stack([np.interp(t, here, column) for column in angle.T], axis=1)


def nominal_from_gearbox(bag: Path, stamp: NDArray[np.int64]) -> Array:
    """Nominal joint angle at the stamps, (n, 5) rad, from the recorded gearbox angle."""
    gearbox = read_angles(bag, "trunk/gearbox_states")
    fine = np.unique(np.concatenate([gearbox.stamp, stamp]))
    return _at(stamp, fine, nominal_wire(_at(fine, gearbox.stamp, gearbox.angle)))


def nominal_from_setpoints(bag: Path, stamp: NDArray[np.int64]) -> Array:
    """The same from the recorded setpoints: each holds until the next, also over a gap."""
    asked = read_angles(bag, "trunk/setpoints")
    ticks = int((max(asked.stamp[-1], stamp[-1]) - asked.stamp[0]) * 1e-9 / PERIOD) + 2
    grid = asked.stamp[0] + np.arange(ticks) * round(PERIOD * 1e9)
    held = asked.angle[np.searchsorted(asked.stamp, grid + 1000, side="right") - 1]
    phi, _ = run_servo((), held, 0.0)
    fine = asked.stamp[0] + np.arange(len(phi)) * round(PERIOD / SUB * 1e9)
    return _at(stamp, fine, nominal_wire(phi))


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
    nominal = (nominal_from_setpoints if source == "setpoints" else nominal_from_gearbox)(bag, shown.stamp)
    model = read_angles(predicted, "joint_states")
    after = _at(shown.stamp, model.stamp, model.angle)
    late = shown.stamp - shown.stamp[0] > SKIP * 1e9
    left = noise if clean is None else 0.0
    return _rms((nominal - truth)[late], left), _rms((after - truth)[late], left)
