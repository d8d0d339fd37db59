"""What remains after all findings: how much, and what it still depends on."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.align import SLOW
from trunk_ros.diagnosis.explanation import Explanation
from trunk_ros.diagnosis.problem import Problem
from trunk_ros.diagnosis.spectrum import spectrum
from trunk_ros.diagnosis.unnamed import variables
from trunk_ros.effects.curve import abscissa, words_of

CELLS = 20
COHERENT = 0.5  # of a residual's power above the noise that it has to share with the sample before
TELLS = 0.05  # share of the rest's power that a variable must account for


def rests(problem: Problem, explanation: Explanation) -> dict[int, float]:
    """Columns whose residual is above the noise: power over the noise's, less one."""
    power = {c: float(np.mean(problem.whitened(explanation, c) ** 2)) - 1.0 for c in problem.columns}
    return {c: p for c, p in power.items() if p > problem.rest(c) and _coherent(problem, explanation, c)}


def _coherent(problem: Problem, explanation: Explanation, column: int) -> bool:
    """Whether a residual goes on from sample to sample, which outliers do not."""
    if problem.step >= SLOW:
        return True
    noise, products = problem.noise[column], []
    for i, view in enumerate(problem.views):
        rest, follows = problem.residual(i, explanation, column), view.follows[:, column]
        products.append((rest[1:] * rest[:-1])[follows[1:]])
    own = noise.correlation * (noise.std**2 - noise.white**2)
    excess = float(np.mean(np.concatenate(products))) - own
    return excess > COHERENT * problem.rest(column) * noise.std**2


def depends_on(problem: Problem, explanation: Explanation, column: int) -> list[str]:
    """Words for what the residual of a column still varies with, the strongest first."""
    scores: dict[str, float] = {}
    residual = np.concatenate(
        [
            problem.residual(i, explanation, column)[v.span.valid[:, column]]
            for i, v in enumerate(problem.views)
        ]
    )
    if len(residual) < 10 * CELLS or not np.any(residual):
        return []
    for name in ("direction", *variables(problem, column)):
        parts = []
        for i, view in enumerate(problem.views):
            now = problem.now(i, column, 0.0)
            values = np.sign(now.speed[:, 0]) if name == "direction" else abscissa(name, now, 0)
            parts.append(values[view.span.rows][view.span.valid[:, column]])
        scores[name] = accounted(np.concatenate(parts), residual)
    _, share = spectrum(problem.views[0].span.stamp, problem.residual(0, explanation, column))
    if share > 0.2:
        scores.setdefault("time", 0.0)
        scores["time"] = max(scores["time"], share)
    told = [name for name in sorted(scores, key=lambda n: -scores[n]) if scores[name] > TELLS][:3]
    return list(dict.fromkeys(word for name in told for word in words_of(name)))


def accounted(x: Array, residual: Array) -> float:
    """Share of a residual's power in its means over cells of ``x``, corrected for chance."""
    edges = np.quantile(x, np.linspace(0, 1, CELLS + 1)[1:-1])
    cell = np.searchsorted(edges, x)
    counts = np.bincount(cell, minlength=CELLS)
    sums = np.bincount(cell, weights=residual, minlength=CELLS)
    between = float(np.sum(sums[counts > 0] ** 2 / counts[counts > 0]) - residual.sum() ** 2 / len(residual))
    total = float(np.sum((residual - residual.mean()) ** 2))
    return between / total if total > 0 else 0.0
