"""Two effects together in the place of one that was found: what neither does alone, both may do."""

from __future__ import annotations

from collections.abc import Collection
from itertools import combinations, product

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.evidence.rivals import Looks
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.search.candidates import Candidate, extended
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.fit import Fit, refit_column
from trunk_ros.diagnosis.search.screen import PROMISED
from trunk_ros.diagnosis.search.size import scaled
from trunk_ros.effects import effect
from trunk_ros.guards import BLIND
from trunk_ros.levels import REFITTED

Pair = tuple[str, str]
Starts = tuple[Candidate, Candidate]
Changes = dict[str, list[tuple[Candidate, Array]]]
"""By effect, its starts, and the unit noise that each changes beside what values that are there follow."""


def pairs(
    state: Fit, name: str, bare: Fit, looks: Looks, limit: float, but: Collection[str]
) -> dict[Pair, float]:
    """Loss of each pair of effects that loses less than ``limit`` in the place of one, on all its joints; not
    of such as are rivals alone (``but``).
    """
    columns = state.context.judged(state.hypothesis[name])
    seen = {c: _changes(looks, c, but) for c in columns}
    names = set.intersection(*map(set, seen.values())) if seen else set()
    goal = sum(state.cost[c] for c in columns) + limit
    promising: list[tuple[float, Pair, dict[int, Starts]]] = []
    for pair in combinations(sorted(names), 2):
        best = {c: _best(looks, c, some, pair) for c, some in seen.items()}
        left = sum(looks.screen.left(c) - gain / PROMISED for c, (gain, _) in best.items())
        if left < goal and all(starts for _, starts in best.values()):
            promising.append((left, pair, {c: starts for c, (_, starts) in best.items() if starts}))
    best_of = sorted(promising, key=lambda one: one[:2])[:REFITTED]
    tried = each(bare.context.work, lambda one: _fitted(state, bare, *one[1:]), best_of)
    return {pair: loss for pair, loss in tried if loss < limit}


def _changes(looks: Looks, column: int, but: Collection[str]) -> Changes:
    screen = looks.screen
    some = [one for one in looks.promising(column, but) if effect(one.effect).scalable]
    there = [(extended(screen.context, screen.hypothesis, one), column) for one in some]
    out: Changes = {}
    for one, change in zip(some, screen.changes(there), strict=True):
        out.setdefault(one.effect, []).append((one, screen.beyond_values(change, column)))
    return out


def _best(looks: Looks, column: int, seen: Changes, pair: Pair) -> tuple[float, Starts | None]:
    """What a pair gains at most on a column by a linear look, and the starts with which it does."""
    rest, best, chosen = looks.screen.rest[column], 0.0, None
    for (first, a), (second, b) in product(seen[pair[0]], seen[pair[1]]):
        normal = np.array([[a @ a, a @ b], [a @ b, b @ b]])
        if np.linalg.det(normal) <= BLIND * normal[0, 0] * normal[1, 1]:
            continue
        along = np.array([a @ rest, b @ rest])
        share = np.linalg.solve(normal, along)
        both = zip((first, second), share, np.diag(normal), strict=True)
        starts = [scaled(effect(x.effect), x, float(k * size), float(size)) for x, k, size in both]
        if float(share @ along) > best and starts[0] and starts[1]:
            best, chosen = float(share @ along), (starts[0], starts[1])
    return best, chosen


def _fitted(state: Fit, bare: Fit, pair: Pair, starts: dict[int, Starts]) -> tuple[Pair, float]:
    loss, context = 0.0, bare.context
    for column, (first, second) in starts.items():
        there = extended(context, extended(context, bare.hypothesis, first), second)
        done = refit_column(bare, there, column)
        shown = not any(column in hidden(context, done.hypothesis[one]) for one in pair)
        loss += done.cost[column] - state.cost[column] if shown else np.inf
    return pair, float(loss)
