"""What happens at one moment, moved to where it fits best nearby: a fit sees only what lies next to it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, refit, refit_column
from trunk_ros.effects import effect

REACH = 1.0  # s
NEARBY = np.linspace(-REACH, REACH, 201)  # s


def moments(now: Fit) -> Iterator[tuple[str, int | None, str]]:
    """(effect, column, parameter) of each moment that a hypothesis has; None where joints share it."""
    for term in now.hypothesis.values():
        names = [p.name for p in effect(term.effect).used(term.form) if p.moment]
        yield from ((term.effect, None, name) for name in names if name in term.shared)
        for column in [c for c in term.columns if c in now.context.columns]:
            yield from ((term.effect, column, name) for name in names if name in term.own[column])


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each moment by itself."""
    for name, column, moment in moments(best):
        columns = best.context.columns if column is None else [column]
        yield Group((name, column, moment), columns, partial(_nearby, best, name, column, moment))


def _nearby(best: Fit, name: str, column: int | None, moment: str) -> list[Fit]:
    term = best.hypothesis[name]
    at = (term.shared if column is None else term.own[column])[moment] + NEARBY
    return [moved(best, name, column, moment, at)]


def moved(now: Fit, name: str, column: int | None, moment: str, at: Array) -> Fit:
    """With a moment at the best of ``at`` (k,) s."""
    trial, costs = now.hypothesis.copy(), []
    values = trial[name].shared if column is None else trial[name].own[column]
    columns = now.context.columns if column is None else [column]
    for one in np.maximum(at, 0.0):
        values[moment] = float(one)
        costs.append(sum(float(np.sum(now.context.whitened(trial, c) ** 2)) for c in columns))
    values[moment] = max(float(at[int(np.argmin(costs))]), 0.0)
    return refit(now.context, trial) if column is None else refit_column(now, trial, column)


ONSET = Move("onset", groups)
