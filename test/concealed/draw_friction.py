"""Draws of what widens the dead band or rounds it."""

from __future__ import annotations

from typing import Any

import numpy as np

from test.concealed.draws import ALL, Joints, Rng, drawn, logarithmic, one_of, sizes
from test.concealed.hidden import Hidden
from test.concealed.recipe import Look, Recipe, scaled


@drawn
def backlash(rng: Rng, joints: Joints, look: Look) -> Recipe:
    base = Hidden("backlash", joints, "play", {"half_width": sizes(rng, len(joints))}, ("half_width",))
    return scaled(base, ("half_width",), 1e-3, 0.02)


@drawn
def tension_error(rng: Rng, joints: Joints, look: Look) -> Recipe:
    slack = rng.uniform() < 0.3

    def make(size: float) -> Hidden:
        factor = 1 - 0.95 * size / 12 if slack else 1 + size
        return Hidden("tension_error", ALL, "scaled", {"factor": factor}, ("factor",))

    return Recipe(make, 1.0, 12.0)


@drawn
def load_dependent_friction(rng: Rng, joints: Joints, look: Look) -> Recipe:
    form = one_of(rng, "straight", "straight", "smooth")
    base = Hidden("load_dependent_friction", joints, form, {"gain": sizes(rng, len(joints))}, ("gain",))
    return scaled(base, ("gain",), 0.02, 0.3)


@drawn
def stribeck_friction(rng: Rng, joints: Joints, look: Look) -> Recipe:
    values = {"amplitude": sizes(rng, len(joints)), "velocity": logarithmic(rng, 0.01, 0.12, len(joints))}
    form = one_of(rng, "exponential", "gaussian", "rational")
    same = ("amplitude", "velocity") if form == "exponential" else ("amplitude",)
    return scaled(Hidden("stribeck_friction", joints, form, values, same), ("amplitude",), 1e-3, 0.02)


@drawn
def friction_wear(rng: Rng, joints: Joints, look: Look) -> Recipe:
    form = one_of(rng, "straight", "straight", "running_in", "travel")
    same = ("rate",) if form == "straight" else ()
    base = Hidden("friction_wear", joints, form, {"rate": sizes(rng, len(joints))}, same)
    return scaled(base, ("rate",), 1e-5, 3e-4)


@drawn
def presliding_hysteresis(rng: Rng, joints: Joints, look: Look) -> Recipe:
    form = one_of(rng, "uniform", "exponential", "maxwell", "bouc_wen_1", "bouc_wen_2", "dahl")
    extra: dict[str, Any] = {}
    if form in ("uniform", "exponential", "maxwell"):
        many = 5 if form == "maxwell" else 24
        place = (np.arange(many) + 0.5) / many if form != "maxwell" else np.linspace(0.0, 1.0, many)
        weight = np.ones(many) if form == "uniform" else np.exp(-2.5 * place)
        weight = rng.uniform(0.5, 1.5, many) if form == "maxwell" else weight
        extra = {"place": place.tolist(), "weight": (weight / weight.sum()).tolist()}
    same = ("width",) if form == "uniform" else ()
    base = Hidden("presliding_hysteresis", joints, form, {"width": sizes(rng, len(joints))}, same, extra)
    return scaled(base, ("width",), 1e-3, 0.02)
