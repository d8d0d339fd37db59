"""A joint that follows another one along a curve, in the place of a straight line or of a curve without a
name.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

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
    """Each joint and each other one that it follows."""
    for kind in _kinds(best):
        for name, column, source, bare in _straight(best, kind):
            bent = _bent(best, bare, column, kind, source)
            if bent is not None:
                trials, promise = partial(_trials, best, bent, column), partial(_promise, best, bent, column)
                yield Group(name, [column], trials, promise)


def _kinds(best: Fit) -> list[type[Bank]]:
    """Curves over another joint that have a name."""
    stage = best.context.stage.name
    return [k for k in banks() if k.named and k.stage == stage and not (k.remembers or k.own)]


def _straight(best: Fit, kind: type[Bank]) -> Iterator[tuple[str, int, str, Hypothesis]]:
    """Effects by which joints follow others, each with a joint, the one that it follows, and the hypothesis
    without that.
    """
    context, hypothesis = best.context, best.hypothesis
    for name, term in hypothesis.items():
        like, known = effect(name), context.known
        if not (name in confused(kind.id) or (issubclass(like, Curve) and like.linear)):
            continue
        for column in [c for c in term.columns if c in context.columns]:
            has = column in hypothesis[kind.id].own if kind.id in hypothesis else False
            if has or (name in known and column in known[name].own):
                continue
            words = list(term.words.get(column, {}).values())
            for k, word in enumerate(words):
                if word in context.joints and word != context.joints[column]:
                    one = len(words) == 1
                    yield (
                        name,
                        column,
                        word,
                        (
                            hypothesis.less([name], column)
                            if one
                            else without_source(hypothesis, name, column, k)
                        ),
                    )


def _bent(best: Fit, bare: Hypothesis, column: int, kind: type[Bank], word: str) -> Hypothesis | None:
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


def _trials(best: Fit, bent: Hypothesis, column: int) -> Iterator[Fit]:
    yield refit_column(best, bent, column)


def _promise(best: Fit, bent: Hypothesis, column: int) -> float:
    """What the curve gains as a linear look has it, less what it costs."""
    now = costed_on(best, bent, column)
    gain = best.cost[column] - now.cost[column]
    return max(gain, 0.0) / PROMISED + priced(best) - priced(now)


BEND = Move("bend", groups, settles=True)
