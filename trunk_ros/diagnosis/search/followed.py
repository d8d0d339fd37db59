"""Where the values of a hypothesis may go by small steps: what a linear look leaves to them."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Free, Hypothesis
from trunk_ros.diagnosis.search.residuals import Residuals


def directions(
    context: Context, hypothesis: Hypothesis, columns: list[int]
) -> tuple[dict[int, Array], dict[int, Array]]:
    """By column: an orthonormal basis (rows, values) of what its own values do, and (rows, shared) what those
    that joints share do besides.
    """
    residuals = Residuals(context, hypothesis, columns)
    free = residuals.free
    shared = [k for k, f in enumerate(free) if f.column is None and not _of_one(hypothesis, f)]
    own, besides = {}, {}
    for column, (moved, slopes) in zip(columns, residuals.slopes(hypothesis.free_values(free)), strict=True):
        alone = slopes[:, [i for i, k in enumerate(moved) if k not in shared]]
        size = np.linalg.norm(alone, axis=0)
        q = np.asarray(np.linalg.qr(alone[:, size > 0] / size[size > 0])[0])
        common = np.zeros((len(slopes), len(shared)))
        for i, k in enumerate(moved):
            if k in shared:
                common[:, shared.index(k)] = slopes[:, i]
        own[column], besides[column] = q, common - q @ (q.T @ common)
    return own, besides


def _of_one(hypothesis: Hypothesis, free: Free) -> bool:
    """Whether a value that joints may share is only of one."""
    return len(hypothesis[free.effect].own) == 1 and not free.parameter.carried
