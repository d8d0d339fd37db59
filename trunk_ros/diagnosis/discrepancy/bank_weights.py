"""How sources of a bank are chosen, on blocks of time that their weights have not seen, and how large weights
are: linear fits by marginal likelihood.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.effects.bank import Bank
from trunk_ros.guards import ROUNDED, TINY

ENOUGH = 100_000  # rows
CUTS = 40  # blocks of time, in FOLDS that are left out in turn
FOLDS = 5
WORTHS = 4.0 ** np.arange(6)  # samples that may be worth one
PAYS = 0.005  # of what is left of blocks not seen: what a further source must take off it
ROUNDS, SETTLED = 30, 0.1  # of the precisions' logarithms
PRECISIONS = (1e-3, 1e8)


@dataclass(frozen=True)
class Source:
    """One motion in a bank, and its design (rows, weights) on the whitened residual, thinned."""

    kind: type[Bank]
    word: str
    low: float
    high: float
    design: Array


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
        return float(self.by_fold(chosen, worth).sum()) / CUTS

    def by_fold(self, chosen: Sequence[int], worth: float) -> Array:
        """(folds,) sums of the mean squares that are left of blocks by weights from other blocks."""
        out, at = [], self._places(chosen)
        for others, judged in self._folds:
            left = judged.power
            if chosen:
                weights = self._likeliest(others, chosen, worth)
                bent = judged.normal[np.ix_(at, at)] @ weights
                left += float(weights @ bent - 2.0 * judged.side[at] @ weights)
            out.append(left)
        return np.array(out)

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
