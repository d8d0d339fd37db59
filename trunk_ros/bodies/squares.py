"""Weighted least squares over blocks of time, and what blocks that were left out say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array

RIDGE = 1e-12  # of a column's own square: two columns that are the same get a huge deviation, not an error
ROUNDS = 3  # of weights by each joint's own residual


@dataclass(frozen=True)
class Squares:
    """Columns (n, joints, unknowns) for torque (n, joints), as sums over blocks and joints."""

    gram: Array
    """(blocks, joints, unknowns, unknowns)"""
    moment: Array
    """(blocks, joints, unknowns)"""
    power: Array
    """(blocks, joints) N^2 m^2"""
    count: Array
    """(blocks, joints) rows."""

    @staticmethod
    def of(columns: Array, torque: Array, known: np.ndarray, block: np.ndarray) -> Squares:
        """Sums of the ``known`` rows (n, joints); ``block`` (n,) says which block a row is in."""
        x, y = columns * known[..., None], torque * known
        parts = [block == b for b in np.unique(block) if known[block == b].any()]
        return Squares(
            np.array([np.einsum("njp,njq->jpq", x[part], x[part]) for part in parts]),
            np.array([np.einsum("njp,nj->jp", x[part], y[part]) for part in parts]),
            np.array([(y[part] ** 2).sum(axis=0) for part in parts]),
            np.array([known[part].sum(axis=0) for part in parts]),
        )

    def weights(self, active: np.ndarray) -> Array:
        """(joints,) of each joint's rows: one over the variance of its own residual."""
        weight = 1.0 / np.maximum(self.power.sum(axis=0) / np.maximum(self.count.sum(axis=0), 1), 1e-300)
        for _ in range(ROUNDS):
            left = self.errors(self.solve(active, weight)).sum(axis=0)
            free = np.maximum(self.count.sum(axis=0) - active.sum() / len(weight), 1)
            weight = 1.0 / np.maximum(left / free, 1e-300)
        return np.asarray(weight)

    def solve(self, active: np.ndarray, weight: Array, rows: np.ndarray | None = None) -> Array:
        """(unknowns,) values of the ``active`` ones, 0 of the others; ``rows``: of these blocks alone."""
        gram, moment = self._sums(active, weight, rows)
        out = np.zeros(len(active))
        if active.any():
            out[active] = np.linalg.solve(gram, moment)
        return out

    def deviations(self, active: np.ndarray, weight: Array) -> tuple[Array, Array]:
        """Standard deviations (unknowns,) and the values with each block left out (blocks, unknowns).

        Deviations are those of the jackknife over blocks, within which residuals may be as correlated as they
        like (Efron & Stein 1981), and no smaller than those of white noise.
        """
        blocks = len(self.count)
        out = np.full(len(active), np.inf)
        one_less = np.array([self.solve(active, weight, np.arange(blocks) != b) for b in range(blocks)])
        spread = one_less[:, active] - one_less[:, active].mean(axis=0)
        jack = np.sqrt((blocks - 1) / blocks * (spread**2).sum(axis=0))
        white = np.sqrt(np.diag(np.linalg.inv(self._sums(active, weight, None)[0])))
        out[active] = np.maximum(jack, white)
        return out, one_less

    def errors(self, values: Array, rows: np.ndarray | None = None) -> Array:
        """(blocks, joints) sums of squared residuals at ``values`` (unknowns,)."""
        keep = slice(None) if rows is None else rows
        gram, moment = self.gram[keep], self.moment[keep]
        squares = np.einsum("p,bjpq,q->bj", values, gram, values) - 2.0 * moment @ values + self.power[keep]
        return np.asarray(np.maximum(squares, 0.0))

    def unseen(self, active: np.ndarray, weight: Array) -> Array:
        """(joints,) sums of squared residuals on blocks that the fit did not see: every other one each."""
        odd = np.arange(len(self.count)) % 2 == 1
        return np.asarray(
            sum(self.errors(self.solve(active, weight, ~half), half).sum(axis=0) for half in (odd, ~odd))
        )

    def _sums(self, active: np.ndarray, weight: Array, rows: np.ndarray | None) -> tuple[Array, Array]:
        keep = slice(None) if rows is None else rows
        gram = np.einsum("j,bjpq->pq", weight, self.gram[keep])[np.ix_(active, active)]
        moment = np.einsum("j,bjp->p", weight, self.moment[keep])[active]
        diagonal = np.arange(len(gram))
        gram[diagonal, diagonal] += np.maximum(RIDGE * gram[diagonal, diagonal], 1e-300)
        return gram, moment
