"""Before and after on samples that the fit did not see."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.curves import redrawn
from trunk_ros.diagnosis.discrepancy.memory import redrawn_banks, without_banks
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.fit import Fit, refit

BLOCKS = 10


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
    that has seen it.
    """


def held_out(state: Fit) -> dict[int, Error]:
    """Error of each column, each block of time judged by a fit to the other half of the blocks."""
    context = state.context
    after: dict[int, list[Array]] = {c: [] for c in context.columns}
    for fold in (0, 1):
        for c, errors in _unseen(state, fold).items():
            after[c] += _blocks(context, errors, c, (fold,))
    nominal = context.seen_with(context.known)
    before = {c: _blocks(context, _errors(nominal, context.known, c), c, (0, 1)) for c in context.columns}
    return {
        c: Error(*_rms(before[c]), *_rms(after[c]), context.noise[c].std, _usual(after[c]))
        for c in context.columns
    }


def _unseen(state: Fit, fold: int) -> dict[int, list[Array]]:
    """Errors by column and span of what was fitted to the samples outside a fold alone."""
    context = state.context
    half = context.only([fold_of(len(view.span.rows)) != fold for view in context.views])
    fitted = _fitted_anew(half, state.hypothesis)
    return {c: _errors(half, fitted, c) for c in context.columns}


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


def _blocks(context: Context, errors: list[Array], column: int, folds: tuple[int, ...]) -> list[Array]:
    """What counts of a column's errors, by blocks of time."""
    out = []
    for view, error in zip(context.views, errors, strict=True):
        number, valid = number_of(len(error)), view.span.valid[:, column]
        chosen = [(number == block) & valid for block in range(BLOCKS) if block % 2 in folds]
        out += [error[rows] for rows in chosen if rows.any()]
    return out


def _usual(blocks: list[Array]) -> float:
    return float(np.sqrt(np.median([np.mean(b**2) for b in blocks]))) if blocks else float("nan")


def _rms(blocks: list[Array]) -> tuple[float, float]:
    """Root mean square over all blocks, and its standard error from their scatter."""
    if not blocks:
        return float("nan"), float("nan")
    power = np.array([np.mean(b**2) for b in blocks])
    weight = np.array([len(b) for b in blocks]) / sum(len(b) for b in blocks)
    mean = float(weight @ power)
    if len(blocks) < 2 or mean == 0.0:
        return float(np.sqrt(mean)), 0.0
    spread = float(np.sqrt(weight**2 @ (power - mean) ** 2 * len(power) / (len(power) - 1)))
    return float(np.sqrt(mean)), spread / (2.0 * float(np.sqrt(mean)))
