"""A joint's values of an effect begun from those of the joint that shows it most: joints of one arm are much
alike, and what one hardly tells may have several minima.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property, partial

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, change, refit_column
from trunk_ros.diagnosis.search.state import structure_of
from trunk_ros.effects import effect
from trunk_ros.levels import SEVERAL


class Alike:
    """An effect of several joints that each have several values, which nobody states."""

    def __init__(self, state: Fit, name: str, names: list[str]):
        self.state, self.name, self.names = state, name, names
        self.columns = state.context.judged(state.hypothesis[name])

    @cached_property
    def surest(self) -> int:
        """The joint on which the effect changes most, over the noise."""
        less = self.state.hypothesis.without(self.name)
        changes = {c: change(self.state.context, self.state.hypothesis, less, c) for c in self.columns}
        return max(self.columns, key=lambda c: float(changes[c] @ changes[c]))

    def on(self, column: int, now: Hypothesis) -> Hypothesis | None:
        """With the values that the surest joint has ``now`` on another one; None on itself, and in another
        unit.
        """
        unit = self.state.context.stage.unit
        if self.surest == column or unit(self.surest) != unit(column):
            return None
        out = now.copy()
        own, theirs = out[self.name].own[column], out[self.name].own[self.surest]
        out[self.name].own[column] = own | {n: theirs[n] for n in self.names if n in own and n in theirs}
        return out


def effects_of_several(state: Fit) -> Iterator[Alike]:
    """Each such effect of a hypothesis."""
    for name, term in state.hypothesis.items():
        kind, own = effect(name), effect(name).own_parameters(term.form)
        names = [p.name for p in own if not p.shared and p.name not in term.given]
        several = min(len(names), len(state.context.judged(term))) >= SEVERAL
        if kind.named and several and not kind.texts:
            yield Alike(state, name, names)


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each joint of each such effect."""
    for one in effects_of_several(best):
        for column in one.columns:
            what = (one.name, structure_of(best.hypothesis[one.name]), column)
            yield Group(what, [column], partial(_begun, one, column))


def _begun(one: Alike, column: int) -> Iterator[Fit]:
    there = one.on(column, one.state.hypothesis)
    if there is not None:
        yield refit_column(one.state, there, column)


LIKE = Move("like", groups, resort=True)
