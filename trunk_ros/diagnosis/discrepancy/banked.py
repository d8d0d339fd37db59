"""Banks beside the named effects of a joint, where those leave much and the banks win on blocks not seen."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.noise import alike
from trunk_ros.diagnosis.discrepancy.memory import (
    Source,
    by_blocks,
    drawn,
    sources,
    unseen,
    without_banks,
)
from trunk_ros.diagnosis.evidence.residual_dependence import rests
from trunk_ros.diagnosis.hypothesis import Explanation
from trunk_ros.diagnosis.search.fit import Fit, fit
from trunk_ros.diagnosis.search.revise import STRONG
from trunk_ros.diagnosis.stage import Problem
from trunk_ros.effects import effect

FORMS = 0.01  # of the misfit: what forms of the same physics may differ by
CLEAR = 0.1  # of what is left: what a bank must take off it on blocks not seen
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
    bare = without_banks(lean, column)
    rest = problem.whitened(bare, column)
    after = problem.whitened(lean, column)
    gone = unseen(found, rest, alike([after]))
    before = by_blocks(problem.whitened(state.explanation, column) ** 2)
    if not _wins(before, by_blocks(gone**2), misfit):
        return state
    return Fit(lean, state.cost | {column: float(after @ after)})


def _wins(before: Array, after: Array, misfit: float) -> bool:
    """Whether the power that banks leave in blocks that they were not fitted to is clearly less than before,
    and little of the misfit.
    """
    gain = before - after
    error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain))
    least = max(CLEAR * float(before.mean()), SURE * error)
    return bool(gain.mean() > least and after.mean() - 1.0 < HALF * misfit)


def _lean(problem: Problem, explanation: Explanation, column: int, found: list[Source]) -> Explanation:
    """The explanation with banks on a column, and without its own effects that the banks make superfluous: those
    whose values are not worth their number (Schwarz 1978), going by how many samples are worth one.
    """
    best, cost = _refitted(problem, explanation, column, found)
    worth = alike([problem.whitened(best, column)])
    count = problem.count(column)
    while True:
        own = [t.effect for t in without_banks(best, column).on(column) if _may_go(problem, t.effect)]
        trials = [(_refitted(problem, best.without(name, column), column, found), name) for name in own]
        if not trials:
            return best
        (trial, power), name = min(trials, key=lambda t: t[0][1] - _price(best, t[1], column, count, worth, cost))
        if power - cost > _price(best, name, column, count, worth, cost):
            return best
        best, cost = trial, power


def _may_go(problem: Problem, name: str) -> bool:
    return not effect(name).everywhere and name not in problem.known


def _price(now: Explanation, name: str, column: int, count: int, worth: float, cost: float) -> float:
    """What an effect's values on a column must take off its squared residuals."""
    values = sum(f.effect == name for f in now.free([column]))
    return float(max(values, 1) * np.log(count / worth) * worth * cost / count)


def _refitted(
    problem: Problem, explanation: Explanation, column: int, found: list[Source]
) -> tuple[Explanation, float]:
    """Named values and banks of a column fitted in turn, and what they leave."""
    bare = fit(problem, without_banks(explanation, column), [column]).explanation
    out = drawn(problem, bare, column, found)
    rest = problem.whitened(out, column)
    return out, float(rest @ rest)
