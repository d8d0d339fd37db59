"""How sources of a bank are chosen, on blocks of time that their weights have not seen, and how large weights
are: linear fits by marginal likelihood.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.precisions import Beside, Total, Weighed, weighed
from trunk_ros.effects.bank import Bank
from trunk_ros.levels import REFITTED, ROWS, SLIGHT, TENFOLD

AMPLE = round(TENFOLD) * ROWS
CUTS = 40  # blocks of time, in FOLDS that are left out in turn
FOLDS = 5
WORTHS = 4.0 ** np.arange(6)  # samples that may be worth one
PAYS = 0.005  # of what is left of blocks not seen: what a further source must take off it
MANY = 100  # weights, beside more of which only the sources are tried that a cheap look finds best


@dataclass(frozen=True)
class Source:
    """One motion in a bank, and its design (rows, weights) on the whitened residual, thinned."""

    kind: type[Bank]
    word: str
    low: Any
    high: Any
    """Ends of its range, or of each of its motions (axes,)."""
    design: Array


def thinned(values: Array) -> Array:
    """Of very many rows (n, ...) as many as tell all weights."""
    return values[:: max(len(values) // AMPLE, 1)]


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
        return Cuts.of([int(np.count_nonzero(view.columns[column].valid)) for view in context.views])


@dataclass(frozen=True)
class Tried:
    """What is left of blocks by weights from other blocks."""

    left: Array
    """(folds,) sums of the blocks' mean squares."""
    fits: tuple[Weighed, ...] = ()
    """Of the other blocks, for each fold."""

    @property
    def unseen(self) -> float:
        """Mean over the blocks."""
        return float(self.left.sum()) / CUTS


@dataclass(frozen=True)
class Sums:
    """What linear fits need, by blocks of time."""

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
        size = sum(s.design.shape[1] for s in found)
        normal, side = np.empty((CUTS, size, size)), np.empty((CUTS, size))
        power, count = np.empty(CUTS), np.empty(CUTS)
        for k in range(CUTS):  # block by block: all rows of all sources would not fit into memory twice
            rows = np.flatnonzero(number == k)
            x, y = np.column_stack([s.design[rows] for s in found]), rest[rows]
            normal[k], side[k], power[k], count[k] = x.T @ x, x.T @ y, y @ y, len(y)
        return Sums(normal, side, power, count, tuple(s.kind.groups for s in found), cuts.fold)

    def weights(self, chosen: Sequence[int], worth: float) -> Array:
        """Weights (those of each chosen source,); ``worth`` samples count as one."""
        at, sizes = self._places(chosen), self._sizes(chosen)
        return weighed(self._all.of(at, worth), sizes).weights

    def tried(self, chosen: Sequence[int], worth: float, begun: Sequence[Weighed] | None = None) -> Tried:
        """Sources weighed in all folds, from fits that have ``begun``."""
        if not chosen:
            return Tried(np.array([judged.power for _, judged in self._folds]))
        at, sizes = self._places(chosen), self._sizes(chosen)
        fits = tuple(
            weighed(others.of(at, worth), sizes, None if begun is None else begun[fold])
            for fold, (others, _) in enumerate(self._folds)
        )
        return Tried(self._left(at, fits), fits)

    def beside(self, chosen: Sequence[int], further: int, worth: float, now: Tried) -> Tried:
        """The same with a further source beside those of ``now``; known where these are chosen once more."""
        key = (*chosen, further), worth
        if key not in self._known:
            self._known[key] = self.tried([*chosen, further], worth, self._begun(now, further))
        return self._known[key]

    def _begun(self, now: Tried, further: int) -> list[Weighed] | None:
        """What fits with a further source go on from, as those ``now`` have found what is beside it."""
        new = np.ones(len(self.groups[further]))
        return [
            Weighed(fit.weights, np.concatenate([fit.precision, new]), fit.sharp) for fit in now.fits
        ] or None

    def looked(self, chosen: Sequence[int], worth: float, now: Tried) -> dict[int, float]:
        """What is left by each of the other sources beside what is chosen, of which the precisions
        stay as they are ``now``.
        """
        there, sizes = self._places(chosen), self._sizes(chosen)
        rest = [k for k in range(len(self.groups)) if k not in chosen]
        at, ends = np.concatenate([there, self._places(rest)]), np.cumsum([0, *map(self.many, rest)])
        folds = [
            Beside(others.of(at, worth), sizes, fit)
            for (others, _), fit in zip(self._folds, now.fits, strict=True)
        ]
        out = {}
        for k, first, last in zip(rest, ends[:-1], ends[1:], strict=True):
            fits = [fold.weighed(first, last, self.groups[k]) for fold in folds]
            out[k] = float(self._left(self._places([*chosen, k]), fits).sum())
        return out

    def worth(self, chosen: Sequence[int]) -> float:
        """How many samples are worth one: from one on, as long as less is left of blocks not seen."""
        best, worth = self.tried(chosen, WORTHS[0]), WORTHS[0]
        for more in WORTHS[1:]:
            trial = self.tried(chosen, more, best.fits)
            if trial.unseen >= best.unseen:
                break
            best, worth = trial, more
        return float(worth)

    def _left(self, at: np.ndarray, fits: Sequence[Weighed]) -> Array:
        """(folds,) what is left by fits of columns at some places to other blocks."""
        judged = [own for _, own in self._folds]
        return np.array([own.left(at, fit.weights) for own, fit in zip(judged, fits, strict=True)])

    def _over(self, share: Array) -> Total:
        """Sums over the blocks, of each so large a share (CUTS,)."""
        return Total(
            np.tensordot(share, self.normal, 1),
            share @ self.side,
            float(share @ self.power),
            float(share @ self.count),
        )

    @cached_property
    def _known(self) -> dict[tuple[tuple[int, ...], float], Tried]:
        """By the sources in the order in which they were chosen, and what samples are worth."""
        return {}

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
        return np.cumsum([0, *map(self.many, range(len(self.groups)))])

    def many(self, k: int) -> int:
        """Weights of a source."""
        return sum(self.groups[k])

    def _sizes(self, chosen: Sequence[int]) -> list[int]:
        return [size for k in chosen for size in self.groups[k]]

    def _places(self, chosen: Sequence[int]) -> np.ndarray:
        """Where the weights of some sources are among those of all."""
        if not chosen:
            return np.empty(0, dtype=int)
        return np.concatenate([np.arange(self.ends[k], self.ends[k + 1]) for k in chosen])


