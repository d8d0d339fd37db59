"""What people do instead: refit the nominal arm's own parameters, here ratio and dead band of every joint.

The trap is that they take in physics that is missing: the fitted run looks better, the next one may not.
Where the servo is at stake, its gain and top speed are fitted too.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from test.concealed.nominal import COUNT, HALF_WIDTH, KP, RATIO, V_MAX, Array, play
from test.concealed.removed import at_stamps, read_angles, servo_under
from test.concealed.seen import Seen

WEAK = 1e-4  # mrad², about the encoder's rounding


def _wire(phi: Array, ratio: Array, width: Array) -> Array:
    u: Array = ratio * phi
    both = np.broadcast_to(np.abs(width), u.shape).copy()
    out: Array = play(u, both, both, u[0].copy())
    return out


def _sought(misfit: Callable[[Array], float], step: tuple[float, float], rounds: int) -> Array:
    """Two factors, from (1, 1), with the least misfit."""
    simplex = np.array([[1.0, 1.0], [1.0 + step[0], 1.0], [1.0, 1.0 + step[1]]])
    how = {"initial_simplex": simplex, "maxiter": rounds}
    out: Array = minimize(misfit, simplex[0], method="Nelder-Mead", options=how).x
    return out


class Refit:
    """Ratio and dead band (5,) with the least squares of the joint readings."""

    def __init__(self, seen: Seen):
        best = np.empty((2, COUNT))
        for j in range(COUNT):

            def misfit(x: Array, j: int = j) -> float:
                phi = seen.fine_phi[:, [j]]
                said = _wire(phi, x[:1] * RATIO, x[1:] * HALF_WIDTH[j])[seen.fine_place, 0]
                return float(((said - seen.shown[:, j])[seen.late] ** 2).mean() * 1e6)

            best[:, j] = _sought(misfit, (0.02, 0.5), 120)
        self.ratio, self.width = RATIO * best[0], np.abs(best[1]) * HALF_WIDTH

    def residual(self, seen: Seen) -> Array:
        """(n, 5) rad to add to the nominal angle of another recording."""
        return _wire(seen.fine_phi, self.ratio, self.width)[seen.fine_place] - seen.nominal


def refitted_servo(bag: Path) -> tuple[float, float]:
    """Kp 1/s and top speed rad/s of the nominal servo that come nearest to the recorded gearbox angle."""
    asked, gearbox = read_angles(bag, "trunk/setpoints"), read_angles(bag, "trunk/gearbox_states")

    def misfit(x: Array) -> float:
        own = (float(np.clip(x[0], 0.1, 5.0)) * KP, float(np.clip(x[1], 0.05, 5.0)) * V_MAX)
        said = at_stamps(gearbox.stamp, servo_under(asked, own))
        shown = ((said - gearbox.angle) ** 2).mean() * 1e6
        return float(shown + WEAK * ((x - 1) ** 2).sum())  # what this motion does not show stays nominal

    best = _sought(misfit, (0.1, -0.2), 40)
    return float(np.clip(best[0], 0.1, 5.0)) * KP, float(np.clip(best[1], 0.05, 5.0)) * V_MAX
