"""What a hypothesis predicts of what it was not fitted to: blocks of time, or whole recordings."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.surroundings import counted
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.curves import redrawn
from trunk_ros.diagnosis.evidence.cross_validation import BLOCKS, number_of
from trunk_ros.diagnosis.free_run import free_run
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.fit import Fit, fit, groups
from trunk_ros.levels import SEVERAL


def unseen(context: Context, hypothesis: Hypothesis, columns: Collection[int], whole: bool = False) -> Array:
    """(2, BLOCKS) squared residuals on some columns of blocks of time, each judged by a fit to the others, or
    to other ``whole`` recordings, that runs as ``simulate`` runs a model: as unit noise, and as they are, in
    units of the noise.
    """
    total = np.zeros((2, BLOCKS))
    number = [number_of(len(view.span.rows)) for view in context.views]
    side = [np.full(len(n), k % 2) if whole else n % 2 for k, n in enumerate(number)]
    for fold in (0, 1):
        fitted = _fitted(context.only([s != fold for s in side]), hypothesis, columns)
        judged = free_run(context.only([s == fold for s in side]), fitted)
        for c in columns:
            block = counted(judged.views, number, c)
            rests = [judged.residual(index, fitted, c) for index in range(len(judged.views))]
            plain = counted(judged.views, judged.even(rests, c), c)
            total[0] += np.bincount(block, judged.whiten(rests, c) ** 2, BLOCKS)
            total[1] += np.bincount(block, (plain / context.noise[c].std) ** 2, BLOCKS)
    return total


def unrepeated(part: Fit, rivals: Mapping[str, Hypothesis]) -> Iterator[str]:
    """The rivals that predict recordings which they were not fitted to worse than what they stand for does,
    each recording in turn by the others; none where there is but one.
    """
    context = part.context
    if not rivals or len(context.views) < SEVERAL:
        return
    before = _unseen_recordings(context, part.hypothesis)
    for name, rival in rivals.items():
        after = _unseen_recordings(context, rival)
        told = (before > 0.0) & (after > 0.0)
        if np.sum(np.log(after[told] / before[told])) > 0.0:
            yield name


def _unseen_recordings(context: Context, hypothesis: Hypothesis) -> Array:
    """(recordings,) squared unit-noise residuals of each, by a fit to the others."""
    left = []
    for index in range(len(context.views)):
        own = [np.full(len(view.span.rows), k == index) for k, view in enumerate(context.views)]
        fitted = _fitted(context.only([~rows for rows in own]), hypothesis, context.columns)
        judged = context.only(own)
        left.append(sum(float(np.sum(judged.whitened(fitted, c) ** 2)) for c in context.columns))
    return np.array(left)


def _fitted(half: Context, hypothesis: Hypothesis, columns: Collection[int]) -> Hypothesis:
    for group in groups(half, hypothesis):
        if set(group) & set(columns):
            hypothesis = fit(half, hypothesis, group).hypothesis
    for column in hypothesis.curved & set(columns):
        hypothesis = redrawn(half, hypothesis, column)
    return hypothesis
