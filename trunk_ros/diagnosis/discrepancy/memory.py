"""What no formula fits, as banks of shapes over the motion: curves and drags of other joints, plays of the
joint's own. They are linear in their weights, and have few sources.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.motion_content import STANDS, comes_back, passes_again
from trunk_ros.data.noise import alike
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.bank_weights import Cuts, Source, Sums, chosen_of, thinned
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects import effect, registry
from trunk_ros.effects.bank import PATH_OF, Bank, motion, words_of
from trunk_ros.stage import SENSOR

AGAIN = 2  # times, since what sources leave tells how many samples are worth one


def banks() -> list[type[Bank]]:
    """All banks."""
    return [kind for kind in registry().values() if issubclass(kind, Bank)]


def without_banks(hypothesis: Hypothesis, column: int) -> Hypothesis:
    """The hypothesis without its banks on a column."""
    there = [term.effect for term in hypothesis.on(column) if issubclass(effect(term.effect), Bank)]
    return hypothesis.less(there, column)


def sources(context: Context, column: int) -> Iterator[Source]:
    """What may be in the banks of a column; each is made when it is asked for."""
    return filter(None, (source_of(context, column, *each) for each in _possible(context, column)))


def _possible(context: Context, column: int) -> Iterator[tuple[type[Bank], str]]:
    joint, unit = context.joints[column], context.stage.unit
    alike_ = tuple(j for c, j in enumerate(context.joints) if unit(c) == unit(column))
    for kind in banks():
        for word in kind.choices(alike_ if kind.own and kind.axes == 1 else context.joints, joint):
            if not word.startswith(PATH_OF):  # it takes the place of the joint's own
                yield kind, word


def _used(like: Hypothesis, column: int) -> Iterator[tuple[type[Bank], str]]:
    for term in like.on(column):
        kind = effect(term.effect)
        if issubclass(kind, Bank):
            for word in term.words[column].values():
                yield kind, word


def _along(context: Context, bare: Hypothesis, column: int, source: Source) -> Source | None:
    """The source as it is, but loops that change with the posture on a joint of which a name says which
    neighbour drags it follow where the names take it: contacts rub wherever the wire is dragged, whoever
    drags it.
    """
    dragged = any(effect(term.effect).named and column in term.words for term in bare.on(column))
    path = PATH_OF + context.joints[column]
    if not (dragged and path in source.kind.choices(context.joints, context.joints[column])):
        return source
    return source_of(context, column, source.kind, path, bare)


def _signals(context: Context, column: int, kind: type[Bank], word: str, bare: Hypothesis) -> list[Array]:
    """A source's motion, one (m,) a span."""
    if not word.startswith(PATH_OF):
        return [motion(word, context.now(i, column)) for i in range(len(context.views))]
    later = [term.effect for term in bare.on(column) if effect(term.effect).place > kind.place]
    before = bare.less([name for name in later if effect(name).place < SENSOR], column)
    stage = context.stage
    assert isinstance(stage, WireStage)
    return [stage.path(context, i, before, column) for i in range(len(context.views))]


def source_of(
    context: Context, column: int, kind: type[Bank], word: str, bare: Hypothesis | None = None
) -> Source | None:
    """A source with its design; ``bare``: the names, where it follows what they do."""
    signals = _signals(context, column, kind, word, Hypothesis() if bare is None else bare)
    together = np.concatenate(signals)
    if np.ptp(together, axis=0).min() < STANDS:
        return None
    if kind.remembers and not any(comes_back(s) for s in signals):
        return None
    if kind.fades and not any(passes_again(s) for s in signals):
        return None
    low, high = kind.range_of(together)
    each = zip(*(kind.columns(signal, low, high) for signal in signals), strict=True)
    seen = ([view.span.measured(s) for s, view in zip(shapes, context.views, strict=True)] for shapes in each)
    rows = context.count(column)
    design = np.empty((len(thinned(np.empty(rows))), kind.weights))
    for k, shapes in enumerate(seen):
        design[:, k] = thinned(context.whiten_change(shapes, column))
    return Source(kind, word, low, high, design)


def in_banks(
    bare: Hypothesis, column: int, found: Sequence[Source], weights_of: Sequence[Array]
) -> Hypothesis:
    """The hypothesis with sources and their weights (of each,) on a column."""
    out, taken = bare.copy(), dict[str, int]()
    for source, weights in zip(found, weights_of, strict=True):
        kind = source.kind
        term = out.setdefault(kind.id, Term(kind.id, given=frozenset(p.name for p in kind.parameters)))
        k = taken[kind.id] = taken.get(kind.id, 0) + 1
        term.own.setdefault(column, {}).update(kind.said(k, source.low, source.high, weights))
        term.words.setdefault(column, {})[words_of(kind.sources)[k - 1]] = source.word
    return out


def drawn(context: Context, bare: Hypothesis, column: int, found: Sequence[Source]) -> Hypothesis:
    """The hypothesis with the banks that its rest on a column needs."""
    found = [s for source in found if (s := _along(context, bare, column, source)) is not None]
    rest = context.whitened(bare, column)
    sums, worth = Sums.of(found, rest, Cuts.on(context, column)), alike([rest])
    for _ in range(AGAIN):
        chosen = chosen_of(sums, found, worth)
        worth = sums.worth(chosen)
    return _with(bare, column, found, sums, chosen, worth)


def redrawn_banks(context: Context, bare: Hypothesis, column: int, like: Hypothesis) -> Hypothesis:
    """The hypothesis with the banks of another one, weighed anew."""
    used = [source_of(context, column, kind, word, bare) for kind, word in _used(like, column)]
    found = [source for source in used if source is not None]
    rest = context.whitened(bare, column)
    if not found or not len(rest):
        return bare
    sums, chosen = Sums.of(found, rest, Cuts.on(context, column)), list(range(len(found)))
    return _with(bare, column, found, sums, chosen, sums.worth(chosen))


def _with(
    bare: Hypothesis, column: int, found: Sequence[Source], sums: Sums, chosen: list[int], worth: float
) -> Hypothesis:
    if not chosen:
        return bare
    weights = sums.weights(chosen, worth)
    ends = np.cumsum([found[k].kind.weights for k in chosen])[:-1]
    return in_banks(bare, column, [found[k] for k in chosen], np.split(weights, ends))
