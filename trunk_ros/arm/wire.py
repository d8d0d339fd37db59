"""The paper's wire between gearbox and joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array


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
