"""A gated recurrent network (Cho et al. 2014, EMNLP) in numpy: whole sequences, Adam, early stopping."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from test.real.features import Array, Run

LENGTH, BATCH = 120, 16  # samples of a stretch, stretches a step
STEPS, EVERY, PATIENCE = 1500, 100, 4
RATE, KEEP = 5e-3, (0.9, 0.999)
LARGEST = 1.0  # norm of a gradient
MOST = 4000  # samples of a run that are looked at: faster recordings are thinned


class Gru:
    """One layer and a linear way out; commands and loads in, joint angles out."""

    def __init__(self, units: int, seed: int = 0):
        self.units, self.rng = units, np.random.default_rng(seed)

    def fit(self, runs: Sequence[Run], judged: Sequence[Run]) -> Gru:
        """Fit to ``runs``, stopping where ``judged`` get no better."""
        inputs = np.vstack([_inputs(run) for run in runs])
        angles = np.vstack([run.angles for run in runs])
        self.scale = inputs.mean(axis=0), np.maximum(inputs.std(axis=0), 1e-9)
        self.shown = np.nanmean(angles, axis=0), np.maximum(np.nanstd(angles, axis=0), 1e-9)
        self.weights = self._begin(inputs.shape[1], angles.shape[1])
        moments = [(np.zeros_like(w), np.zeros_like(w)) for w in self.weights]
        tables = [self._table(run) for run in runs]
        best, kept, worse = np.inf, self.weights, 0
        for step in range(1, STEPS + 1):
            self._step(self._gradient(*self._stretches(tables)), moments, step)
            if step % EVERY == 0:
                error = self.error(judged)
                best, kept, worse = (
                    (error, [w.copy() for w in self.weights], 0) if error < best else (best, kept, worse + 1)
                )
                if worse >= PATIENCE:
                    break
        self.weights = kept
        return self

    def predict(self, run: Run) -> Array:
        """(n, joints)."""
        x, _ = self._table(run)
        hidden, _ = self._forward(x[:, None])
        out = hidden[1:, 0] @ self.weights[3] + self.weights[4]
        at = np.linspace(0.0, 1.0, len(out))
        wanted = np.linspace(0.0, 1.0, len(run.stamp))
        full = np.column_stack([np.interp(wanted, at, column) for column in out.T])
        return np.asarray(full * self.shown[1] + self.shown[0])

    def error(self, runs: Sequence[Run]) -> float:
        """Mean square in the spreads of the angles."""
        off = np.vstack([(self.predict(run) - run.angles) / self.shown[1] for run in runs])
        return float(np.nanmean(off**2))

    def _begin(self, inputs: int, outputs: int) -> list[Array]:
        h = self.units

        def drawn(rows: int, columns: int) -> Array:
            return self.rng.normal(0.0, 1.0 / np.sqrt(rows), (rows, columns))

        return [drawn(inputs, 3 * h), drawn(h, 3 * h), np.zeros(3 * h), drawn(h, outputs), np.zeros(outputs)]

    def _table(self, run: Run) -> tuple[Array, Array]:
        step = max(len(run.stamp) // MOST, 1)
        x = (_inputs(run) - self.scale[0]) / self.scale[1]
        return x[::step], ((run.angles - self.shown[0]) / self.shown[1])[::step]

    def _stretches(self, tables: list[tuple[Array, Array]]) -> tuple[Array, Array]:
        """(LENGTH, BATCH, columns) of inputs and angles."""
        long = [t for t in tables if len(t[0]) > LENGTH] or tables
        length = min(LENGTH, *(len(t[0]) for t in long))
        picked = [long[k] for k in self.rng.integers(len(long), size=BATCH)]
        starts = [int(self.rng.integers(len(x) - length + 1)) for x, _ in picked]
        parts = [(x[s : s + length], y[s : s + length]) for (x, y), s in zip(picked, starts, strict=True)]
        return np.stack([x for x, _ in parts], axis=1), np.stack([y for _, y in parts], axis=1)

    def _forward(self, x: Array) -> tuple[Array, list[tuple[Array, Array, Array, Array]]]:
        """Hidden states (n + 1, batch, units), and what the way back needs."""
        into, over, bias, _, _ = self.weights
        h, kept = self.units, []
        hidden = np.zeros((len(x) + 1, x.shape[1], h))
        fed = x @ into + bias
        for t in range(len(x)):
            pulled = hidden[t] @ over
            gates = 1.0 / (1.0 + np.exp(-(fed[t, :, : 2 * h] + pulled[:, : 2 * h])))
            reset, update = gates[:, :h], gates[:, h:]
            new = np.tanh(fed[t, :, 2 * h :] + reset * pulled[:, 2 * h :])
            hidden[t + 1] = update * hidden[t] + (1.0 - update) * new
            kept.append((reset, update, new, pulled[:, 2 * h :]))
        return hidden, kept

    def _gradient(self, x: Array, y: Array) -> list[Array]:
        """Of the mean square error, the first third of each stretch being for the memory to settle."""
        into, over, _, out, shift = self.weights
        hidden, kept = self._forward(x)
        off = np.where(np.isfinite(y), hidden[1:] @ out + shift - np.nan_to_num(y), 0.0)
        off[: len(off) // 3] = 0.0
        off *= 2.0 / off.size
        found = [np.zeros_like(w) for w in self.weights]
        found[3] = np.einsum("tbh,tbo->ho", hidden[1:], off)
        found[4] = off.sum(axis=(0, 1))
        back = np.zeros_like(hidden[0])
        for t in range(len(x) - 1, -1, -1):
            back = back + off[t] @ out.T
            reset, update, new, pulled = kept[t]
            to_new = back * (1.0 - update) * (1.0 - new**2)
            to_update = back * (hidden[t] - new) * update * (1.0 - update)
            to_reset = to_new * pulled * reset * (1.0 - reset)
            fed = np.hstack([to_reset, to_update, to_new])
            kept_back = np.hstack([to_reset, to_update, to_new * reset])
            found[0] += x[t].T @ fed
            found[1] += hidden[t].T @ kept_back
            found[2] += fed.sum(axis=0)
            back = back * update + kept_back @ over.T
        del into
        return found

    def _step(self, gradient: list[Array], moments: list[tuple[Array, Array]], step: int) -> None:
        """Adam (Kingma & Ba 2015)."""
        size = np.sqrt(sum(float(np.sum(g**2)) for g in gradient))
        for k, g in enumerate(gradient):
            g = g * min(1.0, LARGEST / max(size, 1e-12))
            first, second = (
                keep * m + (1 - keep) * g**p for keep, m, p in zip(KEEP, moments[k], (1, 2), strict=True)
            )
            moments[k] = (first, second)
            slope = first / (1 - KEEP[0] ** step) / (np.sqrt(second / (1 - KEEP[1] ** step)) + 1e-8)
            self.weights[k] = self.weights[k] - RATE * slope


def _inputs(run: Run) -> Array:
    return np.column_stack([run.commands, run.loads])
