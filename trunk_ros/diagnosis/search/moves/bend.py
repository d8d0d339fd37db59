"""A joint that follows another one along a curve, in the place of a straight line or of a curve without a
name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial

import numpy as np

from trunk_ros.diagnosis.discrepancy.bank_weights import thinned
from trunk_ros.diagnosis.discrepancy.memory import banks, in_banks, source_of
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, costed_on, refit_column
from trunk_ros.diagnosis.search.moves.source import without_source
from trunk_ros.diagnosis.search.score import SIGNIFICANT, chance, priced
from trunk_ros.diagnosis.search.screen import PROMISED
from trunk_ros.effects import confused, effect
from trunk_ros.effects.bank import Bank
from trunk_ros.effects.curve import Curve


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each joint by each effect by which it follows others."""
    for kind in _kinds(best):
        for name, column in _straight(best, kind):
            bent = cache(partial(_bent, best, name, column, kind))
            trials, promise = partial(_trials, best, bent, column), partial(_promise, best, bent, column)
            yield Group(name, [column], trials, promise)


def _kinds(best: Fit) -> list[type[Bank]]:
    """Curves over another joint that have a name."""
    stage = best.context.stage.name
    return [k for k in banks() if k.named and k.stage == stage and not (k.remembers or k.own)]


def _straight(best: Fit, kind: type[Bank]) -> Iterator[tuple[str, int]]:
    """Effects by which joints follow others, each with a joint that does so."""
    context, hypothesis = best.context, best.hypothesis
    for name, term in hypothesis.items():
        like, known = effect(name), context.known
        if not (name in confused(kind.id) or (issubclass(like, Curve) and like.linear and not like.also)):
            continue
        for column in context.judged(term):
            has = kind.id in hypothesis and column in hypothesis[kind.id].own
            if not (has or (name in known and column in known[name].own)):
                yield name, column


def _bent(best: Fit, name: str, column: int, kind: type[Bank]) -> list[Hypothesis]:
    """With a curve in the place of each joint that one follows, where there is one."""
    joints, words = best.context.joints, best.hypothesis.get_words(name, column)
    found = []
    for k, word in enumerate(words):
        if word in joints and word != joints[column]:
            bare = (
                best.hypothesis.without(name, column)
                if len(words) == 1
                else without_source(best.hypothesis, name, column, k)
            )
            found.append(_along_a_curve(best, bare, column, kind, word))
    return [shaped for there in found if there is not None for shaped in _forms(there, best.hypothesis, kind)]


def _forms(there: Hypothesis, now: Hypothesis, kind: type[Bank]) -> list[Hypothesis]:
    """A curve before the joint's friction and behind it; as on other joints, where they have one."""
    return [there] if kind.id in now else [there.reformed(kind.id, form) for form in kind.forms]


def _along_a_curve(
    best: Fit, bare: Hypothesis, column: int, kind: type[Bank], word: str
) -> Hypothesis | None:
    """With a curve that a linear look finds; None where the other joint shows none, or it is as good as its
    chord: what a line leaves may be where it acts.
    """
    source = source_of(best.context, column, kind, word)
    if source is None:
        return None
    rest = thinned(best.context.whitened(bare, column))
    line = source.design @ np.column_stack([np.ones(kind.weights), np.arange(kind.weights)])
    weights, straight = (np.linalg.lstsq(design, rest, rcond=None)[0] for design in (source.design, line))
    bends = float(np.sum((rest - line @ straight) ** 2) - np.sum((rest - source.design @ weights) ** 2))
    if bends * best.context.count(column) < SIGNIFICANT * chance(best.context, column) * len(rest):
        return None
    out = in_banks(bare, column, [source], [np.asarray(weights, dtype=np.float64)])
    out[kind.id].given = frozenset(name for name in out[kind.id].given if not name.startswith("weight"))
    return out


def _trials(best: Fit, bent: Callable[[], list[Hypothesis]], column: int) -> Iterator[Fit]:
    for there in bent():
        yield refit_column(best, there, column)


def _promise(best: Fit, bent: Callable[[], list[Hypothesis]], column: int) -> float:
    """What the best of the curves gains as a linear look has it, less what it costs."""
    looks = [costed_on(best, there, column) for there in bent()]
    gains = (best.cost[column] - now.cost[column] for now in looks)
    worths = (
        max(g, 0.0) / PROMISED + priced(best) - priced(now) for g, now in zip(gains, looks, strict=True)
    )
    return max(worths, default=0.0)


BEND = Move("bend", groups, settles=True)
