"""What happens at one moment, moved to where it fits best nearby: a fit sees only what lies next to it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, costed_on, refit, refit_column
from trunk_ros.diagnosis.search.score import BETTER, need
from trunk_ros.effects import effect

REACH = 1.0  # s
ROUGHLY, NEARBY = np.linspace(-REACH, REACH, 11), np.linspace(-0.2, 0.2, 11)  # s


class Moment(NamedTuple):
    """A parameter that says when; ``column`` None where joints share it."""

    effect: str
    column: int | None
    name: str

    def home(self, hypothesis: Hypothesis) -> dict[str, float]:
        """The values among which it is."""
        return hypothesis[self.effect].home(self.column)

    def columns(self, now: Fit) -> list[int]:
        """The joints that it may matter to."""
        return now.context.columns if self.column is None else [self.column]


def moments(now: Fit) -> Iterator[Moment]:
    """Each moment that a hypothesis has."""
    for term in now.hypothesis.values():
        names = [p.name for p in effect(term.effect).used(term.form) if p.moment]
        yield from (Moment(term.effect, None, name) for name in names if name in term.shared)
        for column in now.context.judged(term):
            yield from (Moment(term.effect, column, name) for name in names if name in term.own[column])


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each moment by itself, and that of several joints at once."""
    for moment in moments(best):
        yield Group(moment, moment.columns(best), partial(_nearby, best, moment))
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
    for moment in moments(now):
        if moment.effect == name and on in (None, moment.column):
            home = moment.home(there.hypothesis)
            before, home[moment.name] = home[moment.name], _nearest(there, moment)
            far = far or abs(home[moment.name] - before) >= REACH
            columns.add(moment.column)
    if None in columns:
        return refit(now.context, there.hypothesis), far
    for column in (c for c in columns if c is not None):
        there = refit_column(there, there.hypothesis, column)
    return there, far


def _nearby(best: Fit, moment: Moment) -> Iterator[Fit]:
    """Nearby, or where the joint was seen to be moved as it rested: it may have been this that moved it."""
    yield moved(best, moment, _roughly(best, moment) + NEARBY)
    knocks = [at for view in best.context.views for c, at in view.span.knocks if c == moment.column]
    if knocks:
        yield moved(best, moment, np.array(sorted(knocks)))


def _nearest(now: Fit, moment: Moment) -> float:
    """Where [s] a moment fits best nearby, all else as it is."""
    return _best_time(now, moment, _roughly(now, moment) + NEARBY)


def _roughly(now: Fit, moment: Moment) -> float:
    return _best_time(now, moment, moment.home(now.hypothesis)[moment.name] + ROUGHLY)


def moved(now: Fit, moment: Moment, at: Array) -> Fit:
    """With a moment at the best of ``at`` (k,) s."""
    trial, column = now.hypothesis.copy(), moment.column
    moment.home(trial)[moment.name] = _best_time(now, moment, at)
    return refit(now.context, trial) if column is None else refit_column(now, trial, column)


def _best_time(now: Fit, moment: Moment, at: Array) -> float:
    """The best of ``at`` (k,) s, all else as it is."""
    at, context = np.maximum(at, 0.0), now.context
    trials = [now.hypothesis.copy() for _ in at]
    for trial, one in zip(trials, at, strict=True):
        moment.home(trial)[moment.name] = float(one)
    costs = np.zeros(len(at))
    for column in moment.columns(now):
        for first in range(0, len(at), context.together):
            some = slice(first, first + context.together)
            left = context.whitened_each([(trial, column) for trial in trials[some]])
            costs[some] += [np.sum(rest**2) for rest in left]
    return float(at[int(np.argmin(costs))])


ONSET = Move("onset", groups, cheap=True)
