"""The smooth course of a signal."""

import numpy as np
from numpy.polynomial.legendre import legval, legvander

from trunk_ros.compiled import Array

DEGREE = 3


def cubic(x: Array, y: Array, at: Array) -> Array:
    """(m,) at ``at`` (m,) the cubic through ``y`` (n,) over ``x`` (n,). Where x holds too few different
    values for one, as of a joint that goes between a few stops, the least of those that fit as well.
    """
    low, width = float(np.min(x)), float(np.ptp(x)) or 1.0
    basis = legvander(2.0 * (x - low) / width - 1.0, DEGREE)
    course = np.linalg.lstsq(basis, y, rcond=None)[0]
    return np.asarray(legval(2.0 * (at - low) / width - 1.0, course))
