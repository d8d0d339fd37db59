"""The arm: geometry, the paper's wire, and the constants that effects share."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError
from trunk_ros.inertia import inertial_moments
from trunk_ros.moment import moments

GRAVITY = 9.81  # m/s^2, along -z
LOADS = ("weight", "weight_and_inertia", "effort")


@dataclass(frozen=True)
class Wire:
    """The paper's wire of each joint (Table 1), all arrays (joints,), SI units.

    Source: Ciofu & Stan, eq. (1)-(8); see docs/paper.md for what its tables leave out.
    """

    shaft_radius: float
    cylinder_radius: float
    modulus: float
    section: float
    pull_tension: float
    mu1: Array
    mu2: Array
    a1: Array
    a2: Array
    length: Array
    length1: Array
    length2: Array

    @property
    def ratio(self) -> float:
        """Joint angle per gearbox angle, R_s/R_c."""
        return self.shaft_radius / self.cylinder_radius

    @property
    def elongation(self) -> Array:
        """Stretch under the pull tension [m], eq. (6) with T' = T_i and T'' = T' exp(-mu1 a1)."""
        pulled = self.length1 + np.exp(-self.mu1 * self.a1) * self.length2
        return np.asarray(self.pull_tension * pulled / (self.modulus * self.section))

    @property
    def dead_band(self) -> Array:
        """Half-width of the play between gearbox and joint [rad]."""
        return self.elongation / self.cylinder_radius

    @property
    def compliance(self) -> Array:
        """Joint deflection per moment [rad/(N m)], l_i/(E A_s R_c^2)."""
        return np.asarray(self.length / (self.modulus * self.section * self.cylinder_radius**2))

    @property
    def efficiency(self) -> Array:
        """Force at the joint over force at the shaft, exp(-(mu1 a1 + mu2 a2)), eq. (3)-(5)."""
        return np.exp(-(self.mu1 * self.a1 + self.mu2 * self.a2))


@dataclass(frozen=True)
class Arm:
    """A serial wire-driven arm; per-joint values are (joints,) arrays, angles rad, SI units.

    ``link_length`` or ``link_mass`` may be empty: then there is no tip and no load to speak of.
    """

    joints: tuple[str, ...]
    ratio: Array
    dead_band: Array
    lower: Array
    upper: Array
    link_length: Array
    link_mass: Array
    compliance: Array
    payload: float = 0.0
    gravity: float = GRAVITY
    kp: float = 20.0
    tau_v: float = 0.02
    v_max: float = 1.5
    counts_per_rev: float = 131072.0
    wire: Wire | None = field(default=None)
    load_from: str = "weight"
    """One of LOADS: what the joints' moment is taken from. See trunk_ros/resistance.py."""

    def __post_init__(self) -> None:
        for name in ("ratio", "dead_band", "lower", "upper"):
            check_length(getattr(self, name), len(self.joints), name)
        for name in ("link_length", "link_mass", "compliance"):
            if len(getattr(self, name)):
                check_length(getattr(self, name), len(self.joints), name)

    @property
    def has_geometry(self) -> bool:
        """Whether link lengths are known, so that there is a tip."""
        return len(self.link_length) == len(self.joints) > 0

    @property
    def has_load(self) -> bool:
        """Whether weight can be computed from the posture."""
        return self.has_geometry and len(self.link_mass) == len(self.joints)

    def index(self, joint: str) -> int:
        """Column of a joint. Raises ModelError for a joint that the arm does not have."""
        if joint not in self.joints:
            raise ModelError(f"unknown joint {joint!r}: the model has {', '.join(self.joints)}")
        return self.joints.index(joint)

    def forward_kinematics(self, theta: Array) -> Array:
        """Tip [y m, z m, roll rad] (n, 3) of joint angles (n, joints): planar chain, base upright."""
        heading = np.cumsum(theta, axis=1)
        y = -(np.sin(heading) @ self.link_length)
        z = np.cos(heading) @ self.link_length
        return np.column_stack([y, z, heading[:, -1]])

    def load(self, theta: Array) -> Array:
        """Moment of the weight beyond each joint about it [N m], (n, joints), payload included.

        Positive where it tends to increase the joint angle. Zeros where the arm has no masses.
        """
        if not self.has_load:
            return np.zeros_like(theta)
        out = np.empty(theta.shape, order="F")
        moments(theta, self._weights, out)
        return out

    def lever(self, theta: Array) -> Array:
        """Moment about each joint per kilogram at the tip [N m/kg], (n, joints)."""
        out = np.zeros(theta.shape, order="F")
        if self.has_geometry:
            moments(theta, self.gravity * self.link_length, out)
        return out

    def inertia(self, theta: Array, speed: Array, acceleration: Array) -> Array:
        """Moment of inertia forces about each joint [N m], (n, joints), payload included: -(M q'' + C q').

        Positive where it tends to increase the joint angle. Zeros where the arm has no masses.
        """
        return self._inertia(theta, speed, acceleration, self.link_mass, self.payload)

    def inertial_lever(self, theta: Array, speed: Array, acceleration: Array) -> Array:
        """Moment of inertia forces about each joint per kilogram at the tip [N m/kg], (n, joints)."""
        return self._inertia(theta, speed, acceleration, 0.0 * self.link_mass, 1.0)

    def _inertia(self, theta: Array, speed: Array, acceleration: Array, mass: Array, tip: float) -> Array:
        out = np.zeros(theta.shape)
        if self.has_load:
            inertial_moments(theta, speed, acceleration, self.link_length, mass, tip, out)
        return out

    @cached_property
    def _weights(self) -> Array:
        """(joints,) N m: length of each link times the weight on its end, half of its own included."""
        on_end = self.link_mass[::-1].cumsum()[::-1] - self.link_mass / 2 + self.payload
        return np.asarray(self.gravity * on_end * self.link_length)

    def only(self, joints: tuple[str, ...]) -> Arm:
        """The same arm seen through some of its joints, in their order (without geometry: a chain cannot be
        cut).

        Raises ModelError for a joint that the arm does not have.
        """
        if joints == self.joints:
            return self
        columns = [self.index(joint) for joint in joints]
        cut = {name: getattr(self, name)[columns] for name in ("ratio", "dead_band", "lower", "upper")}
        if len(self.compliance):
            cut["compliance"] = self.compliance[columns]
        return replace(self, joints=joints, **cut, link_length=np.empty(0), link_mass=np.empty(0), wire=None)


def check_length(values: Array, joints: int, name: str) -> None:
    """Raise ModelError unless there is one value per joint."""
    if len(values) != joints:
        raise ModelError(f"{name} has {len(values)} values for {joints} joints: give one per joint")
