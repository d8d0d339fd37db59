"""Where two joints stand moves this joint, along a surface that no sum of curves is and no name fits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any, ClassVar

import numpy as np
from numpy.polynomial.legendre import legder, legval2d

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.bank import TOGETHER, WEIGHTS, Bank, parameters_of, words_of
from trunk_ros.effects.legendre import legendre
from trunk_ros.effects.postures import LEAST
from trunk_ros.effects.sources import others
from trunk_ros.parameter import ANY, Parameter

# What the two shapes of each product are over the one and over the other motion; the flattest first.
ORDERS = tuple((total - k, k) for total in range(WEIGHTS) for k in range(total + 1))
SOURCES = 4
FINE = np.linspace(-1.0, 1.0, 50)  # postures along either side at which a slope is looked at
AGAIN = "_2"  # behind the name of an end: of the other motion


def _parameters() -> tuple[Parameter, ...]:
    said = "where the first motion begins", "where the first motion ends", "rad, product"
    more = [
        Parameter(f"{end}_{k}{AGAIN}", "rad", ANY, f"{does}, source {k}", typical=at, null=at)
        for k in range(1, SOURCES + 1)
        for end, does, at in (("low", "where the second begins", -0.4), ("high", "where it ends", 0.4))
    ]
    return (*parameters_of(SOURCES, *said, len(ORDERS), typical=1e-5, start=-0.4), *more)


class UnknownSurface(Bank):
    """theta += sum of weight_ij P_i(s) P_j(t), i + j < 8, P the Legendre polynomials from low to high, held
    beyond; s = r phi of the joint itself, t of another one, up to four of them.

    What two or three motors do to a joint at once by a smooth map, as those of a continuum that bends, is no
    sum of what each of them does. Products of each order have a size of their own: a smooth map has little of
    the high ones.
    """

    id = "unknown_surface"
    stage, place = "wire", 248
    signature = (
        "The residual is one for each pair of places of two joints, whichever way they came there, and no "
        "sum of a curve over each."
    )
    source = (
        "Kennedy & O'Hagan (2001), J. R. Stat. Soc. B 63(3): a discrepancy term beside the physics; "
        "interactions of two variables at a time: Wahba (1990), Spline Models for Observational Data."
    )
    named = False
    own, by_posture = True, True
    sources, weights, axes = SOURCES, len(ORDERS), 2
    groups: ClassVar[tuple[int, ...]] = tuple(range(1, WEIGHTS + 1))
    parameters = _parameters()
    texts = words_of(SOURCES)
    needs = ("several",)
    confused_with: ClassVar[tuple[tuple[str, str], ...]] = (
        ("unknown_loops", "come to one posture from either side: a surface has no memory"),
        ("posture_ratio", "move both joints further: a product of two angles goes on as it is"),
    )

    @classmethod
    def said(cls, k: int, low: Any, high: Any, weights: Array) -> dict[str, float]:
        first = super().said(k, float(low[0]), float(high[0]), weights)
        return first | {f"low_{k}{AGAIN}": float(low[1]), f"high_{k}{AGAIN}": float(high[1])}

    @classmethod
    def read(cls, values: Mapping[str, Any], k: int) -> tuple[Any, Any, Array]:
        low, high, weights = super().read(values, k)
        more = values[f"low_{k}{AGAIN}"], values[f"high_{k}{AGAIN}"]
        return np.stack([low, more[0]], axis=-1), np.stack([high, more[1]], axis=-1), weights

    @classmethod
    def ready(cls, low: Any, high: Any, weights: Array) -> tuple[Array, Array, Array]:
        products = np.zeros((WEIGHTS, WEIGHTS))
        for (i, j), weight in zip(ORDERS, weights, strict=True):
            products[i, j] = weight
        return np.asarray(low, dtype=float), np.maximum(high, np.add(low, LEAST)), products

    @classmethod
    def add(cls, s: Array, ready: tuple[Array, Array, Array], state: Any, out: Array) -> None:
        lie(s, *ready, out)

    @classmethod
    def columns(cls, s: Array, low: Any, high: Any) -> Iterator[Array]:
        low, high, _ = cls.ready(low, high, np.zeros(cls.weights))
        way = np.clip(2.0 * (s - low) / (high - low) - 1.0, -1.0, 1.0)
        over = [list(islice(legendre(way[:, axis]), WEIGHTS)) for axis in range(cls.axes)]
        yield from (over[0][i] * over[1][j] for i, j in ORDERS)

    @classmethod
    def range_of(cls, s: Array) -> tuple[Any, Any]:
        return s.min(axis=0), s.max(axis=0)

    @classmethod
    def steepness(cls, low: Any, high: Any, weights: Array) -> float:
        """The steepest along the joint's own motion."""
        low, high, products = cls.ready(low, high, weights)
        slope = legval2d(*np.meshgrid(FINE, FINE), legder(products, axis=0))
        return float(np.abs(slope).max() * 2.0 / (high[0] - low[0]))

    @classmethod
    def choices(cls, joints: tuple[str, ...], joint: str) -> list[str]:
        return [f"{joint}{TOGETHER}{other}" for other in others(joints, joint)]


@compiled
def lie(s: Array, low: Array, high: Array, products: Array, out: Array) -> None:
    """Add to ``out`` (n,) what products (m, m) of Legendre polynomials over both motions ``s`` (n, 2) say."""
    order = len(products)
    basis = np.ones((2, order))
    for n in range(len(s)):
        for axis in range(2):
            way = 2.0 * (s[n, axis] - low[axis]) / (high[axis] - low[axis]) - 1.0
            u = min(max(way, -1.0), 1.0)
            basis[axis, 1] = u
            for m in range(2, order):
                basis[axis, m] = ((2 * m - 1) * u * basis[axis, m - 1] - (m - 1) * basis[axis, m - 2]) / m
        for i in range(order):
            value = 0.0
            for j in range(order - i):
                value += products[i, j] * basis[1, j]
            out[n] += basis[0, i] * value
