"""The moment that a recording shows on the joints, beside or in place of the computed weight.

``arm.load`` says which: ``weight`` alone; ``weight_and_inertia`` of the recorded motion; or ``effort``, the
moment that the joints' own sensors tell, else the recorded torque of the motors less their friction. Where a
recording has no effort, weight it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.derivatives import smooth
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.effort import measured_load
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.fill import fill


@dataclass(frozen=True)
class Resistance:
    """What a recording tells of the load, whatever the payload; (n, joints) each."""

    moment: Array
    """N m beside the weight, or all that there is."""
    lever: Array
    """N m/kg that a kilogram at the tip adds to ``moment``."""
    weighs: bool
    """Whether the weight comes on top."""

    def load(self, arm: Arm, theta: Array) -> Array:
        """Moment on the joints [N m] at joint angles (n, joints)."""
        own = self.moment + arm.payload * self.lever
        return arm.load(theta) + own if self.weighs else own

    def per_kilogram(self, arm: Arm, theta: Array) -> Array:
        """(n, joints) N m/kg of load that a kilogram at the tip adds; ``theta`` (n, joints) joint angles."""
        return arm.lever(theta) + self.lever if self.weighs else self.lever

    def part(self, rows: slice | np.ndarray) -> Resistance:
        """Some of the rows."""
        return Resistance(self.moment[rows], self.lever[rows], self.weighs)


def resistance(
    arm: Arm, gearbox: JointSeries, grid: Array, phi: Array, shown: JointSeries | None = None
) -> Resistance | None:
    """What gearbox states tell of the load at gearbox angles ``phi`` (m, joints) on ``grid`` (m,); joint
    states ``shown``, where these have a load cell's effort of all joints.

    None where the arm's load is its weight alone, or nothing more is known.
    """
    cells = None if shown is None or not set(arm.joints) <= set(shown.joints) else shown.select(arm.joints)
    if arm.load_from == "effort" and cells is not None and _tell(cells.effort):
        moment = _at(grid, cells)
        return Resistance(moment, np.zeros_like(moment), False)
    if arm.load_from == "effort" and gearbox.effort is not None:
        return carried(arm, gearbox, grid, phi * arm.ratio)
    if arm.load_from == "weight_and_inertia" and arm.has_load:
        return swung(arm, grid, phi)
    return None


def _tell(effort: Array | None) -> bool:
    return effort is not None and bool(np.any(np.nan_to_num(effort)))


def _at(grid: Array, series: JointSeries) -> Array:
    """(m, joints) N m: what effort a series has, at ``grid`` (m,) s."""
    assert series.effort is not None
    return np.column_stack([np.interp(grid, series.stamp, e) for e in fill(series.effort).T])


def swung(arm: Arm, grid: Array, phi: Array) -> Resistance:
    """Moment of inertia forces of joints that follow gearbox angles (m, joints) through the nominal play."""
    theta, _ = SharpPlay().run(phi, arm.dead_band[None], None, arm.ratio)
    motion = smooth(grid, theta)
    bare = arm.inertia(*motion) - arm.payload * arm.inertial_lever(*motion)
    return Resistance(bare, arm.inertial_lever(*motion), True)


def carried(arm: Arm, gearbox: JointSeries, grid: Array, theta: Array) -> Resistance:
    """The motors' torque without friction; the computed weight where a joint's torque does not tell, and
    for arms without masses the torque as it is. ``theta`` (n, joints) rad, at ``grid`` (n,) s.
    """
    moment = measured_load(gearbox, arm.ratio, arm).moment
    measured = np.column_stack([np.interp(grid, gearbox.stamp, column) for column in moment.T])
    known, lever = np.isfinite(measured), arm.lever(theta)
    bare = arm.load(theta) - arm.payload * lever
    if not arm.has_load:
        bare = -_at(grid, gearbox) / arm.ratio
    return Resistance(np.where(known, measured, bare), np.where(known, 0.0, lever), False)
