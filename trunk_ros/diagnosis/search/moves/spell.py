"""What comes again, or with another size: one more change of an effect's size, or one less."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.course import Course
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.moves.onset import dated
from trunk_ros.diagnosis.search.moves.option import put_down
from trunk_ros.diagnosis.search.score import score
from trunk_ros.diagnosis.search.screen import PROMISED, Screen
from trunk_ros.diagnosis.search.trial import refit_column_to_win, refit_to_win
from trunk_ros.diagnosis.search.windows import Window
from trunk_ros.effects import effect
from trunk_ros.effects.moments import LASTING
from trunk_ros.parameter import GROWN, Parameter, leading


class Sized(NamedTuple):
    """What may change its size: an effect on a ``column``, or on all of its joints; or a mass that it makes
    the arm carry, whose moments begin with ``prefix``.
    """

    effect: str
    column: int | None
    lead: Parameter
    prefix: str = ""

    def values(self, hypothesis: Hypothesis) -> dict[str, float]:
        """Those among which its size and its moments are."""
        return hypothesis[self.effect].home(self.column)

    def course(self, hypothesis: Hypothesis) -> Course:
        """As a hypothesis has it."""
        return Course.of(self.values(hypothesis), self.prefix)

    def columns(self, now: Fit) -> list[int]:
        """The joints that show it."""
        if self.column is not None:
            return [self.column]
        on = now.hypothesis[self.effect].columns
        return [c for c in now.context.columns if self.prefix or c in on]

    def taking(self, hypothesis: Hypothesis, course: Course) -> Hypothesis | None:
        """With other sizes; None where they cannot be said."""
        out, moments, lead = hypothesis.copy(), course.values(self.prefix), self.lead
        if moments is None or not moments.keys() <= {m.name for m in effect(self.effect).moments()}:
            return None
        values = self.values(out)
        sizes = [lead.absent + (values[lead.name] - lead.absent) * size for size in course.sizes]
        if lead.carried or lead.name in effect(self.effect).sizes:
            low, high = lead.bounds
            if not all(low <= size <= high for size in sizes):
                return None
        for moment in LASTING:
            values.pop(self.prefix + moment.name, None)
        values |= moments
        if course.first != 1.0:  # else it stays to the last digit, and is known for what is there
            size = lead.absent + (values[lead.name] - lead.absent) * course.first
            values[lead.name] = float(np.clip(size, *lead.bounds))
        return out

    def without(self, hypothesis: Hypothesis) -> Hypothesis:
        """Without what has a size."""
        if not self.prefix:
            return hypothesis.without(self.effect, self.column)
        out = hypothesis.copy()
        put_down(out[self.effect], self.lead.name)
        return out


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each effect that may begin or go on, on each joint where it has a size of its own, and each payload."""
    for one in sized(best) if len(best.context.views) == 1 else ():
        seen = cache(partial(_seen, best, one))
        trials, promise = partial(_changed, best, one, seen), partial(_promise, best, seen)
        yield Group((one.effect, one.column, one.prefix), one.columns(best), trials, promise)


def sized(now: Fit) -> Iterator[Sized]:
    """All that may change its size."""
    for name, term in now.hypothesis.items():
        kind = effect(name)
        if not kind.moments() or not kind.named:
            continue
        lead = leading(kind.own_parameters(term.form))
        for mass in kind.carried():
            if term.shared.get(mass.name):
                yield Sized(name, None, mass, f"{mass.name}_")
        if kind.parameters[0].shared:
            if lead.name in term.shared:
                yield Sized(name, None, lead)
            continue
        for column in now.context.judged(term):
            if lead.name in term.own[column]:
                yield Sized(name, column, lead)


def _promise(now: Fit, seen: Callable[[], Window | None]) -> float:
    """What one more change may gain, and all that may be saved."""
    window = seen()
    return score(now) - now.total + (window.rd * window.size if window else 0.0) / PROMISED


def _seen(now: Fit, one: Sized) -> Window | None:
    """The time in which a change of its size gains most by a linear look."""
    columns = [c for c in one.columns(now) if now.context.timed(c)]
    always = one.taking(now.hypothesis, Course((1.0,)))
    if always is None or not columns:
        return None
    if not effect(one.effect).scalable or GROWN.name in one.values(now.hypothesis):
        return None
    bare, screen = one.without(now.hypothesis), Screen(now.context, now.hypothesis, columns)

    def whole(column: int) -> Array:
        there, without = screen.changes([(always, column), (bare, column)])
        return there - without

    return screen.window({c: whole(c) for c in columns}, (-np.inf, np.inf), once=True)


def _changed(now: Fit, one: Sized, seen: Callable[[], Window | None]) -> Iterator[Fit]:
    """With one change less, or one more: of the size that gains most, or to none and to the first size."""
    if not one.prefix and GROWN.name in one.values(now.hypothesis):
        yield from _otherwise_grown(now, one)
        return
    course = one.course(now.hypothesis)
    others = [course, *course.simpler(), course.rounded()]
    if (window := seen()) is not None:
        more = course.plus(window.size, *window.ends)
        others += [more, more.rounded()]
    best = now
    for other in dict.fromkeys(others):
        there = one.taking(now.hypothesis, other) if other.first else None
        if there is not None and there != now.hypothesis:
            trial = _refitted(best, one, there)
            best = min(best, trial, key=score)
            yield trial
    if best is not now and one.course(best.hypothesis).moments:
        yield dated(best, one.effect, one.column)


def _otherwise_grown(now: Fit, one: Sized) -> Iterator[Fit]:
    """Without the moment at which it begins to grow, or at once."""
    for moment in (m for m in LASTING if m.name in one.values(now.hypothesis)):
        there = now.hypothesis.copy()
        del one.values(there)[moment.name]
        yield _refitted(now, one, there)


def _refitted(best: Fit, one: Sized, there: Hypothesis) -> Fit:
    """A hypothesis refitted, given up where it will not beat the best."""
    return refit_to_win(best, there) if one.column is None else refit_column_to_win(best, there, one.column)


SPELL = Move("spell", groups, settles=True)
