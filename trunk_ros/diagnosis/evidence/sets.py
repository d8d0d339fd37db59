"""Two effects together in the place of one that was found: what neither does alone, both may."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import combinations, product

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import REFITTED
from trunk_ros.diagnosis.search.candidates import Candidate, extended, is_open, local_kinds
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.fit import Fit, refit_column
from trunk_ros.diagnosis.search.screen import PROMISED, Screen
from trunk_ros.effects import Effect

Pair = tuple[str, str]


def pairs(
    state: Fit, name: str, bare: Fit, limit: float, alone: Collection[str]
) -> dict[Pair, tuple[float, Hypothesis]]:
    """Pairs of effects that lose less than ``limit`` in the place of one on its joints, by their names, with
    the loss and the hypothesis with them; not of those that are as good ``alone``.
    """
    columns = [c for c in state.hypothesis[name].columns if c in state.context.columns]
    looks = {c: _Look.on(bare, c, {*alone, name}) for c in columns}
    shared = set.intersection(*({*look.kinds} for look in looks.values())) if looks else set()
    promise = {}
    for pair in combinations(sorted(shared), 2):
        gains = {c: look.best(*pair) for c, look in looks.items()}
        left = sum(looks[c].left - gain for c, (gain, _) in gains.items())
        if left < sum(state.cost[c] for c in columns) + limit / PROMISED:
            promise[pair] = left, {c: found for c, (_, found) in gains.items()}
    out = {}
    for pair in sorted(promise, key=lambda one: promise[one][0])[:REFITTED]:
        loss, fitted = 0.0, bare.hypothesis.copy()
        for c, found in promise[pair][1].items():
            there = bare.hypothesis
            for candidate in found:
                there = extended(bare.context, there, candidate)
            done = refit_column(bare, there, c)
            if any(c in hidden(bare.context, done.hypothesis[one]) for one in pair):
                loss = np.inf
            loss += done.cost[c] - state.cost[c]
            fitted.take(c, done.hypothesis)
        if loss < limit:
            out[pair] = float(loss), fitted
    return out


class _Look:
    """What each start of each effect changes on a column, and what is left of it."""

    def __init__(self, left: float, rest: Array, kinds: dict[str, list[tuple[Candidate, Array]]]):
        """``kinds``: starts by effect, each with the unit-noise change (rows,)."""
        self.left, self.rest, self.kinds = left, rest, kinds

    @classmethod
    def on(cls, bare: Fit, column: int, without: Collection[str]) -> _Look:
        """``without``: effects that are not looked at."""
        context, hypothesis = bare.context, bare.hypothesis
        screen, q = Screen(context, hypothesis, [column]), None
        q = screen.basis[column]
        kinds = {}
        for kind in local_kinds(context):
            if kind.id not in without and kind.id not in hypothesis and is_open(context, hypothesis, kind, column):
                found = list(_starts(screen, kind, column))
                there = screen.changes([extended(context, hypothesis, one) for one in found], column)
                kinds[kind.id] = [(one, d - q @ (q.T @ d)) for one, d in zip(found, there, strict=True)]
        return cls(screen.left(column), screen.rest[column], {k: v for k, v in kinds.items() if v})

    def best(self, first: str, second: str) -> tuple[float, tuple[Candidate, Candidate]]:
        """What two effects gain together at most, by a linear look, and their starts."""
        ...
