"""Another joint's posture moves this joint along a curve."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.bank import WEIGHTS, Bank, parameters_of, words_of
from trunk_ros.effects.wire.joint_coupling import BEHIND, JointCoupling

BEYOND = 0.25  # of its range that a curve goes on straight beyond its ends
NARROW = 1e-9  # rad


class CouplingCurve(Bank):
    """theta += curve(s), a natural cubic spline through 8 values, straight beyond its ends for a quarter of
    its range; s = r phi of another joint, up to four of them. guides: u += curve(s), before the friction of
    the joint's own wire, as where it passes the guides of others.
    """

    id = "coupling_curve"
    stage, place = "wire", BEHIND
    forms = ("behind", "guides")
    signature = "The residual follows another joint's angle along a bent line, the same in both directions."
    source = (
        "Ciofu & Stan, fig. 1: wires of distal joints pass through the guides of the proximal ones, and the "
        "way through a bent guide is no straight function of its angle."
    )
    sources = 4
    parameters = parameters_of(sources, "where the curve begins", "where the curve ends", "rad at knot")
    texts = words_of(sources)
    needs = ("several",)
    confused_with = (("joint_coupling", "move the source over a wider range: a curve leaves the line"),)

    @property
    def acts_at(self) -> int:
        return JointCoupling.place if self.form == "guides" else self.place

    @classmethod
    def ready(cls, low: float, high: float, weights: Array) -> tuple[float, float, Array]:
        return low, max(high, low + NARROW), np.ascontiguousarray(cubics() @ weights)

    @classmethod
    def add(cls, s: Array, ready: tuple[float, float, Array], state: Any, out: Array) -> None:
        follow(s, *ready, out)

    @classmethod
    def range_of(cls, s: Array) -> tuple[float, float]:
        return float(s.min()), float(s.max())


@cache
def cubics() -> Array:
    """(4, pieces, WEIGHTS) cubics between knots one apart, highest power first, per value."""
    from scipy.interpolate import CubicSpline  # of few models: importing it takes a node 0.3 s

    return np.asarray(CubicSpline(np.arange(WEIGHTS), np.eye(WEIGHTS), bc_type="natural").c)


@compiled
def follow(s: Array, low: float, high: float, cubics: Array, out: Array) -> None:
    """Add to ``out`` (n,) the curve over ``s`` (n,); ``cubics`` (4, pieces) between knots one apart."""
    pieces = cubics.shape[1]
    scale = pieces / (high - low)
    for i in range(len(s)):
        at = (s[i] - low) * scale
        inside = min(max(at, 0.0), float(pieces))
        k = min(int(inside), pieces - 1)
        t = inside - k
        a, b, c, d = cubics[0, k], cubics[1, k], cubics[2, k], cubics[3, k]
        past = min(max(at - inside, -BEYOND * pieces), BEYOND * pieces)
        out[i] += ((a * t + b) * t + c) * t + d + past * ((3.0 * a * t + 2.0 * b) * t + c)
