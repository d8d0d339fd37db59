"""Draws of how the wire gives way to the load."""

from __future__ import annotations

import numpy as np

from test.concealed.draws import ALL, Joints, Rng, drawn, logarithmic, one_of, sizes
from test.concealed.hidden import Hidden
from test.concealed.nominal import COMPLIANCE, COUNT, LINK, Array
from test.concealed.recipe import Look, Recipe, scaled


@drawn
def load_elasticity(rng: Rng, joints: Joints, look: Look) -> Recipe:
    """Either the wire as it is, on all joints, under a payload; or some share of it on some joints."""
    if rng.uniform() < 0.4:
        values = {"compliance": COMPLIANCE, "payload": float(logarithmic(rng, 0.01, 0.12))}
        whole = Hidden("load_elasticity", ALL, "wire", values, ("compliance", "payload"))
        return Recipe(lambda size: whole, 1.0, 1.0, fixed=True)
    payload = float(logarithmic(rng, 0.01, 0.12)) if rng.uniform() < 0.5 else 0.0
    values = {"compliance": COMPLIANCE[list(joints)] * sizes(rng, len(joints)), "payload": payload}
    base = Hidden("load_elasticity", joints, "scaled", values, ("compliance",))
    return scaled(base, ("compliance",), 0.3, 3.0)


def _pull(look: Look, joints: Joints, payload: float) -> Array:
    """Largest load on the joints with a payload (its part taken as for the arm's own weight at the tip)."""
    more = payload * 9.81 * LINK * np.arange(COUNT, 0, -1)[list(joints)] * 0.3
    return look.top("tau", joints) + more


def _soft_wire(rng: Rng, joints: Joints) -> tuple[Joints, float]:
    return (ALL if rng.uniform() < 0.5 else joints), float(logarithmic(rng, 0.01, 0.12))


@drawn
def wire_slack(rng: Rng, joints: Joints, look: Look) -> Recipe:
    joints, payload = _soft_wire(rng, joints)
    threshold = rng.uniform(0.2, 0.6, len(joints)) * _pull(look, joints, payload)
    values = {"compliance": COMPLIANCE[list(joints)], "threshold": threshold, "payload": payload}
    slack = Hidden("wire_slack", joints, one_of(rng, "kinked", "smooth"), values, ("threshold", "payload"))
    return Recipe(lambda size: slack, 1.0, 1.0, fixed=True)


@drawn
def wire_stiffening(rng: Rng, joints: Joints, look: Look) -> Recipe:
    joints, payload = _soft_wire(rng, joints)
    moment = rng.uniform(0.2, 1.0, len(joints)) * _pull(look, joints, payload)
    values = {"compliance": COMPLIANCE[list(joints)], "moment": moment, "payload": payload}
    form = one_of(rng, "logarithm", "arctangent", "hyperbolic")
    stiff = Hidden("wire_stiffening", joints, form, values, ("payload",))
    return Recipe(lambda size: stiff, 1.0, 1.0, fixed=True)
