"""Banks beside the named effects of a joint, where those leave much and the banks win on blocks not seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.discrepancy.memory import (
    CUTS,
    FOLDS,
    Source,
    drawn,
    redrawn_banks,
    sources,
    without_banks,
)
from trunk_ros.diagnosis.evidence.residual_dependence import rests
from trunk_ros.diagnosis.hypothesis import Explanation
from trunk_ros.diagnosis.search.fit import Fit, fit
from trunk_ros.diagnosis.search.revise import STRONG
from trunk_ros.diagnosis.stage import Problem
from trunk_ros.effects import effect

FORMS = 0.01  # of the misfit: what forms of the same physics may differ by
CLEAR = 0.05  # of what is left: what a bank must take off it on blocks not seen
SPARES = 0.02  # likewise, an effect with a name beside banks
SURE = 2.0  # standard errors over the blocks
HALF = 0.5  # of the misfit: a model that leaves more of it is of something else than what is at work


def with_banks(problem: Problem, state: Fit) -> Fit:
    """The explanation with banks on the joints that need them."""
    if problem.stage != "wire":
        return state
    left = rests(problem, state.explanation)
    for column in [c for c, power in left.items() if power > STRONG]:
        misfit = float(np.mean(problem.whitened(problem.known, column) ** 2)) - 1.0
        if left[column] > FORMS * misfit:
            state = _banked(problem, state, column, misfit)
    return state


def _banked(problem: Problem, state: Fit, column: int, misfit: float) -> Fit:
    found = sources(problem, column)
    if not found:
        return state
    lean = _lean(problem, state.explanation, column, found)
    before = unseen(problem, state.explanation, column)
    if not _wins(before, lean.unseen, misfit):
        return state
    rest = problem.whitened(lean.explanation, column)
    return Fit(lean.explanation, state.cost | {column: float(rest @ rest)})


def _wins(before: Array, after: Array, misfit: float) -> bool:
    """Whether the power that is left in blocks that nothing was fitted to is clearly less than before, and little
    of the misfit.
    """
    return clearly(before, after, CLEAR) and float(after.mean()) - 1.0 < HALF * misfit


def clearly(before: Array, after: Array, share: float) -> bool:
    """Whether powers of blocks (CUTS,) are less than before by a ``share``, and by more than their scatter."""
    gain = np.log(before / after)
    error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain))
    return bool(gain.mean() > max(share, SURE * error))


@dataclass(frozen=True)
class Judged:
    """An explanation, and what it leaves of blocks that it was not fitted to, (CUTS,) mean squares."""

    explanation: Explanation
    unseen: Array


def _lean(problem: Problem, explanation: Explanation, column: int, found: list[Source]) -> Judged:
    """The explanation with banks on a column, and without its own effects that the banks make superfluous."""
    best = _refitted(problem, explanation, column, found)
    while True:
        own = [t.effect for t in without_banks(best.explanation, column).on(column)]
        trials = [
            _refitted(problem, best.explanation.without(name, column), column, found)
            for name in own
            if not effect(name).everywhere and name not in problem.known
        ]
        least = min(trials, key=lambda t: float(t.unseen.mean()), default=None)
        if least is None or clearly(least.unseen, best.unseen, SPARES):
            return best
        best = least


def _refitted(problem: Problem, explanation: Explanation, column: int, found: list[Source]) -> Judged:
    """Named values of a column fitted, and banks on what they leave."""
    bare = fit(problem, without_banks(explanation, column), [column]).explanation
    out = drawn(problem, bare, column, found)
    return Judged(out, unseen(problem, out, column))


def unseen(problem: Problem, explanation: Explanation, column: int) -> Array:
    """(CUTS,) mean squares of blocks of time, by named values and banks that were fitted to the others."""
    out, views = np.zeros(CUTS), problem.views
    block = blocks(problem, column)
    for fold in range(FOLDS):
        judged = np.arange(CUTS) % FOLDS == fold
        try:
            problem.views = [view.only(~judged[number]) for view, number in zip(views, block, strict=True)]
            fitted = fit(problem, without_banks(explanation, column), [column]).explanation
            fitted = redrawn_banks(problem, fitted, column, explanation)
        finally:
            problem.views = views
        out[judged] = by_blocks(problem.whitened(fitted, column) ** 2)[judged]
    return out


def blocks(problem: Problem, column: int) -> list[np.ndarray]:
    """(n,) number of the block of time that each row of a span is in, by what counts on a column."""
    valid = [view.span.valid[:, column] for view in problem.views]
    place = np.cumsum(np.concatenate(valid)) - 1
    number = np.clip(place * CUTS // max(int(place[-1]) + 1, 1), 0, CUTS - 1)
    return np.split(number, np.cumsum([len(v) for v in valid])[:-1])


def by_blocks(power: Array) -> Array:
    """(CUTS,) means of what counts (rows,) over the blocks."""
    number = np.arange(len(power)) * CUTS // max(len(power), 1)
    return np.asarray(np.bincount(number, power, CUTS) / np.maximum(np.bincount(number, minlength=CUTS), 1))
