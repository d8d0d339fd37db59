"""How smooth a curve is that a linear fit draws."""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from trunk_ros.compiled import Array

SMOOTH = np.logspace(-3.0, 4.0, 15)  # weights of a curve's bends, of a knot's own


def smoothed(design: Array, target: Array, bend: Array) -> tuple[Array, float]:
    """Values (knots,) of the curve that a design (rows, knots) needs for a target (rows,) of unit noise, as
    smooth as is most likely, and how many values that is worth.

    The weight of the second differences ``bend`` (k, knots) has the largest marginal likelihood (Wood 2011,
    J. R. Stat. Soc. B 73(1)).
    """
    normal, side = design.T @ design, design.T @ target
    bent, rank = bend.T @ bend, np.linalg.matrix_rank(bend)
    size = float(np.trace(normal)) / len(side)
    least, best = -np.inf, (np.zeros_like(side), 0.0)
    if not 0.0 < size < np.inf:  # nothing of the curve comes through
        return best
    for weight in SMOOTH * size:
        try:
            factor = cho_factor(normal + weight * bent + 1e-9 * size * np.eye(len(side)))
        except np.linalg.LinAlgError:  # values so far apart that the numbers cannot hold their squares
            continue
        values = cho_solve(factor, side)
        likely = float(side @ values) - 2.0 * float(np.log(np.diag(factor[0])).sum())
        likely += rank * float(np.log(weight))
        if likely > least:
            least, best = likely, (values, float(np.trace(cho_solve(factor, normal))))
    return best
