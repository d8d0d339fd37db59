"""What an explanation must be worth: squared residuals, with a price on every effect."""

from __future__ import annotations

import numpy as np

from trunk_ros.diagnosis.hypothesis import Explanation, Term
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.stage import Problem
from trunk_ros.effects import effect

SIGNIFICANT = (
    60.0  # gain in squared unit-noise residuals below which chance and small misfits are not ruled out
)
RELEVANT = 0.02  # share of the noise power that an effect must remove from a joint
STEPS = 3.0  # times the power of the gearbox encoder's steps that an effect must have
OWN_STEPS = 0.1  # times that of the joint's own encoder, which the other noise shakes loose
SHARE = (
    0.05  # of what is left above the noise that an effect must explain, so that a misfit is not cut in slices
)
FURTHER = 20.0  # price of each further value of an effect
CHOICE = 3.0  # of a source among the joints: the logarithm of so many, twice
LIKELY = 5.0  # in favour of each joint for what acts on all joints alike
FORMULAS = 0.0002  # of a joint's misfit: what the formulas of named effects may be off by
CURVED = 0.002  # likewise, by what is smooth
FAR_OFF = 0.2  # of a ratio: so far off it was not known, and what it makes is no misfit of formulas
CURVE = 2.5  # price of a curve without a name, in effects


def need(problem: Problem, column: int) -> float:
    """The gain on a column below which nothing is claimed there.

    The encoders' steps are an error that stands still with the joint, so they are no noise to be averaged: as
    long as a reading stays the same it counts once. Of coloured noise the colour is known only roughly.
    """
    noise = problem.noise[column]
    steps, own = problem.resolution(column) / noise.std, problem.steps[column] / noise.std
    still = problem.own_steps(column) / noise.std
    chance = SIGNIFICANT * (1.0 + noise.correlation) * max(problem.stands[column] * still**2, 1.0)
    least = problem.count(column) * max(RELEVANT, STEPS * steps**2, OWN_STEPS * own**2)
    formulas = FORMULAS * problem.formed_misfit.get(column, 0.0)
    return max(chance, least, formulas, SHARE * problem.unexplained.get(column, 0.0))


def formed_misfits(problem: Problem, explanation: Explanation) -> dict[int, float]:
    """What formulas can be off in proportion to: what an explanation leaves of each column above the noise,
    in squared unit-noise residuals; where the ratio is FAR_OFF, what the right one would leave.
    """
    return {c: min(p, _right_ratio(problem, explanation, c)) for c, p in problem.unexplained.items()}


def _right_ratio(problem: Problem, explanation: Explanation, column: int) -> float:
    if problem.stage != "wire":
        return np.inf
    angles = [view.span.gearbox[view.span.rows, column] * problem.arm.ratio[column] for view in problem.views]
    zeros = [np.ones_like(angle) for angle in angles]
    line = np.column_stack([problem.whiten_change(shape, column) for shape in (angles, zeros)])
    rest = problem.whitened(explanation, column)
    found = np.linalg.lstsq(line, rest, rcond=None)[0]
    left = float(np.sum((rest - line @ found) ** 2)) - problem.count(column)
    return max(left, 0.0) if abs(found[0]) > FAR_OFF else np.inf


def price(problem: Problem, term: Term) -> float:
    """What a term must gain, over all its joints; a further source counts as a further effect.

    What the model has already costs nothing.
    """
    known = problem.known[term.effect].columns if term.effect in problem.known else []
    needs = {c: need(problem, c) for c in term.columns if c in problem.columns and c not in known}
    if not needs:
        return 0.0
    if not effect(term.effect).named:
        return sum(max(CURVE * n, CURVED * problem.misfit.get(c, 0.0)) for c, n in needs.items())
    free = Explanation({term.effect: term}).free(list(term.columns))
    if effect(term.effect).everywhere:
        usual = float(np.median(list(needs.values())))
        return usual + FURTHER * max(len(free) - 1, 0) - LIKELY * len(needs)
    said = {c: len(term.words.get(c, {})) for c in needs}
    words = sum(needs[c] * max(count - 1, 0) + CHOICE * count for c, count in said.items())
    own_values = sum(1 for f in free if f.column is not None)
    return sum(needs.values()) + words + FURTHER * max(own_values - len(needs), 0)


def score(problem: Problem, state: Fit) -> float:
    """Squared residuals and prices: every change of an explanation has to lower it."""
    return state.total + sum(price(problem, term) for term in state.explanation.values())
