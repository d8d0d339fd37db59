"""What the effects of a chain see of the arm, worked out when one of them asks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array, compiled
from trunk_ros.derivatives import follow
from trunk_ros.effects.effect import Now
from trunk_ros.effects.moments import NOTHING, Payload
from trunk_ros.resistance import Resistance


@dataclass(frozen=True)
class Given:
    """What is known of the motion besides its angles."""

    velocity: Array | None = None
    """(n, joints) rad/s of the gearbox; by default the slope of its angle."""
    resistance: Resistance | None = None
    """By default the load is computed from the angles."""

    def part(self, rows: slice) -> Given:
        """Some of the rows."""
        return Given(
            None if self.velocity is None else np.asfortranarray(self.velocity[rows]),
            None if self.resistance is None else self.resistance.part(rows),
        )


UNKNOWN = Given()


class Look(Now):
    """``asked`` holds what the answers depended on, of "gearbox", its speed on the way back ("winding"), and
    "angles": if it changes, they have to be worked out anew.
    """

    def __init__(
        self,
        arm: Arm,
        stamp: Array,
        path: Array,
        before: tuple[float, Array] | None = None,
        given: Given = UNKNOWN,
        swing: Array | None = None,
        carried: Payload = NOTHING,
    ):
        """``path`` (n, joints): moves as the joints do, friction aside; ``before``: the sample before,
        stamp and path. ``swing``: memory of the joints' motion, None at the start of a recording.
        ``carried``: what is taken up and put down, besides the arm's own payload.
        """
        self.stamp, self.joints, self.ratio = stamp, arm.joints, arm.ratio
        self.dt = steps(stamp, before[0] if before else None)
        self.columns = tuple(range(len(arm.joints)))
        self._arm = self.arm = arm
        self._path, self._before, self._given, self.carried = path, before, given, carried
        ahead = 0.0 if before is None or swing is None else swing[0] - before[1]
        self._joint_path, self._swing = path + ahead, swing
        self._wound: tuple[Array, Array] | None = None
        self.see(path, path)

    def winds(self, gearbox: Array, before: Array) -> None:
        """On the way back only the joints' path is known: the speed of the gearbox is that of this estimate
        (n, joints) rad, after it stood at ``before`` (joints,) rad.
        """
        self._wound = gearbox, before

    @property
    def winding(self) -> Array:
        if self._wound is None:
            return self.speed
        self.asked.add("winding")
        gearbox, before = self._wound
        return slope_of(gearbox * self.ratio, self.dt, before * self.ratio)

    def follow(self, path: Array) -> None:
        """Take another path (n, joints) for that of the joints."""
        self._path = path
        for name in ("speed", "speeds"):
            self.__dict__.pop(name, None)
        self.swing_along(path)

    def swing_along(self, path: Array) -> float:
        """Have the links accelerate as this path (n, joints) does, where their inertia counts; how far it is
        from the one before [rad], if that one has been looked at.
        """
        if not self._inertial:
            return 0.0
        moved = float(np.abs(path - self._joint_path).max()) if "motion" in self.__dict__ else 0.0
        self._joint_path = path
        for name in ("motion", "load"):
            self.__dict__.pop(name, None)
        return moved

    @property
    def swing(self) -> Array | None:
        """Memory of the joints' motion after the last sample."""
        return self.motion[2] if self._inertial else None

    @property
    def _inertial(self) -> bool:
        return self._arm.load_from == "weight_and_inertia" and self._given.resistance is None

    def see(self, gearbox: Array, angles: Array) -> None:
        """Look at a better estimate (n, joints) of both."""
        self._seen = {"gearbox": gearbox, "angles": angles}
        self.asked: set[str] = set()
        for name in ("gearbox", "angles", "wires", "load"):
            self.__dict__.pop(name, None)

    def has_told(self, name: str) -> bool:
        """Whether an effect asked for something."""
        return name in self.__dict__

    def __getattr__(self, name: str) -> Any:
        """Called for what is not there yet."""
        value: Any
        if name in ("gearbox", "angles"):
            self.asked.add(name)
            value = self._seen[name]
        elif name == "wires":
            value = self.gearbox * self.ratio
        elif name == "load":
            value = self._moment()
        elif name == "motion":
            value = self._motion()
        elif name == "speed":
            velocity = self._given.velocity
            value = self._slope() if velocity is None else velocity * self.ratio
            if velocity is None and self._arm.coupling is not None:  # the path is the joints'
                value = self._arm.asked(value)
        elif name == "speeds":
            value = self.speed
        else:
            raise AttributeError(name)
        self.__dict__[name] = value
        return value

    def _moment(self) -> Array:
        """(n, joints) N m on the joints, from what the arm's ``load`` says; on motors that move several."""
        if self._given.resistance is not None:
            load = self._given.resistance.load(self._arm, self.angles)
        else:
            load = self._arm.load(self.angles)
            if self._inertial:
                speed, acceleration, _ = self.motion
                load = load + self._arm.inertia(self.angles, speed, acceleration)
        if self.carried.mass:
            load = load + self.carried.at(self.stamp) * self._lever()
        return load if self._arm.coupling is None else self._arm.carried(load)

    def _lever(self) -> Array:
        """(n, joints) N m/kg that a kilogram more at the tip adds."""
        known = self._given.resistance
        return self._arm.lever(self.angles) if known is None else known.per_kilogram(self._arm, self.angles)

    def _motion(self) -> tuple[Array, Array, Array]:
        """Speed and acceleration (n, joints) of the joints from the past alone, and the memory after them."""
        path = self._joint_path
        memory = np.repeat(path[:1], 3, axis=0) if self._swing is None else self._swing.copy()
        speed, acceleration = np.empty_like(path), np.empty_like(path)
        follow(path, self.dt, memory, speed, acceleration)
        return speed, acceleration, memory

    def _slope(self) -> Array:
        """(n, joints) rad/s since the sample before; 0 where no time has passed."""
        return slope_of(self._path, self.dt, self._path[0] if self._before is None else self._before[1])


def slope_of(path: Array, dt: Array, before: Array) -> Array:
    """(n, columns) rad/s of a path since the sample before; 0 where no time has passed."""
    out = np.empty_like(path)
    slope(path, dt, before, out)
    return out


@compiled
def slope(x: Array, dt: Array, before: Array, out: Array) -> None:
    """Backward difference of ``x`` (n, columns) over ``dt`` (n,); 0 where no time has passed."""
    steps, columns = x.shape
    for j in range(columns):
        last = before[j]
        for k in range(steps):
            out[k, j] = (x[k, j] - last) / dt[k] if dt[k] > 0.0 else 0.0
            last = x[k, j]


def steps(stamp: Array, before: float | None) -> Array:
    """(n,) s since the sample before; 0 at the very first."""
    if len(stamp) == 1 and before is not None:
        return stamp - before
    dt = np.empty_like(stamp)
    np.subtract(stamp[1:], stamp[:-1], out=dt[1:])
    dt[0] = 0.0 if before is None else stamp[0] - before
    return dt