def chosen_of(sums: Sums, found: Sequence[Source], worth: float) -> list[int]:
    """The sources that are needed, in the order of their need: one after the other the one with which least
    is left of blocks not seen, as long as that pays. What fades comes after all that stays, and has to pay
    more: whatever was passed once alone may look like either. So has what is over several motions, beside
    the best of what is over one each: it is told only where all of them have been together.
    """
    able = range(len(found))
    chosen, best = _chosen(sums, found, worth, able)
    single = [k for k in able if found[k].kind.axes == 1]
    if set(chosen) <= set(single):
        return chosen
    plain, least = _chosen(sums, found, worth, single)
    return chosen if best.unseen < (1.0 - SLIGHT) * least.unseen else plain


def _chosen(
    sums: Sums, found: Sequence[Source], worth: float, able: Sequence[int]
) -> tuple[list[int], Tried]:
    """Those that are needed of some sources, and what they leave."""
    chosen: list[int] = []
    best = sums.tried([], worth)
    for fades, pays in ((False, PAYS), (True, SLIGHT)):
        room = [k for k in able if found[k].kind.fades == fades]
        chosen, best = _more(sums, found, worth, (chosen, best), room, pays)
    return chosen, best


def _more(
    sums: Sums,
    found: Sequence[Source],
    worth: float,
    begun: tuple[list[int], Tried],
    able: Sequence[int],
    pays: float,
) -> tuple[list[int], Tried]:
    """With those beside ``begun`` that pay, of some."""
    chosen, best = begun
    while True:
        room = [k for k in able if k not in chosen and _has_room(found, chosen, found[k].kind)]
        if sum(sums.many(k) for k in chosen) > MANY:
            looks = sums.looked(chosen, worth, best)
            room = sorted(room, key=lambda k: looks[k])[:REFITTED]
        trials = {k: sums.beside(chosen, k, worth, best) for k in room}
        least, k = min(((trial.unseen, k) for k, trial in trials.items()), default=(np.inf, 0))
        if least > (1.0 - pays) * best.unseen:
            return chosen, best
        best = trials[k]
        chosen = [*chosen, k]


def _has_room(found: Sequence[Source], chosen: Sequence[int], kind: type[Bank]) -> bool:
    return sum(found[k].kind is kind for k in chosen) < kind.sources
