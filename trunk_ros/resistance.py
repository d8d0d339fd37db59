"""The moment that a recording shows on the joints, beside or in place of the computed weight.

``arm.load`` says which: ``weight`` alone; ``weight_and_inertia`` of the recorded motion; or ``effort``: on
each joint the moment that its own sensor tells, else the recorded torque of its motor less its friction, else
the weight. Where a recording has no effort, weight it is.
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
    states ``shown``, on the joints of which these have a load cell's effort.

    None where the arm's load is its weight alone, or nothing more is known.
    """
    if arm.load_from == "effort":
        cells = None if shown is None else load_cells(arm.joints, shown)
        told = tells(cells)
        if cells is None or not told.any():
            return None if gearbox.effort is None else carried(arm, gearbox, grid, phi * arm.ratio)
        assert shown is not None
        theta = phi * arm.ratio
        rest = weighed(arm, theta) if gearbox.effort is None else carried(arm, gearbox, grid, theta)
        measured = np.column_stack([np.interp(grid, shown.stamp, column) for column in fill(cells).T])
        return Resistance(np.where(told, measured, rest.moment), np.where(told, 0.0, rest.lever), False)
    if arm.load_from == "weight_and_inertia" and arm.has_load:
        return swung(arm, grid, phi)
    return None


def on_motors(
    arm: Arm, gearbox: JointSeries, grid: Array, phi: Array, shown: JointSeries | None = None
) -> Resistance | None:
    """The same for servos: these give way to all that their motors pull, friction and inertia as well, at the
    time at which they do; a joint's own sensor tells of its load alone.
    """
    if arm.load_from != "effort" or gearbox.effort is None:
        return resistance(arm, gearbox, grid, phi, shown)
    if shown is not None and tells(load_cells(arm.joints, shown)).any():
        return resistance(arm, gearbox, grid, phi, shown)
    pulled = -_at(grid, gearbox) / arm.ratio
    return Resistance(pulled, np.zeros_like(pulled), False)


def load_cells(joints: tuple[str, ...], shown: JointSeries) -> Array:
    """(n, joints) N m: effort of joint states, NaN where a joint has none."""
    out = np.full((len(shown.stamp), len(joints)), np.nan)
    for j, joint in enumerate(joints):
        if shown.effort is not None and joint in shown.joints:
            out[:, j] = shown.effort[:, shown.joints.index(joint)]
    return out


def tells(cells: Array | None) -> np.ndarray:
    """(joints,): whose effort ``cells`` (n, joints) is more than zeros or gaps."""
    return np.zeros(1, dtype=bool) if cells is None else np.any(np.nan_to_num(cells) != 0.0, axis=0)


def _at(grid: Array, series: JointSeries) -> Array:
    """(m, joints) N m: what effort a series has, at ``grid`` (m,) s."""
    assert series.effort is not None
    return np.column_stack([np.interp(grid, series.stamp, e) for e in fill(series.effort).T])


def weighed(arm: Arm, theta: Array) -> Resistance:
    """The computed weight at joint angles (n, joints), as all that there is."""
    lever = arm.lever(theta)
    return Resistance(arm.load(theta) - arm.payload * lever, lever, False)


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
    known, own = np.isfinite(measured), weighed(arm, theta)
    bare, lever = own.moment, own.lever
    if not arm.has_load:
        bare = -_at(grid, gearbox) / arm.ratio
    return Resistance(np.where(known, measured, bare), np.where(known, 0.0, lever), False)
