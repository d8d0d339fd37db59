"""What the effects of a chain see of the arm, worked out when one of them asks."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.effect import Now


class Look(Now):
    """``asked`` holds what the answers depended on, of "gearbox" and "angles": if it changes, they have to
    be worked out anew.
    """

    def __init__(
        self,
        arm: Arm,
        stamp: Array,
        path: Array,
        before: tuple[float, Array] | None = None,
        velocity: Array | None = None,
    ):
        """``path`` (n, joints): moves as the joints do, friction aside; ``before``: the sample before,
        stamp and path.

        ``velocity`` (n, joints): the gearbox's, where it is known; by default the slope of the path.
        """
        self.stamp, self.joints, self.ratio = stamp, arm.joints, arm.ratio
        self.dt = steps(stamp, before[0] if before else None)
        self._arm, self._path, self._before, self._velocity = arm, path, before, velocity
        self.see(path, path)

    def follow(self, path: Array) -> None:
        """Take another path (n, joints) for that of the joints."""
        self._path = path
        self.__dict__.pop("speed", None)

    def see(self, gearbox: Array, angles: Array) -> None:
        """Look at a better estimate (n, joints) of both."""
        self._seen = {"gearbox": gearbox, "angles": angles}
        self.asked: set[str] = set()
        for name in ("gearbox", "angles", "wires", "load"):
            self.__dict__.pop(name, None)

    def __getattr__(self, name: str) -> Array:
        """Called for what is not there yet."""
        if name in ("gearbox", "angles"):
            self.asked.add(name)
            value = self._seen[name]
        elif name == "wires":
            value = self.gearbox * self.ratio
        elif name == "load":
            value = self._arm.load(self.angles)
        elif name == "speed":
            value = self._slope() if self._velocity is None else self._velocity * self.ratio
        else:
            raise AttributeError(name)
        self.__dict__[name] = value
        return value

    def _slope(self) -> Array:
        """(n, joints) rad/s since the sample before; 0 where no time has passed."""
        out = np.empty_like(self._path)
        before = self._path[0] if self._before is None else self._before[1]
        slope(self._path, self.dt, before, out)
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
