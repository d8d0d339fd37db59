"""Leave out what is not missed."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.discrepancy.curves import followed
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, refit, refit_column
from trunk_ros.diagnosis.search.trial import refit_to_win
from trunk_ros.effects import effect


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """A joint's own effects, one at a time; then each that acts on all, or joints that do not show it."""
    for column in best.context.columns:
        own = [t.effect for t in best.hypothesis.on(column) if not effect(t.effect).everywhere]
        if own:
            yield Group(column, [column], partial(_fewer, best, own, column))
    for name in [name for name in best.hypothesis if effect(name).everywhere]:
        yield Group(name, best.context.columns, partial(_everywhere, best, name))


def _fewer(best: Fit, own: list[str], column: int) -> Iterator[Fit]:
    for name in own:
        less = best.hypothesis.without(name, column)
        yield followed(refit_column(best, less, column), [column])


def _everywhere(best: Fit, name: str) -> Iterator[Fit]:
    less = best.hypothesis.without(name)
    yield dropped(best, name) if best.hypothesis.curved else refit_to_win(best, less)
    term = best.hypothesis[name]
    unseen = hidden(best.context, term)
    if 0 < len(unseen) < len(term.columns):
        less = best.hypothesis
        for column in unseen:
            less = less.without(name, column)
        yield refit(best.context, less)


def dropped(now: Fit, name: str, column: int | None = None) -> Fit:
    """Without an effect, on a joint or at all, and all joints fitted again."""
    columns = now.hypothesis[name].columns if column is None else [column]
    return followed(refit(now.context, now.hypothesis.without(name, column)), columns)


DROP = Move("drop", groups, cheap=True)
