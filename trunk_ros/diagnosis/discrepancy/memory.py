"""What no formula fits, as banks of shapes over the motion: curves and drags of other joints, plays of the
joint's own. They are linear in their weights, and have few sources.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.data.noise import alike
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.effects import effect, registry
from trunk_ros.effects.bank import Bank, motion, words_of

STANDS = 1e-3  # of a joint's angle [rad]: a source that moves less shows nothing
ENOUGH = 100_000  # rows
CUTS = 40  # blocks of time, in FOLDS that are left out in turn
FOLDS = 5
AGAIN = 2  # times, since what sources leave tells how many samples are worth one
WORTHS = 4.0 ** np.arange(6)  # samples that may be worth one
PAYS = 0.005  # of what is left of blocks not seen: what a further source must take off it
ROUNDS, SETTLED = 30, 0.1  # of the precisions' logarithms
PRECISIONS = (1e-3, 1e8)
ROUNDED = 1e-12
TINY = 1e-300


@dataclass(frozen=True)
class Source:
    """One motion in a bank, and its design (rows, weights) on the whitened residual, thinned."""

    kind: type[Bank]
    word: str
    low: float
    high: float
    design: Array


def banks() -> list[type[Bank]]:
    """All banks."""
    return [kind for kind in registry().values() if issubclass(kind, Bank)]


def without_banks(hypothesis: Hypothesis, column: int) -> Hypothesis:
    """The hypothesis without its banks on a column."""
    there = [term.effect for term in hypothesis.on(column) if issubclass(effect(term.effect), Bank)]
    return hypothesis.less(there, column)


def sources(context: Context, column: int, like: Hypothesis | None = None) -> list[Source]:
    """What may be in the banks of a column; those that an hypothesis ``like`` has where there is one."""
    chosen = None if like is None else list(_used(like, column))
    found = _possible(context, column) if chosen is None else chosen
    return [s for kind, word in found if (s := _source(context, column, kind, word)) is not None]


def _possible(context: Context, column: int) -> Iterator[tuple[type[Bank], str]]:
    joint, unit = context.joints[column], context.stage.units
    alike_ = tuple(j for j in context.joints if unit.get(j, "rad") == unit.get(joint, "rad"))
    for kind in banks():
        for word in kind.choices(alike_ if kind.own else context.joints, joint):
            yield kind, word


def _used(like: Hypothesis, column: int) -> Iterator[tuple[type[Bank], str]]:
    for term in like.on(column):
        kind = effect(term.effect)
        if issubclass(kind, Bank):
            for word in term.words[column].values():
                yield kind, word


def _source(context: Context, column: int, kind: type[Bank], word: str) -> Source | None:
    signals = [motion(word, context.now(i, column)) for i in range(len(context.views))]
    together = np.concatenate(signals)
    if np.ptp(together) < STANDS:
        return None
    low, high = kind.range_of(together)
    each = zip(*(kind.columns(signal, low, high) for signal in signals), strict=True)
    seen = ([s[view.span.rows] for s, view in zip(shapes, context.views, strict=True)] for shapes in each)
    columns = [thinned(context.whiten_change(shapes, column)) for shapes in seen]
    return Source(kind, word, low, high, np.column_stack(columns))


def thinned(values: Array) -> Array:
    """Of very many rows (n, ...) as many as tell all weights."""
    return values[:: max(len(values) // ENOUGH, 1)]


@dataclass(frozen=True)
class Cuts:
    """Blocks of time, and which of them are left out together."""

    number: np.ndarray
    """(rows,) of the block that each row that counts is in."""
    fold: np.ndarray
    """(CUTS,)."""

    @staticmethod
    def of(counts: Sequence[int]) -> Cuts:
        """Of recordings with so many rows that count. Where there are several, each is left out as a whole:
        how it goes on other days is to be told.
        """
        counts = [n for n in counts if n] or [0]
        each = max(CUTS // len(counts), 1)
        parts = [k * each + np.arange(n) * each // max(n, 1) for k, n in enumerate(counts)]
        alone = len(counts) == 1
        fold = np.arange(CUTS) if alone else np.minimum(np.arange(CUTS) // each, len(counts) - 1)
        return Cuts(np.minimum(np.concatenate(parts), CUTS - 1), fold % FOLDS)

    @staticmethod
    def on(context: Context, column: int) -> Cuts:
        """Of a column."""
        return Cuts.of([len(view.columns[column].counted) for view in context.views])


@dataclass(frozen=True)
class Total:
    """What a linear fit needs of a residual and of all sources' designs: X^T X (k, k), X^T y (k,), y^T y and
    the number of rows.
    """

    normal: Array
    side: Array
    power: float
    count: float


@dataclass(frozen=True)
class Sums:
    """The same by blocks of time."""

    normal: Array
    """(CUTS, k, k)."""
    side: Array
    """(CUTS, k)."""
    power: Array
    """(CUTS,)."""
    count: Array
    """(CUTS,) rows."""
    groups: tuple[tuple[int, ...], ...]
    """Of each source, as its kind has them."""
    fold: np.ndarray
    """(CUTS,)."""

    @staticmethod
    def of(found: Sequence[Source], rest: Array, cuts: Cuts) -> Sums:
        """Of a whitened residual (rows,)."""
        rest, number = thinned(rest), thinned(cuts.number)
        blocks = [np.flatnonzero(number == k) for k in range(CUTS)]
        parts = [(np.column_stack([s.design[rows] for s in found]), rest[rows]) for rows in blocks]
        return Sums(
            np.array([x.T @ x for x, _ in parts]),
            np.array([x.T @ y for x, y in parts]),
            np.array([float(y @ y) for _, y in parts]),
            np.array([float(len(y)) for _, y in parts]),
            tuple(s.kind.groups for s in found),
            cuts.fold,
        )

    def weights(self, chosen: Sequence[int], worth: float) -> Array:
        """Weights (those of each chosen source,); ``worth`` samples count as one.

        Each source has a precision of its own, of the largest marginal likelihood (MacKay 1992, Neural
        Computation 4(3)), and the noise as well.
        """
        return self._likeliest(self._all, chosen, worth)

    def unseen(self, chosen: Sequence[int], worth: float) -> float:
        """Mean over the blocks of the mean square that is left by weights from other blocks."""
        total, at = 0.0, self._places(chosen)
        for others, judged in self._folds:
            total += judged.power
            if chosen:
                weights = self._likeliest(others, chosen, worth)
                bent = judged.normal[np.ix_(at, at)] @ weights
                total += float(weights @ bent - 2.0 * judged.side[at] @ weights)
        return total / CUTS

    def worth(self, chosen: Sequence[int]) -> float:
        """How many samples are worth one: those with which least is left of blocks not seen."""
        return float(min(WORTHS, key=lambda worth: self.unseen(chosen, worth)))

    def _likeliest(self, seen: Total, chosen: Sequence[int], worth: float) -> Array:
        at = self._places(chosen)
        normal, side = seen.normal[np.ix_(at, at)] / worth, seen.side[at] / worth
        sizes = [size for k in chosen for size in self.groups[k]]
        return likeliest(normal, side, seen.power / worth, seen.count / worth, sizes)

    def _over(self, share: Array) -> Total:
        """Sums over the blocks, of each so large a share (CUTS,)."""
        return Total(
            np.tensordot(share, self.normal, 1),
            share @ self.side,
            float(share @ self.power),
            float(share @ self.count),
        )

    @cached_property
    def _all(self) -> Total:
        return self._over(np.ones(CUTS))

    @cached_property
    def _folds(self) -> list[tuple[Total, Total]]:
        """For each fold the other blocks, and its own ones with each row worth one in their number."""
        each = 1.0 / np.maximum(self.count, 1.0)
        folds = [self.fold == fold for fold in np.unique(self.fold)]
        return [
            (self._over(np.where(judged, 0.0, 1.0)), self._over(np.where(judged, each, 0.0)))
            for judged in folds
        ]

    @cached_property
    def ends(self) -> np.ndarray:
        """Where the weights of each source begin among those of all, and where the last one's end."""
        return np.cumsum([0, *(sum(sizes) for sizes in self.groups)])

    def _places(self, chosen: Sequence[int]) -> np.ndarray:
        """Where the weights of some sources are among those of all."""
        if not chosen:
            return np.empty(0, dtype=int)
        return np.concatenate([np.arange(self.ends[k], self.ends[k + 1]) for k in chosen])


