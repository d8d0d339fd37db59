"""Effects tried on one joint: a linear look ranks them, and what can still win is refitted."""

from __future__ import annotations

from collections.abc import Iterator

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import Candidate, extended
from trunk_ros.diagnosis.search.fit import Fit, refit_column
from trunk_ros.diagnosis.search.score import priced, score
from trunk_ros.diagnosis.search.screen import Screen
from trunk_ros.effects import Effect

PROMISED = 0.5  # of what it takes to win: a linear look does not see all of it


def column_trials(
    best: Fit, bare: Hypothesis, column: int, kinds: list[type[Effect]], most: int
) -> Iterator[Fit]:
    """The most promising effects on a joint of ``bare``, refitted there where they may beat ``best``."""
    screen = Screen(best.context, bare, [column])
    for candidate in screen.ranked(kinds, column, most):
        trial = try_one(best, screen, candidate, column)
        if trial is not None:
            if score(trial) < score(best):
                best = trial
            yield trial


def try_one(best: Fit, screen: Screen, candidate: Candidate, column: int) -> Fit | None:
    """A candidate refitted on its joint; None where it promises too little to beat ``best``."""
    hypothesis = extended(best.context, screen.hypothesis, candidate)
    goal = _goal(best, hypothesis, column)
    if screen.left(column) - candidate.gain / PROMISED > goal:
        return None
    return refit_column(best, hypothesis, column, goal)


def _goal(best: Fit, hypothesis: Hypothesis, column: int) -> float:
    """What a joint's squared residuals have to come to for the score to be as good as that of ``best``."""
    others = Fit(hypothesis, {c: cost for c, cost in best.cost.items() if c != column}, best.context)
    return score(best) - priced(others)
