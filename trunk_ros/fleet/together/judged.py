"""Each series as the shape that it has, with the chance that nothing is behind it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy import stats

from trunk_ros.compiled import Array
from trunk_ros.fleet.together.moderated import Prior, prior
from trunk_ros.fleet.together.series import Series, spread_of_steps
from trunk_ros.fleet.together.shapes import Shape, bend, constant, jumps, line, price, without

LEAST = 5  # recordings of an arm without which nothing is said of its life
KINDS = 3  # shapes that were chosen from: growing over time, over travel, jumping
COVERED = 0.95

Chance = Callable[[float, float, int], float]


@dataclass(frozen=True)
class Jump:
    """A change between two recordings: the first after it, its size, and its chance without a cause."""

    place: int
    step: float
    std: float
    chance: float


@dataclass(frozen=True)
class Judged:
    """A series with its shape. ``variance`` and ``dof``: of its weighted residuals, moderated.

    ``over``: "day" or "m", what it grows with. ``chance``: of a shape like that where nothing changes.
    """

    series: Series
    shape: Shape
    over: str
    variance: float
    dof: float
    chance: float
    jumps: tuple[Jump, ...] = ()

    @property
    def level(self) -> tuple[float, float]:
        """The value at the last recording and its standard deviation."""
        row = self.shape.columns[-1]
        power = float(row @ self.shape.covariance @ row) * self.variance
        return float(row @ self.shape.coefficients), float(np.sqrt(power))

    @property
    def constant(self) -> Judged:
        """The same series as one that does not change."""
        return replace(self, shape=constant(self.series.value, self.series.sigma), over="", jumps=())


def judged(all_series: list[Series]) -> list[Judged]:
    """All series that are long enough, each with its likeliest shape and that shape's chance."""
    long = [clean for series in all_series if len((clean := series.kept()).value) >= LEAST]
    found = [_likeliest(series) for series in long]
    priors = _priors(long, found)
    return [
        _with_chance(series, shape, over, priors[series.key.effect, series.key.parameter])
        for series, (shape, over) in zip(long, found, strict=True)
    ]


def _likeliest(series: Series) -> tuple[Shape, str]:
    """The shape with the least rest and price, and what it is over."""
    value, sigma = series.value, series.sigma
    scale = spread_of_steps(value / sigma) ** 2
    flat = constant(value, sigma)
    scale = min(scale, flat.rest / max(flat.dof, 1)) or 1.0
    shapes = [(flat, "")]
    for over, x in _axes(series).items():
        shapes += [(shape, over) for shape in (line(x, value, sigma), bend(x, value, sigma)) if shape]
    jumped = jumps(value, sigma, scale)
    shapes += [(jumped, "")] if jumped else []

    def score(entry: tuple[Shape, str]) -> float:
        shape = entry[0]
        return shape.rest / scale + price(len(value), shape.columns.shape[1] + len(shape.places))

    return min(shapes, key=score)


def _axes(series: Series) -> dict[str, Array]:
    """What a series may grow over: days, and metres where they are known."""
    axes = {"day": series.days}
    if np.isfinite(series.travel).all() and np.ptp(series.travel) > 0.0:
        axes["m"] = series.travel
    return {over: x for over, x in axes.items() if np.ptp(x) > 0.0}


def _priors(series: list[Series], found: list[tuple[Shape, str]]) -> dict[tuple[str, str], Prior]:
    """What is known of the scatter of each effect's parameter, from all arms and joints."""
    groups: dict[tuple[str, str], list[Shape]] = defaultdict(list)
    for one, (shape, _) in zip(series, found, strict=True):
        groups[one.key.effect, one.key.parameter].append(shape)
    return {
        key: prior(
            np.array([shape.rest / max(shape.dof, 1) for shape in shapes]),
            np.array([float(shape.dof) for shape in shapes]),
        )
        for key, shapes in groups.items()
    }


def _with_chance(series: Series, shape: Shape, over: str, known: Prior) -> Judged:
    variance, dof = known.with_own(shape.rest / max(shape.dof, 1), float(max(shape.dof, 1)))

    def chance(size: float, power: float, tried: int) -> float:
        t = abs(size) / max(float(np.sqrt(power * variance)), 1e-300)
        return min(1.0, 2.0 * float(stats.t.sf(t, dof)) * tried * KINDS)

    steps = [_surely(series, shape, k, chance) for k in range(1, shape.columns.shape[1])]
    found = tuple(_jumps(shape, variance, steps)) if shape.kind == "jumps" else ()
    return Judged(series, shape, over, variance, dof, min(steps, default=1.0), found)


def _surely(series: Series, shape: Shape, k: int, chance: Chance) -> float:
    """The chance of a coefficient without the recording that it needs most: what hangs on one recording is
    no change.
    """
    rows = range(len(series.value))
    fits = [shape, *(without(shape, row, series.value, series.sigma) for row in rows)]
    return max(chance(float(f.coefficients[k]), float(f.covariance[k, k]), f.tried) for f in fits)


def _jumps(shape: Shape, variance: float, chances: list[float]) -> Iterator[Jump]:
    for k, (place, chance) in enumerate(zip(shape.places, chances, strict=True), start=1):
        step, power = float(shape.coefficients[k]), float(shape.covariance[k, k])
        yield Jump(place, step, float(np.sqrt(power * variance)), chance)


def slope(one: Judged, x: Array) -> tuple[float, float, float]:
    """Slope over ``x`` (n,) and its interval, from where the series began to grow."""
    rows = slice(one.shape.places[0] - 1 if one.shape.kind == "bend" else 0, None)
    series = one.series
    if len(series.value[rows]) < 3:
        rows = slice(-3, None)
    along = line(x[rows], series.value[rows], series.sigma[rows])
    middle = float(along.coefficients[1])
    half = float(stats.t.ppf(0.5 + COVERED / 2, one.dof) * np.sqrt(along.covariance[1, 1] * one.variance))
    return middle, middle - half, middle + half


def moment(one: Judged, jump: Jump) -> tuple[float, float]:
    """When a change was [s since the epoch] and its standard deviation.

    It lies between two recordings; which two, the likelihood of each place says.
    """
    series, n = one.series, len(one.series.value)
    others = [place for place in one.shape.places if place != jump.place]
    low = max([place for place in others if place < jump.place], default=0) + 1
    high = min([place for place in others if place > jump.place], default=n)
    places = np.arange(low, high)
    rest = np.array([_rest(one, sorted([*others, int(place)])) for place in places]) / one.variance
    weight = np.exp(-0.5 * (rest - rest.min()))
    weight /= weight.sum()
    middle = (series.time[places - 1] + series.time[places]) / 2
    wide = (series.time[places] - series.time[places - 1]) ** 2 / 12
    mean = float(weight @ middle)
    return mean, float(np.sqrt(weight @ (wide + (middle - mean) ** 2)))


def _rest(one: Judged, places: list[int]) -> float:
    value, sigma = one.series.value, one.series.sigma
    edges, total = [0, *places, len(value)], 0.0
    for start, end in pairwise(edges):
        weight = 1.0 / sigma[start:end] ** 2
        part = value[start:end]
        total += float(weight @ (part - weight @ part / weight.sum()) ** 2)
    return total
