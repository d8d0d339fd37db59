"""What happens at one moment, moved to where it fits best nearby: a fit sees only what lies next to it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, refit_column
from trunk_ros.effects import effect

REACH = 1.0  # s
NEARBY = np.linspace(-REACH, REACH, 201)  # s


def moments(now: Fit) -> Iterator[tuple[str, int, str]]:
    """(effect, column, parameter) of each moment that a hypothesis has."""
    for term in now.hypothesis.values():
        names = [p.name for p in effect(term.effect).own_parameters(term.form) if p.moment]
        for column in [c for c in term.columns if c in now.context.columns]:
            yield from ((term.effect, column, name) for name in names if name in term.own[column])


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each moment by itself."""
    for name, column, moment in moments(best):
        at = best.hypothesis[name].own[column][moment] + NEARBY
        yield Group((name, column, moment), [column], partial(_nearby, best, name, column, moment, at))


def _nearby(best: Fit, name: str, column: int, moment: str, at: Array) -> list[Fit]:
    return [moved(best, name, column, moment, at)]


def moved(now: Fit, name: str, column: int, moment: str, at: Array) -> Fit:
    """With a moment at the best of ``at`` (k,) s."""
    trial, costs = now.hypothesis.copy(), []
    own = trial[name].own[column]
    for one in np.maximum(at, 0.0):
        own[moment] = float(one)
        costs.append(float(np.sum(now.context.whitened(trial, column) ** 2)))
    own[moment] = max(float(at[int(np.argmin(costs))]), 0.0)
    return refit_column(now, trial, column)


ONSET = Move("onset", groups)
