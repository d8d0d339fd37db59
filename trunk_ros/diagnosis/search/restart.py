"""A joint's own effects chosen once more from another first one: the best alone may bar the best two."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.revise import better
from trunk_ros.diagnosis.search.swap import local_effects

if TYPE_CHECKING:
    from trunk_ros.diagnosis.search.greedy import Search

FIRST = 3  # effects that are begun with
MOST = 3  # effects that are then chosen


def begun_anew(search: Search, now: Fit) -> Fit | None:
    """Other effects on joints whose own leave more than noise, where that is better; None if nowhere."""
    problem, best = search.problem, now
    for column in problem.columns:
        key = ("anew", column, problem.version, best.explanation.key(column))
        rest = best.cost[column] / problem.count(column) - 1.0
        if key not in search.settled and rest > problem.rest(column):
            search.settled.add(key)
            best = better(search, best, _column_anew(search, best, column))
    return None if best is now else best


def _column_anew(search: Search, now: Fit, column: int) -> Fit | None:
    own = local_effects(now, column)
    if not own or now.explanation.curved & {column}:
        return None
    bare = search.refit_column(now, now.explanation.less(own, column), column)
    first = sorted(search.trials(bare, column).values(), key=lambda trial: -trial[0])[:FIRST]
    return min((_grown(search, trial, column) for _, trial in first), key=search.score, default=None)


def _grown(search: Search, now: Fit, column: int) -> Fit:
    """With what then explains most of the joint, as long as that pays."""
    for _ in range(MOST - 1):
        trials = [trial for _, trial in search.trials(now, column).values()]
        best = min(trials, key=search.score, default=now)
        if search.score(best) >= search.score(now):
            break
        now = best
    return now
