"""Memory in the wire whose loops change with the posture, that no name fits."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legder, legval

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.curve import KNOTS
from trunk_ros.effects.drags import NARROWEST, WIDEST, drag
from trunk_ros.effects.legendre import legendre
from trunk_ros.effects.postures import LEAST, OverPostures, parameters_over_postures

REACHES, SHAPES = 12, KNOTS  # over the posture as finely as any other curve: what catches, catches in places
COARSE = 8  # of these, which have a size of their own: not every wire catches
FINE = 200  # postures at which a slope is looked at


class UnknownLoops(OverPostures):
    """theta += c_0(s) + sum of c_i(s) (s - play(s, reach_i)) / reach_i, s = r phi of the joint itself, or
    the angle that the effects before it give, where neighbours drag the joint along.

    Each c is a sum of the first 24 Legendre polynomials from low to high, constant beyond, but for the
    line in c_0; reaches in even ratios from 0.015 to 0.4 of that range. A wire in a bent guide is pressed
    onto it by the bend: what its contacts hold back goes by the posture, which plays of constant weight
    cannot show.
    """

    id = "unknown_loops"
    place = 244
    signature = (
        "The residual is a loop whose width changes with the posture, in a way that no named effect has."
    )
    source = (
        "Kennedy & O'Hagan (2001), J. R. Stat. Soc. B 63(3): a discrepancy term beside the physics; its "
        "memory a Prandtl-Ishlinskii operator (Brokate & Sprekels 1996, Hysteresis and Phase Transitions) "
        "whose weights change with the posture: by the capstan equation friction grows with the wrap."
    )
    # Constants; how they change with the posture, coarsely and finely; the curve.
    groups = (REACHES, REACHES * (COARSE - 1), REACHES * (SHAPES - COARSE), SHAPES)
    weights = sum(groups)
    parameters = parameters_over_postures(weights, typical=1.5e-6)
    confused_with = (
        ("unknown_memory", "reverse with the same amplitude about several postures: its loops are all alike"),
        (
            "presliding_hysteresis",
            "reverse with many amplitudes about several postures: its loops are of one shape",
        ),
    )

    @classmethod
    def ready(cls, low: float, high: float, weights: Array) -> tuple[float, float, float, Array, Array]:
        *held, alone = np.split(weights, np.cumsum(cls.groups)[:-1])
        shapes = np.vstack([alone, np.column_stack([part.reshape(REACHES, -1) for part in held])])
        high = max(high, low + LEAST)
        return low, high, float(alone[1]), _reaches(low, high), np.ascontiguousarray(shapes)

    @classmethod
    def add(cls, s: Array, ready: tuple[float, float, float, Array, Array], state: Any, out: Array) -> Array:
        stuck = np.full(REACHES, s[0]) if state is None else state.copy()
        loop(s, *ready, stuck, out)
        return stuck

    @classmethod
    def columns(cls, s: Array, low: float, high: float) -> Iterator[Array]:
        high = max(high, low + LEAST)
        way = 2.0 * (s - low) / (high - low) - 1.0
        inside, reaches = np.clip(way, -1.0, 1.0), _reaches(low, high)
        yield from (_held(s, reach) for reach in reaches)
        for first, end in ((1, COARSE), (COARSE, SHAPES)):
            for held in (_held(s, reach) for reach in reaches):
                yield from (held * curve for curve in islice(legendre(inside), first, end))
        for k, curve in enumerate(islice(legendre(inside), SHAPES)):
            yield curve + way - inside if k == 1 else curve

    @classmethod
    def steepness(cls, low: float, high: float, weights: Array) -> float:
        """The steepest of all loops: where the widest contacts still stick, and of the curves themselves."""
        low, high, _, reach, shapes = cls.ready(low, high, weights)
        at = np.linspace(-1.0, 1.0, FINE)
        value = legval(at, shapes.T)
        bend = legval(at, legder(shapes.T)) * 2.0 / (high - low)
        sticks = np.cumsum((value[1:] / reach[:, None])[::-1], axis=0)
        return float(np.max(np.abs(sticks).max(axis=0) + np.abs(bend).sum(axis=0)))


def _held(s: Array, reach: float) -> Array:
    """(n,) of what a play of a half-width holds back of ``s`` (n,), over that."""
    out = np.zeros(len(s))
    drag(s, np.array([reach]), np.array([1.0 / reach]), s[:1].copy(), out)
    return out


def _reaches(low: float, high: float) -> Array:
    return (high - low) * np.geomspace(NARROWEST, WIDEST, REACHES)


@compiled
def loop(
    s: Array, low: float, high: float, line: float, reach: Array, shapes: Array, stuck: Array, out: Array
) -> None:
    """Add to ``out`` (n,) what plays of half-widths ``reach`` (k,) hold back of ``s`` (n,), each by its sum
    of Legendre polynomials over the posture, ``shapes`` (1 + k, m), the first one alone, beyond both ends by
    its ``line``; ``stuck`` (k,) changes in place.
    """
    order = shapes.shape[1]
    basis = np.ones(order)
    for i in range(len(s)):
        way = 2.0 * (s[i] - low) / (high - low) - 1.0
        u = min(max(way, -1.0), 1.0)
        basis[1] = u
        for m in range(2, order):
            basis[m] = ((2 * m - 1) * u * basis[m - 1] - (m - 1) * basis[m - 2]) / m
        total = (way - u) * line
        for k in range(len(shapes)):
            value = 0.0
            for m in range(order):
                value += shapes[k, m] * basis[m]
            if k == 0:
                total += value
            else:
                stuck[k - 1] = min(max(stuck[k - 1], s[i] - reach[k - 1]), s[i] + reach[k - 1])
                total += value * (s[i] - stuck[k - 1]) / reach[k - 1]
        out[i] += total
