"""Before and after on samples that the fit did not see."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, compress
from typing import NamedTuple

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.bank_weights import FOLDS
from trunk_ros.diagnosis.discrepancy.curves import redrawn
from trunk_ros.diagnosis.discrepancy.memory import redrawn_banks, without_banks
from trunk_ros.diagnosis.evidence.at_rest import honest
from trunk_ros.diagnosis.free_run import free_run
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.levels import SURE

BLOCKS = 10


class Block(NamedTuple):
    """What errors come to in a block of time: samples, their mean, and the mean of their squares."""

    many: int
    mean: float
    power: float


@dataclass(frozen=True)
class Error:
    """Root mean square of one signal's error, with its standard error over blocks of time, before and
    after.
    """

    before: float
    before_std: float
    after: float
    after_std: float
    noise_floor: float
    usual: float
    """The median over the blocks afterwards: a block beyond what the others show is off by more than a model
    that has seen it. Of several recordings, what varies in one that was not seen.
    """
    zero: float = 0.0
    """What a recording that was not seen is off by throughout, rms: an encoder is homed anew, a camera stands
    elsewhere. 0 of one recording alone.
    """
    sure: float = 0.0
    """What the error afterwards surely comes to, by its scatter over blocks, with noise that grows with speed
    in the measure of that at rest.
    """


def _between(state: Fit) -> dict[int, tuple[float, float]]:
    """Usual error and zero [rad] of each column's recordings, each judged by a fit to others."""
    context, many = state.context, len(state.context.views)
    left: dict[int, list[list[Block]]] = {c: [] for c in context.columns}
    for fold in range(min(many, FOLDS)):
        out = [k % FOLDS == fold for k in range(many)]
        others = context.only(
            [np.full(len(v.span.rows), not o) for v, o in zip(context.views, out, strict=True)]
        )
        fitted = _fitted_anew(others, state.hypothesis)
        others = free_run(others, fitted)
        for c, runs in left.items():
            runs += compress(_cuts(context, _errors(others, fitted, c), c), out)
    return {c: _usual_and_zero(runs) for c, runs in left.items()}


def held_out(state: Fit) -> dict[int, Error]:
    """Error of each column, each block of time judged by a fit to the other half of the blocks that runs as
    ``simulate`` runs a model.
    """
    context = state.context
    after: dict[int, list[Block]] = {c: [] for c in context.columns}
    even: dict[int, list[Block]] = {c: [] for c in context.columns}
    for fold in (0, 1):
        for c, errors in _unseen(state, fold):
            after[c] += chain.from_iterable(_cuts(context, errors, c, (fold,)))
            even[c] += chain.from_iterable(_cuts(context, context.even(errors, c), c, (fold,)))
    nominal = free_run(context.seen_with(context.known), context.known)
    every = {c: _cuts(context, _errors(nominal, context.known, c), c) for c in context.columns}
    before = {c: list(chain.from_iterable(blocks)) for c, blocks in every.items()}
    floors = honest(context, state.hypothesis).noise
    noise = {c: floors[c].std for c in context.columns}
    several = len(context.views) > 1
    new = _between(state) if several else {c: (_usual(after[c]), 0.0) for c in noise}
    return {c: Error(*_rms(before[c]), *_rms(after[c]), noise[c], *new[c], _least(even[c])) for c in noise}


def _unseen(state: Fit, fold: int) -> Iterator[tuple[int, list[Array]]]:
    """Each column, and its errors by span of what was fitted to the samples outside a fold alone."""
    context = state.context
    half = context.only([fold_of(len(view.span.rows)) != fold for view in context.views])
    fitted = _fitted_anew(half, state.hypothesis)
    half = free_run(half, fitted)
    for c in context.columns:
        yield c, _errors(half, fitted, c)


def _fitted_anew(context: Context, hypothesis: Hypothesis) -> Hypothesis:
    """Values and curves as what counts now tells them; of curves only what they are drawn over is kept."""
    if not hypothesis:
        return hypothesis
    bare = hypothesis
    for column in context.columns:
        bare = without_banks(bare, column)
    fitted = refit(context, bare).hypothesis
    for column in fitted.curved & set(context.columns):
        fitted = redrawn(context, fitted, column)
    for column in context.columns:
        fitted = redrawn_banks(context, fitted, column, hypothesis)
    return fitted


def number_of(count: int) -> np.ndarray:
    """(count,): the block of time that each sample is in."""
    return np.asarray(np.arange(count) * BLOCKS // max(count, 1))


def fold_of(count: int) -> np.ndarray:
    """(count,): 0 or 1 by blocks of time."""
    return np.asarray(number_of(count) % 2)


def _errors(context: Context, hypothesis: Hypothesis, column: int) -> list[Array]:
    """Measured less predicted, (n,) by span, wherever anything was measured."""
    said = context.predictions(hypothesis, column)
    return [view.span.target[:, column] - p for view, p in zip(context.views, said, strict=True)]


def _cuts(
    context: Context, errors: list[Array], column: int, folds: tuple[int, ...] = (0, 1)
) -> list[list[Block]]:
    """What counts of a column's errors, by recording and blocks of time."""
    parts = zip(context.views, errors, strict=True)
    return [_cut(error, view.span.valid[:, column], folds) for view, error in parts]


def _cut(error: Array, valid: np.ndarray, folds: tuple[int, ...]) -> list[Block]:
    """What counts of errors (n,), by blocks of time."""
    number = number_of(len(error))
    chosen = (error[(number == block) & valid] for block in range(BLOCKS) if block % 2 in folds)
    return [Block(len(e), float(e.mean()), float(np.mean(e**2))) for e in chosen if len(e)]


def _usual_and_zero(runs: list[list[Block]]) -> tuple[float, float]:
    """What errors by recording and block vary by usually, and what they have throughout, beyond what means
    over blocks that differ have by chance.
    """
    means = [np.array([block.mean for block in blocks]) for blocks in runs]
    power = [m.mean() ** 2 - m.var(ddof=1) / len(m) for m in means if len(m) > 1]
    rest = [_beside(block, m.mean()) for blocks, m in zip(runs, means, strict=True) for block in blocks]
    return _usual(rest), float(np.sqrt(max(np.mean(power or [0.0]), 0.0)))


def _beside(block: Block, zero: float) -> Block:
    """The same beside a constant."""
    mean = block.mean - zero
    return Block(block.many, mean, max(block.power - block.mean**2, 0.0) + mean**2)


def _usual(blocks: list[Block]) -> float:
    return float(np.sqrt(np.median([b.power for b in blocks]))) if blocks else float("nan")


def _least(blocks: list[Block]) -> float:
    """What errors surely come to, rms."""
    rms, std = _rms(blocks)
    return max(rms - SURE * std, 0.0) if blocks else 0.0


def _rms(blocks: list[Block]) -> tuple[float, float]:
    """Root mean square over all blocks, and its standard error from their scatter."""
    if not blocks:
        return float("nan"), float("nan")
    power = np.array([b.power for b in blocks])
    weight = np.array([b.many for b in blocks]) / sum(b.many for b in blocks)
    mean = float(weight @ power)
    if len(blocks) < 2 or mean == 0.0:
        return float(np.sqrt(mean)), 0.0
    spread = float(np.sqrt(weight**2 @ (power - mean) ** 2 * len(power) / (len(power) - 1)))
    return float(np.sqrt(mean)), spread / (2.0 * float(np.sqrt(mean)))
