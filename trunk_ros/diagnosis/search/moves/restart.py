"""A joint's own effects chosen once more from another first one: the best alone may bar the best two."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.search.candidates import own_effects
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, refit_column
from trunk_ros.diagnosis.search.moves.add import trials
from trunk_ros.diagnosis.search.score import beats, score
from trunk_ros.levels import REFITTED


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Joints whose own effects leave more than noise, or have no name."""
    for column in best.context.columns:
        own = own_effects(best.hypothesis, column)
        if own and (column in best.hypothesis.curved or best.beyond_noise(column) > 0.0):
            yield Group(column, [column], partial(_anew, best, desk, column, own))


def _anew(best: Fit, desk: Desk, column: int, own: list[str]) -> Iterator[Fit]:
    bare = refit_column(best, best.hypothesis.less(own, column), column)
    for first in _further(bare, desk, column)[:REFITTED]:
        yield _grown(first, desk, column)


def _further(now: Fit, desk: Desk, column: int) -> list[Fit]:
    """With each effect that helps a column, the best first."""
    tried = trials(now, desk, [column])[0]
    found = sorted((t for (_, alone), t in tried.items() if alone), key=lambda t: -t.gain)
    out = []
    for one in found:
        trial = now.hypothesis.copy()
        trial.take(column, one.hypothesis)
        out.append(Fit(trial, now.cost | {column: one.cost}, now.context))
    return out


def _grown(now: Fit, desk: Desk, column: int) -> Fit:
    """With what then explains most of the joint, as long as that pays."""
    while not now.context.work.over:
        best = min(_further(now, desk, column), key=score, default=now)
        if not beats(best, now):
            break
        now = best
    return now


RESTART = Move("restart", groups, grows=True, resort=True)
