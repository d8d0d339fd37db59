"""What happens at one moment, moved to where it fits best nearby: a fit sees only what lies next to it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, costed_on, refit, refit_column
from trunk_ros.diagnosis.search.score import BETTER, need
from trunk_ros.effects import effect

REACH = 1.0  # s
ROUGHLY, NEARBY = np.linspace(-REACH, REACH, 11), np.linspace(-0.2, 0.2, 11)  # s


def moments(now: Fit) -> Iterator[tuple[str, int | None, str]]:
    """(effect, column, parameter) of each moment that a hypothesis has; None where joints share it."""
    for term in now.hypothesis.values():
        names = [p.name for p in effect(term.effect).used(term.form) if p.moment]
        yield from ((term.effect, None, name) for name in names if name in term.shared)
        for column in now.context.judged(term):
            yield from ((term.effect, column, name) for name in names if name in term.own[column])


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each moment by itself, and that of several joints at once."""
    for name, column, moment in moments(best):
        columns = best.context.columns if column is None else [column]
        yield Group((name, column, moment), columns, partial(_nearby, best, name, column, moment))
    yield from events(best)


def events(best: Fit) -> Iterator[Group]:
    """What happens on several joints, each by itself."""
    for name, term in best.hypothesis.items():
        on = {c: term.moments(c) for c in best.context.judged(term)}
        for moment in sorted({moment for some in on.values() for moment in some}):
            columns = [c for c, some in on.items() if moment in some]
            if len(columns) > 1:
                yield Group((name, moment), columns, partial(_at_once, best, name, columns, moment))


def _at_once(best: Fit, name: str, columns: list[int], moment: str) -> Iterator[Fit]:
    """On as many joints as may be at the moment of one: those that show it no less then."""
    own = best.hypothesis[name].own
    for at in sorted({own[c][moment] for c in columns}):
        trial, cost = best.hypothesis.copy(), dict(best.cost)
        for c in (c for c in columns if own[c][moment] != at):
            trial[name].own[c][moment] = at
            moved = costed_on(best, trial, c).cost[c]
            if moved < best.cost[c] + need(best.context, c):
                cost[c] = moved
            else:
                trial[name].own[c][moment] = own[c][moment]
        yield Fit(trial, cost, best.context)


def dated(now: Fit, name: str, on: int | None = None) -> Fit:
    """With the moments of one effect where each fits best nearby, on one joint or on all; then all that may
    follow them is fitted. One that is best at the end of what was looked at is looked for further on.
    """
    far = True
    while far:
        there, far = _dated(now, name, on)
        if there.total > now.total - BETTER:
            return min(now, there, key=lambda fit: fit.total)
        now = there
    return now


def _dated(now: Fit, name: str, on: int | None) -> tuple[Fit, bool]:
    """The same once, and whether one of them is best at the end of what was looked at."""
    there, columns, far = Fit(now.hypothesis.copy(), now.cost, now.context), set[int | None](), False
    for one, column, moment in moments(now):
        if one == name and on in (None, column):
            home = there.hypothesis[name].home(column)
            before, home[moment] = home[moment], _nearest(there, name, column, moment)
            far = far or abs(home[moment] - before) >= REACH
            columns.add(column)
    if None in columns:
        return refit(now.context, there.hypothesis), far
    for column in (c for c in columns if c is not None):
        there = refit_column(there, there.hypothesis, column)
    return there, far


def _nearby(best: Fit, name: str, column: int | None, moment: str) -> Iterator[Fit]:
    """Nearby, or where the joint was seen to be moved as it rested: it may have been this that moved it."""
    yield moved(best, name, column, moment, _roughly(best, name, column, moment) + NEARBY)
    knocks = [at for view in best.context.views for c, at in view.span.knocks if c == column]
    if knocks:
        yield moved(best, name, column, moment, np.array(sorted(knocks)))


def _nearest(now: Fit, name: str, column: int | None, moment: str) -> float:
    """Where [s] a moment fits best nearby, all else as it is."""
    return best_time(now, name, column, moment, _roughly(now, name, column, moment) + NEARBY)


def _roughly(now: Fit, name: str, column: int | None, moment: str) -> float:
    return best_time(now, name, column, moment, now.hypothesis[name].home(column)[moment] + ROUGHLY)


def moved(now: Fit, name: str, column: int | None, moment: str, at: Array) -> Fit:
    """With a moment at the best of ``at`` (k,) s."""
    trial = now.hypothesis.copy()
    trial[name].home(column)[moment] = best_time(now, name, column, moment, at)
    return refit(now.context, trial) if column is None else refit_column(now, trial, column)


def best_time(now: Fit, name: str, column: int | None, moment: str, at: Array) -> float:
    """The best of ``at`` (k,) s, all else as it is."""
    trial, costs, at = now.hypothesis.copy(), [], np.maximum(at, 0.0)
    columns = now.context.columns if column is None else [column]
    for one in at:
        trial[name].home(column)[moment] = float(one)
        costs.append(sum(float(np.sum(now.context.whitened(trial, c) ** 2)) for c in columns))
    return float(at[int(np.argmin(costs))])


ONSET = Move("onset", groups, cheap=True)