def likeliest(normal: Array, side: Array, power: float, count: float, sizes: Sequence[int]) -> Array:
    """Weights (k,) in groups of some sizes, each with a precision of its own. No shape adds much more than
    there is to explain: large ones that cancel where they were seen add up elsewhere.
    """
    of = np.repeat(np.arange(len(sizes)), sizes)
    least = np.diag(normal) / max(power, TINY)
    precision, sharp = np.full(len(sizes), 1.0), count / max(power, TINY)
    weights = np.zeros_like(side)
    for _ in range(ROUNDS):
        inside = sharp * normal + np.diag(precision[of] + least)
        spread = inverse(inside)
        weights = sharp * spread @ side
        told = sizes - np.bincount(of, (precision[of] + least) * np.diag(spread), len(sizes))
        size = np.maximum(np.bincount(of, weights**2, len(sizes)), TINY)
        before, precision = precision, np.clip(told / size, *PRECISIONS)
        rest = power - 2.0 * float(weights @ side) + float(weights @ normal @ weights)
        sharp = max(count - float(told.sum()), 0.1 * count) / max(rest, TINY)
        if np.abs(np.log(precision / before)).max() < SETTLED:
            break
    return weights


def inverse(matrix: Array) -> Array:
    """Of a positive matrix (k, k)."""
    grown = matrix + ROUNDED * float(np.trace(matrix)) / len(matrix) * np.eye(len(matrix))
    upper = np.triu(dpotri(dpotrf(grown)[0])[0])
    return np.asarray(upper + np.triu(upper, 1).T)


