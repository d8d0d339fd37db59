"""What people do instead: an echo state network on the residual (Jaeger 2001): a fixed random recurrent net
whose readout alone is fitted, by ridge regression.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from test.concealed.nominal import Array
from test.concealed.seen import Seen, features_of

SETTINGS: dict[str, Any] = {"size": 300, "radius": 0.5, "slowest": 1.0, "ridge": 0.1, "inputs": 0.03}
LINKS = 10  # per neuron


@njit(cache=True)
def _run(drive: Array, links: Array, source: Array, leak: Array) -> Array:
    """States (m, size) of a leaky tanh reservoir; links, source (size, LINKS): weights and where from."""
    states = np.zeros(drive.shape)
    x = np.zeros(drive.shape[1])
    for k in range(drive.shape[0]):
        old = x.copy()
        for i in range(x.size):
            total = drive[k, i]
            for n in range(links.shape[1]):
                total += links[i, n] * old[int(source[i, n])]
            x[i] = (1 - leak[i]) * old[i] + leak[i] * np.tanh(total)
        states[k] = x
    return states


def _radius(links: Array, source: Array) -> float:
    """Largest eigenvalue's size, of the sparse matrix."""
    whole = np.zeros((len(links), len(links)))
    for i, row in enumerate(source.astype(int)):
        np.add.at(whole[i], row, links[i])
    return float(np.abs(np.linalg.eigvals(whole)).max())


class Echo:
    """One reservoir for the whole arm."""

    def __init__(self, seen: Seen, **settings: Any):
        how = {**SETTINGS, **settings}
        rng, size = np.random.default_rng(0), how["size"]
        self.scale = np.maximum(self._raw(seen).std(axis=0), 1e-9)
        self.into = how["inputs"] * rng.normal(size=(self.scale.size + 1, size))
        links, self.source = (
            rng.normal(size=(size, LINKS)),
            rng.integers(0, size, (size, LINKS)).astype(np.float64),
        )
        self.links = links * how["radius"] / _radius(links, self.source)
        self.leak = np.exp(rng.uniform(np.log(how["slowest"]), 0.0, size))
        rows, left = seen.place[seen.late], (seen.shown - seen.nominal)[seen.late]
        states = self._states(seen)[rows]
        self.middle, self.spread = states.mean(axis=0), np.maximum(states.std(axis=0), 1e-9)
        z = (states - self.middle) / self.spread
        self.zero = left.mean(axis=0)
        weight = how["ridge"] * len(z) * np.eye(z.shape[1])
        self.out = np.linalg.solve(z.T @ z + weight, z.T @ (left - self.zero))

    def _raw(self, seen: Seen) -> Array:
        f = features_of(seen)
        return np.column_stack([f.theta, f.speed, f.memory])

    def _states(self, seen: Seen) -> Array:
        raw = self._raw(seen) / self.scale
        states = _run(
            np.column_stack([raw, np.ones(len(raw))]) @ self.into, self.links, self.source, self.leak
        )
        t = np.arange(len(raw)) / len(raw)
        return np.column_stack([raw, t, t**2, states])

    def residual(self, seen: Seen) -> Array:
        """(n, 5) rad to add to the nominal angle of another recording."""
        z = (self._states(seen)[seen.place] - self.middle) / self.spread
        out: Array = z @ self.out + self.zero
        return out
