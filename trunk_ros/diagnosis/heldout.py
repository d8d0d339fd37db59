"""Before and after on samples that the fit did not see."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.explanation import Explanation
from trunk_ros.diagnosis.problem import Problem
from trunk_ros.diagnosis.search import Search

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


def held_out(search: Search, explanation: Explanation) -> dict[int, Error]:
    """Error of each column, each block of time judged by a fit to the other half of the blocks."""
    problem = search.problem
    views, version = problem.views, problem.version
    after: dict[int, list[Array]] = {c: [] for c in problem.columns}
    for fold in (0, 1):
        problem.views = [
            replace(v, span=replace(v.span, valid=v.span.valid & (_fold(v.span.rows) != fold)[:, None]))
            for v in views
        ]
        fitted = search.refit(explanation).explanation if explanation else explanation
        problem.views = views
        problem.forget()
        for c in problem.columns:
            after[c] += _blocks(problem, fitted, c, fold)
    problem.version = version
    problem.look_again(explanation)
    before = {
        c: _blocks(problem, problem.known, c, 0) + _blocks(problem, problem.known, c, 1)
        for c in problem.columns
    }
    return {c: Error(*_rms(before[c]), *_rms(after[c]), problem.noise[c].std) for c in problem.columns}


def _fold(rows: np.ndarray) -> np.ndarray:
    """0 or 1 by blocks of time, (n,)."""
    return np.asarray(np.arange(len(rows)) * BLOCKS // max(len(rows), 1) % 2)


def _blocks(problem: Problem, explanation: Explanation, column: int, fold: int) -> list[Array]:
    out = []
    for index, view in enumerate(problem.views):
        error = problem.residual(index, explanation, column)
        number = np.arange(len(error)) * BLOCKS // max(len(error), 1)
        for block in range(fold, BLOCKS, 2):
            chosen = (number == block) & view.span.valid[:, column]
            if chosen.any():
                out.append(error[chosen])
    return out


def _rms(blocks: list[Array]) -> tuple[float, float]:
    """Root mean square over all blocks, and its standard error from their scatter."""
    if not blocks:
        return float("nan"), float("nan")
    power = np.array([np.mean(b**2) for b in blocks])
    weight = np.array([len(b) for b in blocks], dtype=float)
    mean = float(np.average(power, weights=weight))
    spread = float(np.std(power) / np.sqrt(len(power)))
    return float(np.sqrt(mean)), spread / (2 * np.sqrt(mean)) if mean > 0 else 0.0
