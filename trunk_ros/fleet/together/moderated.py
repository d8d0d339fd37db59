"""Variances of many short series, each moderated by what the others say (Smyth 2004, limma).

A series of six recordings hardly knows its own scatter. Series of the same kind scatter alike: their
variances are drawn from a scaled inverse chi-square, whose two numbers all of them together tell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import digamma, polygamma

from trunk_ros.compiled import Array

MOST = 60.0  # degrees of freedom that the others may add: no two arms are that much alike


@dataclass(frozen=True)
class Prior:
    """What is known of a variance beforehand: ``variance``, worth ``dof`` samples."""

    variance: float
    dof: float

    def with_own(self, variance: float, dof: float) -> tuple[float, float]:
        """Variance and degrees of freedom with those that a series has itself."""
        total = self.dof + dof
        return (self.dof * self.variance + dof * variance) / total, total


def prior(variance: Array, dof: Array) -> Prior:
    """The prior that sample variances (k,) with so many degrees of freedom (k,) come from."""
    known = (variance > 0.0) & (dof > 0.0)
    v, d = variance[known], dof[known]
    if len(v) < 3:
        return Prior(float(np.median(v)) if len(v) else 1.0, 0.0)
    shifted = np.log(v) - digamma(d / 2.0) + np.log(d / 2.0)
    excess = float(np.var(shifted, ddof=1) - np.mean(polygamma(1, d / 2.0)))
    if excess <= 0.0:
        return Prior(float(np.exp(np.mean(shifted))), MOST)
    of = min(2.0 * _trigamma_inverse(excess), MOST)
    center = np.mean(shifted) + digamma(of / 2.0) - np.log(of / 2.0)
    return Prior(float(np.exp(center)), of)


def _trigamma_inverse(y: float) -> float:
    """The x of trigamma(x) = y, by Newton's method on 1/trigamma, which is nearly straight."""
    x = 0.5 + 1.0 / y
    for _ in range(50):
        value = float(polygamma(1, x))
        step = value * (1.0 - value / y) / float(polygamma(2, x))
        x += step
        if -step / x < 1e-8:
            break
    return x
