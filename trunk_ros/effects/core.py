"""What a stage's own mechanism is set to."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trunk_ros.arm import Wire
from trunk_ros.arm.geometry import Geometry
from trunk_ros.compiled import Array

# Made once, and changed by nobody: a core is made at every look at a joint.
NONE, NO_TURN, NO_PAIR = np.empty(0), np.empty((0, 3)), np.empty((0, 2, 3))
AS_DESCRIBED = Geometry.nominal(0)
AS_DESCRIBED.base.flags.writeable = AS_DESCRIBED.tool.flags.writeable = False


@dataclass
class Core:
    """The settings of a stage's own mechanism, which effects of that stage may change.

    Wire: half-widths of the play and how a reversal is rounded. Servo: the loop. Arm: its geometry.
    """

    nominal_width: Array = field(default_factory=lambda: NONE)
    width: Array = field(default_factory=lambda: NONE)
    """(1 or n, columns) rad, half-width of the play."""
    middle: Array | float = 0.0
    """(1 or n, columns) rad by which a joint in the middle of its play is ahead of the wire."""
    rounding: Any = None
    """A friction element in the place of the sharp play: an object with ``run`` and ``invert``."""
    wire: Wire | None = None
    """The paper's wire, where the arm has one."""
    old: dict[str, Any] = field(default_factory=dict)
    """Memory, by ID, of wire effects that change the core; what comes after goes into ``new``."""
    new: dict[str, Any] = field(default_factory=dict)
    kp: Array = field(default_factory=lambda: NONE)
    tau_v: Array = field(default_factory=lambda: NONE)
    v_max: Array = field(default_factory=lambda: NONE)
    uneven: Array = field(default_factory=lambda: NONE)
    """(1 or n, columns) share of the top speed by which it is higher upwards, and lower downwards."""
    delay: Array = field(default_factory=lambda: NONE)
    feedforward: Array = field(default_factory=lambda: NONE)
    ahead: float = 0.0
    """Part of a step by which the loop sees its shaft go on, as in ``servo_loop``."""
    pull: Array = field(default_factory=lambda: NONE)
    """(1 or n, columns) rad added to the setpoint; the other numbers of the loop likewise."""
    load: Array = field(default_factory=lambda: NONE)
    """(1 or n, columns) rad of the setpoint by which the load on the joint pulls the servo."""
    torque: Array = field(default_factory=lambda: NONE)
    """(1 or n, columns) share of load and friction that acts past the top speed that the loop asks for."""
    rub: Array = field(default_factory=lambda: NONE)
    """(1 or n, columns) rad by which the friction of wires that slide holds the servo back."""
    reach: Array = field(default_factory=lambda: NONE)
    """(columns,) rad that the servo goes from the middle of the wires' dead band until they slide."""
    dead_zone: Array = field(default_factory=lambda: NONE)
    """(1 or n, columns) rad of error that the loop does not answer to."""
    cogging: Array = field(default_factory=lambda: NONE)
    """(1 or n, columns) rad: how high the servo's own swing is."""
    teeth: Array = field(default_factory=lambda: NONE)
    """(2, 1, columns): cycles of that per revolution, and its phase rad."""
    lowest: Array | float = -np.inf
    """(columns,) rad: the least setpoint that the drive takes, and ``highest`` the largest."""
    highest: Array | float = np.inf
    quickest: Array = field(default_factory=lambda: NONE)
    """(1, columns) rad/s at which the drive moves its own setpoint to that it got; inf: at once."""
    ramp: Array = field(default_factory=lambda: NONE)
    """(1, columns) rad/s^2 by which the speed of that changes; inf: at once."""
    dry: Array = field(default_factory=lambda: NONE)
    """(1 or n, columns) rad of error that the motor's own dry friction holds."""
    hardest: Array = field(default_factory=lambda: NONE)
    """(1, columns) rad/s^2 by which the servo's speed changes at most; inf: as its loop asks."""
    ki: Array = field(default_factory=lambda: NONE)
    """(1, columns) 1/s^2: gain of the integral part of the position loop."""
    windup: Array = field(default_factory=lambda: NONE)
    """(1, columns) rad/s beyond the top speed up to which that sums up."""
    speed_ki: Array = field(default_factory=lambda: NONE)
    """(1, columns) 1/s: how fast the loop of the speed sums up its own error."""
    geometry: Geometry = field(default_factory=lambda: AS_DESCRIBED)
    along: Array = field(default_factory=lambda: NO_TURN)
    """(joints, 3) unit vectors from each joint to the next, in the joint's frame."""
    across: Array = field(default_factory=lambda: NO_PAIR)
    """(joints, 2, 3) unit vectors across those."""
    beside: Array = field(default_factory=lambda: NO_PAIR)
    """(joints, 2, 3) unit vectors across each joint's axis."""
    bent: Array | float = 0.0
    """(n, joints) rad or m that the tip has more of each joint than its sensor shows."""

    @property
    def bounded(self) -> bool:
        """Whether the drive takes some setpoints for others."""
        return bool(np.any(self.lowest > -np.inf) or np.any(self.highest < np.inf))

    @property
    def tops(self) -> tuple[Array, Array]:
        """(1 or n, columns) rad/s: the top speeds of the loop upwards and downwards; behind profiles none."""
        return up_and_down(np.where(self.ramp < np.inf, np.inf, self.v_max), self.uneven)

    @property
    def paces(self) -> Array:
        """(1 or n, columns) rad/s at which the drive moves its own setpoint: a profile has the top speed."""
        return np.minimum(self.quickest, np.where(self.ramp < np.inf, self.v_max, np.inf))

    @property
    def told(self) -> Array:
        """(1 or n, columns) s by which a drive that moves its own setpoint on feeds its loop the speed of
        that, and not of those it gets.
        """
        leads = np.minimum(self.quickest, self.ramp) < np.inf
        return np.where(leads, self.feedforward / self.kp, 0.0)


def up_and_down(v_max: Array, uneven: Array) -> tuple[Array, Array]:
    """Top speeds [rad/s] upwards and downwards of servos that are that share of ``v_max`` faster upwards."""
    return v_max * (1.0 + uneven), v_max * (1.0 - uneven)
