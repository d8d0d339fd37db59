"""Gearbox angles in, sample by sample; joint readings, wires and tip out. Nothing here needs ROS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from trunk_ros.chain import Chain, State
from trunk_ros.effect_values import zeros_in
from trunk_ros.model import Model
from trunk_ros.nodes.graph.elapsed import SECOND, Elapsed
from trunk_ros.nodes.graph.joints import JointMatcher, MessageError
from trunk_ros.trajectory import Array

RESTART = SECOND  # ns that a stamp may be before the last one; more is a clock that was set back
JUST = 1e-3  # s in which a model that takes over comes to where the joints are


@dataclass(frozen=True)
class Shown:
    """What there is to see at a stamp: joints (joints,) rad, rad/s, N m; wires m, N; tip (7,) x, y, z m and
    quaternion x, y, z, w; ``true``: where the joints are, whatever their sensors show.

    Wires and tip are None where the model does not know them.
    """

    joints: Array
    velocity: Array
    effort: Array
    wires: tuple[Array, Array] | None
    tip: Array | None
    true: Array


class Wire:
    """A model's wires and links; memory of friction begins at its centre. Times are stamps [ns]."""

    def __init__(self, model: Model):
        self.joints = model.arm.joints
        self.motors = model.arm.motor_names
        self.matcher = JointMatcher(self.motors)
        self._phi = np.full(len(self.joints), np.nan)
        self._elapsed = Elapsed()
        self._last: tuple[int, Array] | None = None
        self._state: State | None = None
        self._seen: State | None = None
        self._use(model)
        still = np.zeros((2, len(self.joints)))
        self._wire.run(still, np.arange(2.0) / 100)  # compiles, so that no sample is late

    def _use(self, model: Model) -> None:
        self.model = model
        self._wire, self._tip = (Chain(model, stage, hold_time=True) for stage in ("wire", "arm"))
        self._zero = zeros_in(model.effects)

    def swap(self, model: Model) -> None:
        """Act by another model of the same arm, from where the joints are."""
        self._use(model)
        if self._state is not None:
            stamp = self._state.stamp
            stood, _ = self._wire.invert((self._state.angles + self._zero)[None], np.array([stamp - JUST]))
            path = np.array([stood[0], self._phi])  # under its load, not at what its ratio alone makes of it
            _, self._state = self._wire.run(path, np.array([stamp - JUST, stamp]))

    def complete(self, names: Sequence[str], position: Sequence[float]) -> Array:
        """Gearbox angles (joints,) rad; joints that a message leaves out keep their last angle.

        Raises MessageError where one is not known, and for what is no angle.
        """
        phi = self.matcher.angles(names, position)
        known = np.isfinite(phi)
        phi = phi if known.all() else np.where(known, phi, self._phi)
        if not known.all() and not np.isfinite(phi).all():
            raise MessageError(f"no angle yet of {self.motors[int(np.argmin(np.isfinite(phi)))]}")
        self._phi = phi
        return phi

    def begins_anew(self, stamp: int) -> bool:
        """Whether a stamp shows that the clock was set back. Raises MessageError for one just late."""
        if self._last is None or stamp > self._last[0]:
            return False
        if self._last[0] - stamp < RESTART:
            raise MessageError("gearbox_states out of order: a sample was left out")
        self._last = None
        return True

    def update(self, stamp: int, phi: Array) -> Shown:
        """What gearbox angles (joints,) rad make of the arm at a stamp."""
        at = np.array([self._elapsed.at(stamp)])
        (shown,), self._state = self._wire.run(phi[None], at, self._state)
        theta = self._state.angles + self._zero  # where the joints are, not what late sensors show
        effort = -self._wire.arm.load(theta[None])[0]
        last, self._last = self._last, (stamp, shown)
        speed = np.zeros_like(shown) if last is None else (shown - last[1]) * SECOND / (stamp - last[0])
        wires = wire_state(self.model.arm, phi, self._state.angles, effort)
        tip = None
        if self.model.arm.has_geometry:
            (tip,), self._seen = self._tip.run(theta[None], at, self._seen)
        return Shown(shown, speed, effort, wires, tip, theta)


def wire_state(arm: Any, phi: Array, theta: Array, effort: Array) -> tuple[Array, Array] | None:
    """Elongation [m] and tension [N] of the wires (joints,): lag of the joint, and pull plus load.

    ``theta``: joint angles [rad] from the gearbox's zero, since zeros that differ stretch no wire.
    """
    if arm.wire is None:
        return None
    stretch = arm.wire.cylinder_radius * (arm.driven(phi) - theta)
    return stretch, arm.wire.pull_tension + np.abs(effort) / arm.wire.cylinder_radius
