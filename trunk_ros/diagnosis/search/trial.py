"""Effects tried on one joint: a linear look ranks them, and what can still win is refitted."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.search.candidates import Candidate, extended
from trunk_ros.diagnosis.search.fit import Fit, refit, refit_column
from trunk_ros.diagnosis.search.score import SIGNIFICANT, priced, prices, score
from trunk_ros.diagnosis.search.screen import PROMISED, Kept, Screen
from trunk_ros.effects import Effect

PROMISING = 4  # local candidates a joint that are refitted in full, and as many that act all the time


@dataclass(frozen=True)
class Look:
    """A hypothesis, and by a linear look what is left of a joint before it and how much it gains.

    ``always``: it is refitted whatever that promises.
    """

    hypothesis: Hypothesis
    left: float
    gain: float
    always: bool = False


def column_trials(
    best: Fit, column: int, kinds: list[type[Effect]], kept: Kept | None = None, goal: float = np.inf
) -> Iterator[Fit]:
    """The most promising further effects on a joint, refitted there where they may beat ``best``, and bring
    the score to a ``goal``.
    """
    yield from refitted(best, column, looks(best.context, best.hypothesis, column, kinds, kept=kept), goal)


def looks(
    context: Context, bare: Hypothesis, column: int, kinds: list[type[Effect]],
    always: Collection[str] = (), kept: Kept | None = None,
) -> Iterator[Look]:  # fmt: skip
    """The most promising effects on a joint of ``bare`` and those of ``always``, in their promising forms."""
    screen = Screen(context, bare, [column])
    left = screen.left(column)
    for candidate in screen.ranked(kinds, column, PROMISING, always, kept):
        there = extended(context, bare, candidate)
        yield Look(there, left, candidate.gain, candidate.effect in always)


def on_all_joints(screen: Screen, kinds: list[type[Effect]]) -> list[Candidate]:
    """What a linear look finds of effects that act on all joints alike, the most promising first."""
    looked = each(screen.context.work, screen.all_everywhere, kinds)
    return sorted((c for some in looked for c in some if c.gain > SIGNIFICANT), key=lambda c: -c.gain)


def begun_on(
    context: Context, bare: Hypothesis, kind: type[Effect], form: str, columns: Iterable[int]
) -> Hypothesis | None:
    """An effect on further joints, each at what a linear look finds best; None where one does not show it."""
    columns = list(columns)
    screen, out = Screen(context, bare, columns), bare
    for column in columns:
        start = screen.local_form(kind, form, column)
        if start is None:
            return None
        out = extended(context, out, start)
    return out


def most_promising(best: Fit, column: int, found: Iterable[Look], most: int) -> list[Look]:
    """Of looks at different hypotheses those nearest to what they need, and what is always tried."""
    found = sorted(found, key=lambda look: look.left - look.gain - _goal(best, look.hypothesis, column))
    return [*found[:most], *(look for look in found[most:] if look.always)]


def refitted(best: Fit, column: int, found: Iterable[Look], goal: float = np.inf) -> Iterator[Fit]:
    """Those that may beat ``best``, and what was better before them, and bring the score to a ``goal``,
    refitted on their joint.
    """
    for look in found:
        needed = _goal(best, look.hypothesis, column, goal)
        if look.always or look.left - look.gain / PROMISED <= needed:
            trial = refit_column(best, look.hypothesis, column, needed)
            if score(trial) < score(best):
                best = trial
            yield trial


def may_win(best: Fit, there: Hypothesis, screen: Screen, gain: float) -> bool:
    """Whether a hypothesis on all joints may beat ``best``, by what a linear look promises."""
    return screen.may_come_to(there, gain) + prices(best.context, there) <= score(best)


def refit_to_win(best: Fit, there: Hypothesis, spared: int = 0) -> Fit:
    """A hypothesis refitted on all joints, given up where it will not beat ``best``, even without what is
    left of the worst ones, so many of which may be ``spared``.
    """
    return refit(best.context, there, score(best) - prices(best.context, there), spared)


def refit_column_to_win(best: Fit, there: Hypothesis, column: int) -> Fit:
    """One joint of a hypothesis refitted, given up where it will not beat ``best``."""
    return refit_column(best, there, column, _goal(best, there, column))


def _goal(best: Fit, hypothesis: Hypothesis, column: int, goal: float = np.inf) -> float:
    """What a joint's squared residuals have to come to for the score to be as good as that of ``best``, and
    as a ``goal``.
    """
    others = Fit(hypothesis, {c: cost for c, cost in best.cost.items() if c != column}, best.context)
    return min(score(best), goal) - priced(others)
