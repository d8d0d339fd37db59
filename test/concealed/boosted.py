"""What people do instead: gradient boosted trees on the residual of the nominal arm (scikit-learn)."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.signal import lfilter
from sklearn.ensemble import HistGradientBoostingRegressor

from test.concealed.nominal import COUNT, Array
from test.concealed.seen import Features, Seen, features_of
from test.concealed.sensing import PERIOD

SETTINGS: dict[str, Any] = {"max_iter": 100, "learning_rate": 0.1, "max_leaf_nodes": 4,
                            "min_samples_leaf": 40, "l2_regularization": 0.0}  # fmt: skip
LAGS = (5, 20, 100, 300)  # samples of 10 ms
SLOW = (1.0, 5.0)  # s


def _lagged(x: Array, lag: int) -> Array:
    out: Array = x - np.concatenate([np.repeat(x[:1], lag, axis=0), x[:-lag]])
    return out


def _slow(x: Array, time: float) -> Array:
    keep = np.exp(-PERIOD / time)
    out: Array = x - x[0] - lfilter([1 - keep], [1.0, -keep], x - x[0])
    return out


def _columns(f: Features, j: int) -> Array:
    """All angles and speeds; of the joint itself also load, memory, lags and what is left of slow filters."""
    own = f.theta[:, j]
    more = [f.load[:, j], f.memory[:, j], f.t, np.gradient(f.speed[:, j], PERIOD)]
    more += [_lagged(own, lag) for lag in LAGS] + [_slow(own, time) for time in SLOW]
    return np.column_stack([f.theta, f.speed, *more])


class Boosted:
    """One model for each joint."""

    def __init__(self, seen: Seen, **settings: Any):
        f, left = features_of(seen), (seen.shown - seen.nominal)[seen.late]
        rows = seen.place[seen.late]
        how = {**SETTINGS, **settings, "early_stopping": False, "random_state": 0}
        self.models = [
            HistGradientBoostingRegressor(**how).fit(_columns(f, j)[rows], left[:, j]) for j in range(COUNT)
        ]

    def residual(self, seen: Seen) -> Array:
        """(n, 5) rad to add to the nominal angle of another recording."""
        f = features_of(seen)
        each = [model.predict(_columns(f, j)[seen.place]) for j, model in enumerate(self.models)]
        return np.column_stack(each)
