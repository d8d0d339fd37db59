"""What others would use, tuned on the last fifth of the training part alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from sklearn.ensemble import HistGradientBoostingRegressor

from test.real.features import Array, Features, Run
from test.real.gru import Gru

RIDGES = np.logspace(-2, 5, 15)
BOOSTS = (
    {"max_iter": 100, "max_leaf_nodes": 6},
    {"max_iter": 300, "max_leaf_nodes": 6},
    {"max_iter": 300, "max_leaf_nodes": 15},
)
UNITS = (24, 48)
MOST = 20_000  # rows that a model is fitted to
LAST = 0.2  # of the training part, on which settings are chosen

Predict = Callable[[Run], Array]
Peer = Callable[[Sequence[Run], list[int]], Predict]


def ridge(runs: Sequence[Run], own: list[int]) -> Predict:
    """Plays, linear."""
    return _tuned(runs, own, RIDGES, _ridge)


def boosting(runs: Sequence[Run], own: list[int]) -> Predict:
    """Plays into boosted trees."""
    return _tuned(runs, own, BOOSTS, _boost)


def gru(runs: Sequence[Run], own: list[int]) -> Predict:
    """A recurrent network over all that went before."""
    early, late = _split(runs)
    tried = [Gru(units).fit(early, late) for units in UNITS]
    best = min(tried, key=lambda model: model.error(late))
    return best.predict


def _ridge(x: Array, y: Array, weight: float) -> Callable[[Array], Array]:
    mean = y.mean()
    w = np.linalg.solve(x.T @ x + weight * np.eye(x.shape[1]), x.T @ (y - mean))
    return lambda other: np.asarray(other @ w + mean)


def _boost(x: Array, y: Array, how: dict[str, int]) -> Callable[[Array], Array]:
    model = HistGradientBoostingRegressor(**how, early_stopping=False, random_state=0).fit(x, y)
    return lambda other: np.asarray(model.predict(other))


def _tuned(runs: Sequence[Run], own: list[int], settings: Sequence, fitted: Callable) -> Predict:  # type: ignore[type-arg]
    """One model a joint, each with the setting that was best on the last fifth."""
    features = Features(runs[0], own)
    tables = [(features(run), run.angles) for run in runs]
    models = []
    for j in range(runs[0].angles.shape[1]):
        early, late = _rows(tables, j)
        errors = [float(np.mean((fitted(*early, s)(late[0]) - late[1]) ** 2)) for s in settings]
        both = (np.vstack([early[0], late[0]]), np.concatenate([early[1], late[1]]))
        models.append(fitted(*both, settings[int(np.argmin(errors))]))
    return lambda run: np.column_stack([model(features(run)) for model in models])


def _rows(tables: list[tuple[Array, Array]], j: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Rows with a reading, thinned to what a model can take: the first four fifths of each run, and the
    rest.
    """
    step = max(sum(len(x) for x, _ in tables) // MOST, 1)
    parts: list[list[tuple[Array, Array]]] = [[], []]
    for x, angles in tables:
        cut = int((1.0 - LAST) * len(x))
        for part, rows in zip(parts, (slice(0, cut, step), slice(cut, None, step)), strict=True):
            seen = np.isfinite(angles[rows, j])
            part.append((x[rows][seen], angles[rows, j][seen]))
    early, late = ((np.vstack([x for x, _ in p]), np.concatenate([y for _, y in p])) for p in parts)
    return early, late


def _split(runs: Sequence[Run]) -> tuple[list[Run], list[Run]]:
    cuts = [int((1.0 - LAST) * len(run.stamp)) for run in runs]
    early = [run.part(0, cut) for run, cut in zip(runs, cuts, strict=True)]
    return early, [run.part(cut, len(run.stamp)) for run, cut in zip(runs, cuts, strict=True)]


PEERS: dict[str, Peer] = {"plays + ridge": ridge, "plays + boosting": boosting, "GRU": gru}
