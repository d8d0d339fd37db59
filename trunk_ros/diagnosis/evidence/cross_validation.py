"""Before and after on samples that the fit did not see."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.discrepancy.curves import redrawn
from trunk_ros.diagnosis.discrepancy.memory import redrawn_banks, without_banks
from trunk_ros.diagnosis.hypothesis import Explanation
from trunk_ros.diagnosis.search.greedy import Search
from trunk_ros.diagnosis.stage import Problem

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
    after: dict[int, list[Array]] = {c: [] for c in problem.columns}
    for fold in (0, 1):
        for c, errors in _unseen(search, explanation, fold).items():
            after[c] += _blocks(problem, errors, c, (fold,))
    problem.look_again(problem.known)
    before = {c: _blocks(problem, _errors(problem, problem.known, c), c, (0, 1)) for c in problem.columns}
    problem.look_again(explanation)
    return {c: Error(*_rms(before[c]), *_rms(after[c]), problem.noise[c].std) for c in problem.columns}


def _unseen(search: Search, explanation: Explanation, fold: int) -> dict[int, list[Array]]:
    """Errors by column and span of what was fitted to the samples outside a fold alone."""
    problem, views = search.problem, search.problem.views
    problem.views = [view.only(_fold(len(view.span.rows)) != fold) for view in views]
    fitted = _fitted_anew(search, explanation)
    errors = {c: _errors(problem, fitted, c) for c in problem.columns}
    problem.views = views
    problem.forget()
    return errors


def _fitted_anew(search: Search, explanation: Explanation) -> Explanation:
    """Values and curves as what counts now tells them; of curves only what they are drawn over is kept."""
    if not explanation:
        return explanation
    columns, bare = search.problem.columns, explanation
    for column in columns:
        bare = without_banks(bare, column)
    fitted = search.refit(bare).explanation if bare else bare
    for column in fitted.curved & set(columns):
        fitted = redrawn(search.problem, fitted, column)
    for column in columns:
        fitted = redrawn_banks(search.problem, fitted, column, explanation)
    return fitted


def _number(count: int) -> np.ndarray:
    """(count,): the block of time that each sample is in."""
    return np.asarray(np.arange(count) * BLOCKS // max(count, 1))


def _fold(count: int) -> np.ndarray:
    """(count,): 0 or 1 by blocks of time."""
    return np.asarray(_number(count) % 2)


def _errors(problem: Problem, explanation: Explanation, column: int) -> list[Array]:
    """Measured less predicted, (n,) by span, wherever anything was measured."""
    said = problem.predictions(explanation, column)
    return [view.span.target[:, column] - p for view, p in zip(problem.views, said, strict=True)]


def _blocks(problem: Problem, errors: list[Array], column: int, folds: tuple[int, ...]) -> list[Array]:
    """What counts of a column's errors, by blocks of time."""
    out = []
    for view, error in zip(problem.views, errors, strict=True):
        number, valid = _number(len(error)), view.span.valid[:, column]
        chosen = [(number == block) & valid for block in range(BLOCKS) if block % 2 in folds]
        out += [error[rows] for rows in chosen if rows.any()]
    return out


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
