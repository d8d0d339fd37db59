"""What the samples before do not tell of noise that remembers: a Kalman filter."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.guards import FADED, ROUNDED
from trunk_ros.machine import FACTORS


@compiled
def innovations(
    residual: Array,
    follows: np.ndarray,
    correlation: float,
    coloured: float,
    white: float,
    out: Array,
    size: Array,
) -> None:
    """What the samples before do not tell of a residual (n,): a Kalman filter of an AR(1) process of a
    variance ``coloured`` under ``white`` noise of another. Fills ``out`` (n,), in standard deviations, and
    these, ``size`` (n,). What it does so many samples after a gap is worked out once.
    """
    roots, gains = np.empty(len(residual)), np.empty(len(residual))
    spread, settled, known, since, expected = coloured, False, 0, 0, 0.0
    for i in range(len(residual)):
        if not follows[i]:
            since, expected = 0, 0.0
        if since == known:
            if settled:
                since -= 1
            else:
                whole, before = spread + white, spread
                roots[since], gains[since] = np.sqrt(whole), correlation * spread / whole
                spread = correlation**2 * spread * white / whole + (1.0 - correlation**2) * coloured
                settled, known = abs(spread - before) <= ROUNDED * spread, known + 1
        off = residual[i] - expected
        size[i] = roots[since]
        out[i] = off / roots[since]
        expected = correlation * expected + gains[since] * off
        if abs(expected) < FADED:
            expected = 0.0
        since += 1


@compiled
def innovations_of_two(
    residual: Array,
    follows: np.ndarray,
    correlation: float,
    coloured: float,
    stays: float,
    slow: float,
    white: float,
    out: Array,
    size: Array,
) -> None:
    """The same of two processes together, the second with a correlation that ``stays`` and a variance
    ``slow``.
    """
    roots, gains, others = np.empty(len(residual)), np.empty(len(residual)), np.empty(len(residual))
    first, second, both, settled = coloured, slow, 0.0, False
    known, since, expected, wandered = 0, 0, 0.0, 0.0
    for i in range(len(residual)):
        if not follows[i]:
            since, expected, wandered = 0, 0.0, 0.0
        if since == known:
            if settled:
                since -= 1
            else:
                whole, one, other = first + second + 2.0 * both + white, first + both, both + second
                roots[since] = np.sqrt(whole)
                gains[since], others[since] = correlation * one / whole, stays * other / whole
                a = correlation**2 * (first - one * one / whole) + (1.0 - correlation**2) * coloured
                b = stays**2 * (second - other * other / whole) + (1.0 - stays**2) * slow
                c = correlation * stays * (both - one * other / whole)
                changed = max(abs(a - first), abs(b - second), abs(c - both))
                settled, known = changed <= ROUNDED * (a + b), known + 1
                first, second, both = a, b, c
        off = residual[i] - expected - wandered
        size[i] = roots[since]
        out[i] = off / roots[since]
        expected = correlation * expected + gains[since] * off
        wandered = stays * wandered + others[since] * off
        if abs(expected) + abs(wandered) < FADED:
            expected, wandered = 0.0, 0.0
        since += 1


@compiled
def unlikely(out: Array, size: Array, counted: np.ndarray) -> float:
    """Twice the negative logarithm of the likelihood of what is ``out`` by standard deviations of a ``size``
    (n,), at the rows that are ``counted``, but for a constant.
    """
    squares, logarithms, product = 0.0, 0.0, 1.0
    for k in range(len(counted)):
        i = counted[k]
        squares += out[i] * out[i]
        product *= size[i]
        if k % FACTORS == FACTORS - 1:
            logarithms += np.log(product)
            product = 1.0
    total: float = squares + 2.0 * (logarithms + np.log(product))
    return total
