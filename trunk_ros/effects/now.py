"""What an effect may see of the arm, what a motion is like, and how what an effect does is shown."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.effects.moments import NOTHING, Payload

Made = TypeVar("Made")


@dataclass
class Now:
    """What an effect may look at besides its input; time runs along axis 0, joints along axis 1.

    ``angles`` holds all joints of the arm (columns named by ``joints``), the rest the joints being computed.
    """

    stamp: Array
    """(n,) s since the first sample of the recording."""
    dt: Array
    """(n,) s since the sample before; 0 at the very first."""
    gearbox: Array
    """(n, columns) rad."""
    speed: Array
    """(n, columns) rad/s, on the joint side."""
    load: Array
    """(n, columns) N m, weight's moment, positive where it increases the angle."""
    angles: Array
    """(n, all joints) rad."""
    wires: Array
    """(n, all joints) rad, ratio times gearbox angle."""
    joints: tuple[str, ...]
    ratio: Array
    """(columns,) joint angle per gearbox angle."""
    held: bool = False
    """Whether time stands at the end of the recording that the model was fitted on."""
    speeds: Array = field(default_factory=lambda: np.empty((0, 0)))
    """(n, all joints) rad/s, like ``speed``."""
    columns: tuple[int, ...] = ()
    """Places of the joints being computed among all ``joints``."""
    arm: Arm | None = None
    """With the payload that it carries; None where its links' masses are of no account."""
    carried: Payload = NOTHING
    """What it takes up and puts down besides."""
    grain: float = 0.0
    """rad from one reading of the joint's own encoder to the next, 0 where they lie on no grid."""
    unseen: Array = field(default_factory=lambda: np.empty((0, 2)))
    """(k, 2) s between which nobody saw the motor: ``gearbox`` is a guess there."""

    def speed_of(self, joint: int) -> Array:
        """(n,) rad/s of one of all joints."""
        return self.speeds[:, joint]

    @property
    def winding(self) -> Array:
        """(n, columns) rad/s, like ``speed``; but where the way goes from the joints to the gearbox it is the
        gearbox's still, not the joints'.
        """
        return self.speed

    def travelled(self, before: Array | None) -> Array:
        """(n, columns) rad that each joint has travelled to and fro by each sample, after those ``before``:
        by its motor where that is known, and by itself where the way goes back to the motor, which is less by
        a dead band at each reversal.
        """
        return np.asarray(
            np.cumsum(np.abs(self.speed) * self.dt[:, None], axis=0) + (0.0 if before is None else before)
        )

    @cached_property
    def masses(self) -> Array:
        """M (n, all joints, all joints) kg m^2 of the arm at ``angles``."""
        return self.masses_at(self.angles)

    def masses_at(self, angles: Array) -> Array:
        """The same of all joints at ``angles`` (m, all joints), at the first m samples."""
        assert self.arm is not None
        own = self.arm.mass_matrix(angles)
        if not self.carried.mass:
            return own
        more = self.carried.at(self.stamp[: len(angles)])
        return np.asarray(own + more[:, :, None] * self.arm.mass_lever(angles))

    def inertia(self, joint: int) -> Array:
        """(n, all joints) a joint's row of that."""
        return np.ascontiguousarray(self.masses[:, joint])

    def cached(self, what: Hashable, make: Callable[[], Made]) -> Made:
        """What ``make`` makes of angles and masses alone; where these are looked at again and again, once."""
        return make()

    def of_load(self, what: Hashable, make: Callable[[Array], Array]) -> Array:
        """What ``make`` makes of the load alone, (n, columns): the last is kept, as both sides of the
        friction ask for it, and a fit again with other values besides.
        """
        load, kept = self.load, vars(self).get("_of_load")
        if kept is None or kept[0] != what or kept[1] is not load:
            kept = vars(self)["_of_load"] = what, load, make(load)
        return np.asarray(kept[2])


def borne(load: Array) -> float:
    """Size [N m] of what a joint bears (n,)."""
    return float(np.sqrt(np.mean(load**2)))


UNTOLD = ("reversal", "hold", "time")  # regimes of which a joint that goes on and on shows nothing


@dataclass(frozen=True)
class Motion:
    """What a joint's motion is like, for what can be told from it."""

    wide_loop: bool = False
    """Always alike, with a wide loop: it hides what else varies with speed or time."""
    one_way: bool = False
    """It never comes back."""
    once: bool = False
    """It shows a wide loop, and goes through none of it twice."""
    masses: bool = True
    """Those of the links are known, and their inertia is in no load yet."""
    bears: bool = True
    """It bears a load, which is known."""
    rests: bool = False
    """Its motor does: others, the load or time may move it."""
    holds: bool = False
    """Its motor rests for a good part of the recording: posture is no reason for what goes on meanwhile."""

    @property
    def untold(self) -> tuple[str, ...]:
        """Regimes of which it shows nothing."""
        if self.one_way and self.holds:
            return ("reversal", "time")  # creep goes by the move, drift by nothing seen
        return UNTOLD if self.one_way else ("time",) if self.once else ()


@dataclass(frozen=True)
class View:
    """Over what a residual is drawn; ``along``: errors count in the direction of motion; ``window`` s are
    shown (0: all).
    """

    over: str
    along: bool = False
    window: float = 0.0