def chosen_of(sums: Sums, found: Sequence[Source], worth: float) -> list[int]:
    """The sources that are needed, in the order of their need: one after the other the one with which least
    is left of blocks not seen, as long as that pays.
    """
    chosen: list[int] = []
    best = sums.unseen([], worth)
    while True:
        room = [k for k in range(len(found)) if k not in chosen and _has_room(found, chosen, found[k].kind)]
        trials = [(sums.unseen([*chosen, k], worth), k) for k in room]
        least, k = min(trials, default=(np.inf, 0))
        if least > (1.0 - PAYS) * best:
            return chosen
        best = least
        chosen.append(k)


def _has_room(found: Sequence[Source], chosen: Sequence[int], kind: type[Bank]) -> bool:
    return sum(found[k].kind is kind for k in chosen) < kind.sources


def in_banks(
    bare: Hypothesis, column: int, found: Sequence[Source], weights_of: Sequence[Array]
) -> Hypothesis:
    """The hypothesis with sources and their weights (of each,) on a column."""
    out, taken = bare.copy(), dict[str, int]()
    for source, weights in zip(found, weights_of, strict=True):
        kind = source.kind
        term = out.setdefault(kind.id, Term(kind.id, given=frozenset(p.name for p in kind.parameters)))
        k = taken[kind.id] = taken.get(kind.id, 0) + 1
        own = term.own.setdefault(column, {})
        own |= {f"weight_{k}_{i}": float(w) for i, w in enumerate(weights, start=1)}
        own |= {f"low_{k}": source.low, f"high_{k}": source.high}
        term.words.setdefault(column, {})[words_of(kind.sources)[k - 1]] = source.word
    return out


def drawn(context: Context, bare: Hypothesis, column: int, found: Sequence[Source]) -> Hypothesis:
    """The hypothesis with the banks that its rest on a column needs."""
    rest = context.whitened(bare, column)
    sums, worth = Sums.of(found, rest, Cuts.on(context, column)), alike([rest])
    for _ in range(AGAIN):
        chosen = chosen_of(sums, found, worth)
        worth = sums.worth(chosen)
    return _with(bare, column, found, sums, chosen, worth)


def redrawn_banks(context: Context, bare: Hypothesis, column: int, like: Hypothesis) -> Hypothesis:
    """The hypothesis with the banks of another one, weighed anew."""
    found = sources(context, column, like)
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
