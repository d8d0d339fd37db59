"""What people do instead: refit the nominal arm's own parameters, here ratio and dead band of every joint.

The trap is that they take in physics that is missing: the fitted run looks better, the next one may not.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from test.concealed.nominal import COUNT, HALF_WIDTH, RATIO, Array, play
from test.concealed.removed import SKIP, Angles, read_angles


def _aligned(bag: Path) -> tuple[Angles, Array, NDArray[np.bool_], NDArray[np.int64]]:
    """Joint states; gearbox angle on the stamps of both; settled samples; the joint states' places in it."""
    shown, gearbox = read_angles(bag, "joint_states"), read_angles(bag, "trunk/gearbox_states")
    fine = np.unique(np.concatenate([gearbox.stamp, shown.stamp]))
    t, known = (fine - fine[0]) * 1e-9, (gearbox.stamp - fine[0]) * 1e-9
    phi = np.stack([np.interp(t, known, column) for column in gearbox.angle.T], axis=1)
    late = shown.stamp - shown.stamp[0] > SKIP * 1e9
    return shown, phi, late, np.searchsorted(fine, shown.stamp)


def _wire(phi: Array, ratio: Array, width: Array) -> Array:
    u: Array = ratio * phi
    both = np.broadcast_to(np.abs(width), u.shape).copy()
    out: Array = play(u, both, both, u[0].copy())
    return out


def _fitted(bag: Path) -> tuple[Array, Array]:
    """Ratio and dead band (5,) with the least squares of the joint readings."""
    shown, phi, late, places = _aligned(bag)
    best = np.empty((2, COUNT))
    for j in range(COUNT):

        def misfit(x: Array, j: int = j) -> float:
            said = _wire(phi[:, [j]], x[:1] * RATIO, x[1:] * HALF_WIDTH[j])[places, 0]
            return float(((said - shown.angle[:, j])[late] ** 2).mean() * 1e6)

        simplex = np.array([[1.0, 1.0], [1.02, 1.0], [1.0, 1.5]])
        best[:, j] = minimize(
            misfit, simplex[0], method="Nelder-Mead", options={"initial_simplex": simplex, "maxiter": 120}
        ).x
    return RATIO * best[0], np.abs(best[1]) * HALF_WIDTH


def _error(bag: Path, ratio: Array, width: Array, clean: Array | None, noise: float) -> float:
    """Rms of the joint angle error, rad, less the noise where the truth is the noisy reading."""
    shown, phi, late, places = _aligned(bag)
    truth = shown.angle if clean is None else clean
    error = (_wire(phi, ratio, width)[places] - truth)[late]
    return float(np.sqrt(max((error**2).mean() - (noise**2 if clean is None else 0.0), 0.0)))


def refit(run_1: Path, run_2: Path, clean: Array, noise: float) -> dict[str, float]:
    """Errors, rad rms, of the nominal and of the refitted wire on the fitted and on another run.

    clean: noise-free joint angle (n, 5) rad of run_2; noise: rad rms, taken off the error on run_1.
    """
    ratio, width = _fitted(run_1)
    plain, wide = np.full(COUNT, RATIO), HALF_WIDTH
    return {
        "fitted_before": _error(run_1, plain, wide, None, noise),
        "fitted_after": _error(run_1, ratio, width, None, noise),
        "before": _error(run_2, plain, wide, clean, noise),
        "after": _error(run_2, ratio, width, clean, noise),
    }
