"""Setpoints in, checked; the state of the gearbox shafts out. Nothing here needs ROS."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.nodes.bus import Bus, Sample, gearbox_limits, within
from trunk_ros.nodes.graph.elapsed import Elapsed
from trunk_ros.nodes.graph.joints import JointMatcher, MessageError
from trunk_ros.trajectory import Array

ROUNDING = 1e-9  # rad


class Servo:
    """Hands what is safe to a bus, and holds the last safe setpoint [rad at the gearbox]. Times are ns."""

    def __init__(self, arm: Arm, bus: Bus):
        self.arm, self.joints, self.bus = arm, arm.motor_names, bus
        self.matcher = JointMatcher(self.joints)
        self.lower, self.upper = gearbox_limits(arm)
        self.asked: Array | None = None
        self.shaft: Array | None = None
        self._elapsed = Elapsed()

    def update(self, now: int) -> Sample:
        """Read the shafts. Raises TrunkError where the motors do not answer, or with nonsense."""
        sample = self.bus.read(self._elapsed.at(now))
        if not np.isfinite(sample.position).all():
            j = int(np.argmin(np.isfinite(sample.position)))
            raise MessageError(f"the motors say no number for {self.joints[j]}")
        self.shaft = sample.position
        return sample

    def ask(self, names: Sequence[str], position: Sequence[float], stamp: int) -> list[str]:
        """Check setpoints by name and hand them on; returns oddities. Raises MessageError where refused."""
        given = self.matcher.gather(names, position)
        named = self._given(given, len(position) > 0)
        setpoint = given if named.all() else np.where(named, given, self._last())
        self._check(setpoint)
        self.asked = setpoint
        self.bus.write(setpoint, self._elapsed.of(stamp))
        return self.matcher.oddities()

    def _given(self, given: Array, filled: bool) -> Array:
        """Which joints the message speaks of. Raises MessageError for a value that is no number."""
        named = np.array([filled and joint not in self.matcher.missing for joint in self.joints])
        if not np.isfinite(given[named]).all():
            j = int(np.argmax(named & ~np.isfinite(given)))
            raise MessageError(f"setpoint refused: {self.joints[j]} is not a number")
        return named

    def _last(self) -> Array:
        """What joints that a setpoint leaves out are held at. Raises MessageError while that is not known."""
        last = self.shaft if self.asked is None else self.asked
        if last is None:
            raise MessageError("setpoint refused: it leaves out joints whose position is unknown so far")
        return last

    def _check(self, setpoint: Array) -> None:
        """Raise MessageError for a setpoint (joints,) outside the limits."""
        out = ~((setpoint >= self.lower - ROUNDING) & (setpoint <= self.upper + ROUNDING))
        if out.any():
            j = int(np.argmax(out))
            raise MessageError(
                f"setpoint refused: {self.joints[j]} at {setpoint[j]:.4f} rad is outside "
                f"{self.lower[j]:.4f} ... {self.upper[j]:.4f}; holding the last safe one"
            )
        over = np.abs(within(setpoint, self.arm) - setpoint) > ROUNDING
        if over.any():
            j = int(np.argmax(over))
            raise MessageError(
                f"setpoint refused: {self.joints[j]} at {setpoint[j]:.4f} rad would move a joint outside its "
                "limits; holding the last safe one"
            )
