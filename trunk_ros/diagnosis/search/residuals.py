"""The residuals of some joints as a function of what is free, and how they change with it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.surroundings import counted
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Free, Hypothesis, bounds, scales
from trunk_ros.effects import effect

STEP = 0.005  # of a parameter's usual size, for derivatives


class Residuals:
    """The residual vector of some columns as a function of the free values, and its derivative."""

    def __init__(self, context: Context, hypothesis: Hypothesis, columns: list[int]):
        self.context, self.hypothesis, self.columns = context, hypothesis, columns
        self.free = hypothesis.free(columns, context.columns)
        self.scale = scales(self.free, context.stage.loads)
        self.turn = _turn(context, hypothesis, self.free)
        self._moved = hypothesis.copy()
        self._at: tuple[bytes, list[Array]] | None = None

    def parts(self, x: Array) -> list[Array]:
        """Residuals by column."""
        if self._at is None or self._at[0] != x.tobytes():
            self._moved.set(self.free, x)
            self._at = x.tobytes(), self.context.whitened_each([(self._moved, c) for c in self.columns])
        return self._at[1]

    def __call__(self, x: Array) -> Array:
        """All residuals, joined."""
        return np.concatenate(self.parts(x))

    def jacobian(self, x: Array) -> Array:
        """(rows, free) by forward differences; a joint's own value touches only its own rows."""
        base = self.parts(x)
        ends = np.cumsum([0, *(len(part) for part in base)])
        out = np.zeros((ends[-1], len(x)))
        for i, (free, slopes) in enumerate(self.slopes(x)):
            out[ends[i] : ends[i + 1], free] = slopes
        return out

    def slopes(self, x: Array) -> Iterator[tuple[list[int], Array]]:
        """By column: the values that move its residual, and (rows, values) by how much. Of long recordings
        those of one column at a time fit into memory.
        """
        for some, slopes in self._along(x):
            yield (
                some,
                slopes if self.turn is None else slopes @ self.about(np.eye(len(x)))[np.ix_(some, some)],
            )

    def _along(self, x: Array) -> Iterator[tuple[list[int], Array]]:
        """The same with phases that stay what they are in the middle of the motion."""
        base, steps, moving = self.parts(x), self.steps(x), [self.moving(c) for c in self.columns]
        there = {k: self._stepped(k, x, steps[k]) for k in range(len(x))}
        many = max(self.context.together // max(max(map(len, moving), default=0), 1), 1)
        for first in range(0, len(moving), many):
            group = list(zip(self.columns, moving, base, strict=True))[first : first + many]
            seen = self.context.whitened_each([(there[k], c) for c, some, _ in group for k in some])[::-1]
            for _, some, part in group:
                out = np.empty((len(some), len(part)))
                for slope, k in zip(out, some, strict=True):
                    np.subtract(seen.pop(), part, out=slope)
                    slope /= steps[k]
                    if not np.isfinite(slope).all():
                        slope[:] = 0.0
                yield some, out.T

    def turned(self, moved: Array) -> Array:
        """By how much values move (free, ...) that ``moved`` so in the middle of the motion."""
        return moved if self.turn is None else np.asarray(self.turn @ moved)

    def about(self, moved: Array) -> Array:
        """The same the other way."""
        return moved if self.turn is None else np.asarray(2.0 * moved - self.turn @ moved)

    def _stepped(self, k: int, x: Array, step: float) -> Hypothesis:
        out = self._moved.moved(self.free[k], x[k] + step)
        if self.turn is not None:
            with_it = [i for i in np.flatnonzero(self.turn[:, k]) if i != k]
            out.set([self.free[i] for i in with_it], x[with_it] + self.turn[with_it, k] * step)
        return out

    def but_for(self, x: Array, spared: int) -> float:
        """Squared residuals without what so many of the worst columns have above the noise."""
        cost = [float(part @ part) for part in self.parts(x)]
        return sum(cost) - worst(self.context, dict(zip(self.columns, cost, strict=True)), spared)

    def steps(self, x: Array) -> Array:
        """(free,) by which each value is moved to see what it does, away from a bound that is near."""
        return STEP * self.scale * np.where(x + STEP * self.scale <= bounds(self.free)[1], 1.0, -1.0)

    def moving(self, column: int) -> list[int]:
        """The values that move what is predicted of a column."""
        return [k for k, f in enumerate(self.free) if f.parameter.carried or column in self._touched(f)]

    def _touched(self, f: Free) -> list[int]:
        """The columns that a value acts on."""
        return self.hypothesis[f.effect].columns if f.column is None else [f.column]

    def normal(self, x: Array) -> tuple[Array, Array]:
        """(free,) J^T r and (free, free) J^T J, column by column."""
        return self._normal(x, self.slopes(x))

    def normal_about(self, x: Array) -> tuple[Array, Array]:
        """The same of what turns in the middle of the motion."""
        return self._normal(x, self._along(x))

    def _normal(self, x: Array, each: Iterator[tuple[list[int], Array]]) -> tuple[Array, Array]:
        side, square = np.zeros(len(x)), np.zeros((len(x), len(x)))
        for (free, slopes), part in zip(each, self.parts(x), strict=True):
            side[free] += slopes.T @ part
            square[np.ix_(free, free)] += slopes.T @ slopes
        return side, square


def worst(context: Context, cost: dict[int, float], many: int) -> float:
    """What so many of the worst columns have above the noise."""
    over = sorted((max(left - context.least_noise(c), 0.0) for c, left in cost.items()), reverse=True)
    return sum(over[: max(many, 0)])


def _turn(context: Context, hypothesis: Hypothesis, free: list[Free]) -> Array | None:
    """(free, free) how values change where phases are counted in the middle of the motion and not at angle 0:
    far from there no period could change without its phase. None where there are none.
    """
    out, each = np.eye(len(free)), {(f.effect, f.parameter.name, f.column): k for k, f in enumerate(free)}
    for k, f in enumerate(free):
        goes, times = effect(f.effect).turning(hypothesis[f.effect].form).get(f.parameter.name, ("", 0.0))
        with_it = each.get((f.effect, goes, f.column), each.get((f.effect, goes, None)))
        if with_it is not None and f.column is not None:
            out[k, with_it] = -times * _middle(context, f.column)
    return out if np.any(out != np.eye(len(free))) else None


def _middle(context: Context, column: int) -> float:
    """Mean motor-side angle of a column where it counts [rad]."""
    spans = [view.span for view in context.views]
    seen = counted(context.views, [span.measured(span.gearbox[:, column]) for span in spans], column)
    return float(np.mean(seen)) if len(seen) else 0.0
