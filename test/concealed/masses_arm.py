"""What an arm that is integrated from its pieces is made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from test.concealed.draws import Joints
from test.concealed.nominal import COMPLIANCE, COUNT, HALF_WIDTH, Array

STIFF = COMPLIANCE / 1000  # rad/(N m) of a wire that gives way to nothing
NEVER = 1e9


def _every(value: float) -> Callable[[], Array]:
    return lambda: np.full(COUNT, value)


@dataclass(frozen=True)
class Arm:
    """Arrays (5,), an entry per joint; the defaults are the nominal arm: friction, wires that do not stretch.

    before, after rad/(N m): compliance of the wire up to the capstan and behind it. capstan, joint N m: dry
    friction there. grip: share of the wire's moment by which the capstan's friction grows. static N m: what
    the joint's friction has more at rest, lost at speed (rad/s) after lag (s). bristle N m/rad: stiffness of
    the joint's friction before it slides, 0: rigid. drag N m s/rad. gap rad: play at the wheel. hard N m:
    moment at which the wire behind the capstan hardens. slack N m: load at which one wire of the pair hangs.
    creep rad/(N m), late s: by what the wire gives way more, and when. skin N m/rad: what pulls the joint to
    its middle. wheel: factor of its radius. zero rad. damped s: damping of the wires over their stiffness.
    route (5, 5): how much of another joint's angle a wire takes up. payload kg. light: links weigh the same,
    with so much less inertia. balanced: their weight is carried by something else. gain: of the drives'
    position loops over nominal. gives 1/(kg m²): one over the motors' inertia, where the loops do not make
    good what pulls.
    """

    before: Array = field(default_factory=lambda: STIFF.copy())
    after: Array = field(default_factory=lambda: STIFF.copy())
    capstan: Array = field(default_factory=lambda: HALF_WIDTH / STIFF)
    grip: Array = field(default_factory=_every(0.0))
    joint: Array = field(default_factory=_every(0.0))
    static: Array = field(default_factory=_every(0.0))
    speed: Array = field(default_factory=_every(0.05))
    bristle: Array = field(default_factory=_every(0.0))
    drag: Array = field(default_factory=_every(0.0))
    gap: Array = field(default_factory=_every(0.0))
    hard: Array = field(default_factory=_every(NEVER))
    slack: Array = field(default_factory=_every(NEVER))
    creep: Array = field(default_factory=_every(0.0))
    late: Array = field(default_factory=_every(1.0))
    skin: Array = field(default_factory=_every(0.0))
    wheel: Array = field(default_factory=_every(1.0))
    zero: Array = field(default_factory=_every(0.0))
    damped: Array = field(default_factory=_every(1e-3))
    lag: Array = field(default_factory=_every(0.05))
    route: Array = field(default_factory=lambda: np.zeros((COUNT, COUNT)))
    payload: float = 0.0
    light: float = 100.0
    balanced: bool = False
    gain: float = 1.0
    gives: float = 0.0

    @property
    def width(self) -> Array:
        """Half the dead band of the unloaded arm, rad (5,)."""
        out: Array = self.capstan * self.before + self.joint * (self.before + self.after)
        return out


ROWS = ("before", "after", "capstan", "grip", "joint", "static", "speed", "bristle", "drag", "gap", "hard",
        "slack", "creep", "late", "skin", "wheel", "zero", "damped", "lag")  # fmt: skip


def table_of(arm: Arm) -> Array:
    """Its pieces as rows (19, 5), in the order that the integration reads."""
    return np.stack([getattr(arm, name) for name in ROWS])


def shared_of(arm: Arm) -> Array:
    """What it has but once, (5,), likewise."""
    return np.array([arm.payload, arm.light, float(arm.balanced), arm.gain, arm.gives])


def having(arm: Arm, joints: Joints, **values: Array | float) -> Arm:
    """The arm with other pieces on some joints."""
    changed = {name: getattr(arm, name).copy() for name in values}
    for name, value in values.items():
        changed[name][list(joints)] = value
    return replace(arm, **changed)


def soft(arm: Arm, joints: Joints, compliance: Array, upstream: float) -> Arm:
    """Wires that stretch on some joints, with the dead band they had.

    upstream: the share of the compliance before the friction. 0: a capstan at the wheel rubs, 1: the joint
    itself, between: a capstan midway.
    """
    some = list(joints)
    width, stiff = arm.width[some], STIFF[some]
    if upstream >= 1:
        half = compliance / 2
        return having(arm, joints, before=half, after=half, capstan=0.0, joint=width / compliance)
    before = np.maximum(upstream * compliance, stiff)
    after = np.maximum(compliance - before, stiff)
    return having(arm, joints, before=before, after=after, capstan=width / before, joint=0.0)
