"""Banks beside the named effects of a joint, where those leave much and the banks win on blocks not seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.memory import (
    CUTS,
    FOLDS,
    Source,
    drawn,
    redrawn_banks,
    sources,
    without_banks,
)
from trunk_ros.diagnosis.evidence.residual_dependence import rests
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.fit import Fit, costed_on, fit
from trunk_ros.diagnosis.search.score import STRONG
from trunk_ros.effects import effect

FORMS = 0.01  # of the misfit: what forms of the same physics may differ by
CLEAR = 0.05  # of what is left: what a bank must take off it on blocks not seen
SPARES = 0.01  # likewise: an effect with a name stays beside banks that it does more for
SURE = 2.0  # standard errors over the blocks
HALF = 0.5  # of the misfit: a model that leaves more of it is of something else than what is at work


def with_banks(state: Fit) -> Fit:
    """The hypothesis with banks on the joints that need them."""
    context = state.context
    if context.stage.name != "wire":
        return state
    left = rests(context, state.hypothesis)
    for column in [c for c, power in left.items() if power > STRONG]:
        misfit = float(np.mean(context.whitened(context.known, column) ** 2)) - 1.0
        if left[column] > FORMS * misfit:
            state = _banked(state, column, misfit)
    return state


def _banked(state: Fit, column: int, misfit: float) -> Fit:
    context, found = state.context, sources(state.context, column)
    if not found:
        return state
    lean = _lean(context, state.hypothesis, column, found)
    before = unseen(context, state.hypothesis, column)
    if not _wins(before, lean.unseen, misfit):
        return state
    return costed_on(state, lean.hypothesis, column)


def _wins(before: Array, after: Array, misfit: float) -> bool:
    """Whether the power that is left in blocks that nothing was fitted to is clearly less than before, and
    little of the misfit.
    """
    return clearly(before, after, CLEAR) and float(after.mean()) - 1.0 < HALF * misfit


def clearly(before: Array, after: Array, share: float) -> bool:
    """Whether powers of blocks (CUTS,) are less than before by a ``share``, and by more than their
    scatter.
    """
    gain = np.log(before / after)
    error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain))
    return bool(gain.mean() > max(share, SURE * error))


@dataclass(frozen=True)
class Judged:
    """An hypothesis, and what it leaves of blocks that it was not fitted to, (CUTS,) mean squares."""

    hypothesis: Hypothesis
    unseen: Array


def _lean(context: Context, hypothesis: Hypothesis, column: int, found: list[Source]) -> Judged:
    """The hypothesis with banks on a column, and without its own effects that the banks make superfluous."""
    best = _refitted(context, hypothesis, column, found)
    while True:
        own = [t.effect for t in without_banks(best.hypothesis, column).on(column)]
        trials = [
            _refitted(context, best.hypothesis.without(name, column), column, found)
            for name in own
            if not effect(name).everywhere and name not in context.known
        ]
        least = min(trials, key=lambda t: float(t.unseen.mean()), default=None)
        if least is None or least.unseen.mean() > (1.0 + SPARES) * best.unseen.mean():
            return best
        best = least


def _refitted(context: Context, hypothesis: Hypothesis, column: int, found: list[Source]) -> Judged:
    """Named values of a column fitted, and banks on what they leave."""
    bare = fit(context, without_banks(hypothesis, column), [column]).hypothesis
    out = drawn(context, bare, column, found)
    return Judged(out, unseen(context, out, column))


def unseen(context: Context, hypothesis: Hypothesis, column: int) -> Array:
    """(CUTS,) mean squares of blocks of time, by named values and banks that were fitted to the others."""
    out, block = np.zeros(CUTS), blocks(context, column)
    for fold in range(FOLDS):
        judged = np.arange(CUTS) % FOLDS == fold
        seen = context.only([~judged[number] for number in block])
        fitted = fit(seen, without_banks(hypothesis, column), [column]).hypothesis
        fitted = redrawn_banks(seen, fitted, column, hypothesis)
        out[judged] = by_blocks(context.whitened(fitted, column) ** 2)[judged]
    return out


def blocks(context: Context, column: int) -> list[np.ndarray]:
    """(n,) number of the block of time that each row of a span is in, by what counts on a column."""
    valid = [view.span.valid[:, column] for view in context.views]
    place = np.cumsum(np.concatenate(valid)) - 1
    number = np.clip(place * CUTS // max(int(place[-1]) + 1, 1), 0, CUTS - 1)
    return np.split(number, np.cumsum([len(v) for v in valid])[:-1])


def by_blocks(power: Array) -> Array:
    """(CUTS,) means of what counts (rows,) over the blocks."""
    number = np.arange(len(power)) * CUTS // max(len(power), 1)
    return np.asarray(np.bincount(number, power, CUTS) / np.maximum(np.bincount(number, minlength=CUTS), 1))
