"""What people do instead: a sparse symbolic model of the discrepancy (SINDy, from PySINDy).

Brunton et al. 2016; for the discrepancy of a model: Kaheman et al. 2019. In the place of a derivative
stands the residual of the nominal arm; the state is the nominal joint angle, speed, load, direction and
time are controls.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pysindy

from test.concealed.nominal import Array
from test.concealed.seen import Seen, features_of
from test.concealed.sensing import PERIOD

SETTINGS: dict[str, Any] = {"degree": 1, "threshold": 0.3, "alpha": 1.0, "time": False}
EVERY = 3  # of the samples that the fit takes: neighbours say the same
UNIT = 1e-4  # rad, of the residual: the noise of a sensor


class Symbolic:
    """One sparse model of all joints; terms up to a degree of angles, speeds, loads, directions and time."""

    def __init__(self, seen: Seen, **settings: Any):
        how = {**SETTINGS, **settings}
        self.time = how["time"]
        self.scale = np.maximum(np.abs(self._raw(seen)).max(axis=0), 1e-9)
        x, u = self._split(seen)
        rows = seen.place[seen.late][::EVERY]
        left = (seen.shown - seen.nominal)[seen.late][::EVERY] / UNIT
        optimizer = pysindy.STLSQ(
            threshold=how["threshold"] * max(float(left.std()), 1.0), alpha=how["alpha"], max_iter=20
        )
        library = pysindy.PolynomialLibrary(degree=how["degree"])
        self.model = pysindy.SINDy(optimizer=optimizer, feature_library=library)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that all terms of a joint were dropped is an answer
            self.model.fit(x[rows], t=PERIOD, x_dot=left, u=u[rows])

    def _raw(self, seen: Seen) -> Array:
        f = features_of(seen)
        return np.column_stack([f.theta, f.speed, f.load, f.memory, *([f.t] if self.time else [])])

    def _split(self, seen: Seen) -> tuple[Array, Array]:
        all_ = np.clip(self._raw(seen) / self.scale, -1.0, 1.0)  # no further than was seen
        return all_[:, :5], all_[:, 5:]

    def residual(self, seen: Seen) -> Array:
        """(n, 5) rad to add to the nominal angle of another recording."""
        x, u = self._split(seen)
        out: Array = np.asarray(self.model.predict(x[seen.place], u=u[seen.place])) * UNIT
        return out
