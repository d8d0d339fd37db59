"""Whether what wanders on a joint is of the arm: of a size that goes with its motion, or the same on another
joint. Sensors are independent of either.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.noise import FLOOR, Noise, rms
from trunk_ros.data.surroundings import counted
from trunk_ros.derivatives import gradient
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.bank_weights import CUTS, thinned
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.effects import effect
from trunk_ros.effects.curve import Curve
from trunk_ros.guards import SAME
from trunk_ros.levels import PART, SURE

STEADY, SPEED, ACCELERATION, LOAD = range(4)
Signals = list[Array]


def of_the_arm(context: Context, hypothesis: Hypothesis, column: int, noise: Noise) -> bool:
    """Whether what a hypothesis leaves of a column is for sure no ``noise`` of its sensor: a good part of it
    is a factor that wanders, as a lag of clocks or a payload does, on the joint's own speed, acceleration or
    load; or it, or its factor on the speed, wanders as that of another joint does.
    """
    seen = context.in_noise([noise] * len(context.joints))
    wanders = max(noise.std**2 - noise.white**2, FLOOR**2)
    rest = thinned(seen.whitened(hypothesis, column))
    for of in (SPEED, ACCELERATION, LOAD):
        shape = _shape(seen, column, of)
        course, gain, usual, chance = _course(seen, column, rest, shape, noise)
        if gain > usual + SURE * chance:
            size = (1.0 - usual / gain) * _size(seen, _times(course, shape), column) ** 2
            if size > PART * wanders:
                return True
    others = [c for c in seen.columns if c != column]  # a curve over time may hold what both have
    rests = {c: thinned(seen.whitened(untimed(hypothesis, c), c)) for c in others}
    for of in (STEADY, SPEED):
        shape = _shape(seen, column, of)
        for other in others:
            course, *_ = _course(seen, other, rests[other], _shape(seen, other, of), noise)
            alike = _times(course, shape)
            change = thinned(seen.whiten_change(alike, column))
            along, power = float(change @ rest), max(float(change @ change), FLOOR)
            chance = float(np.linalg.norm(change * rest))  # also of noise that is louder at times
            size = abs(along) / power * _size(seen, alike, column)
            if abs(along) > SURE * chance and size**2 > PART * wanders:
                return True
    return False


def _shape(context: Context, column: int, of: int) -> Signals:
    """What may be multiplied by a factor, one (n,) a span."""
    out = []
    for view in context.views:
        speed = view.columns[column].speed
        if of == STEADY:
            out.append(np.ones_like(speed))
        elif of == SPEED:
            out.append(speed)
        elif of == ACCELERATION:
            out.append(gradient(speed, view.span.stamp))
        else:
            out.append(view.span.measured(view.load[:, column]))
    return out


def _course(
    context: Context, column: int, rest: Array, shape: Signals, noise: Noise
) -> tuple[Signals, float, float, float]:
    """The factor on a shape that explains most of the ``rest`` (k,) of a column, a line from one moment to
    the next, as far apart as a ``noise`` remembers, one (n,) a span; what it gains, what it would of noise
    alone, which may be louder at times, and by how much that may be off by chance.
    """
    changes = (context.whiten_change(_times(one, shape), column) for one in _moments(context, noise))
    design = np.column_stack([*map(thinned, changes)])
    squared, axes = np.linalg.eigh(design.T @ design)  # a tenth of what the decomposition itself takes
    told = squared > SAME**2 * squared[-1]
    size, axes = np.sqrt(squared[told]), axes[:, told]
    left = design @ (axes / size)
    along = left.T @ rest
    course = [np.zeros_like(signal) for signal in shape]
    for value, factor in zip(axes @ (along / size), _moments(context, noise), strict=True):
        course = [whole + value * one for whole, one in zip(course, factor, strict=True)]
    usual = float((left**2).sum(axis=1) @ rest**2)
    chance = usual * float(np.sqrt(2.0 / max(len(along), 1)))
    return course, float(along @ along), usual, chance


def _moments(context: Context, noise: Noise) -> Iterator[Signals]:
    """Factors that are 1 at one moment of a span and 0 at the next ones."""
    spans = [view.span.stamp - view.span.stamp[0] for view in context.views]
    remembers = -context.step / np.log(noise.correlation) if noise.correlation > 0.0 else 0.0
    apart = max(remembers, sum(float(since[-1]) for since in spans) / CUTS)
    for k, since in enumerate(spans):
        for moment in range(int(since[-1] / apart) + 2):
            here = np.maximum(1.0 - np.abs(since / apart - moment), 0.0)
            yield [here if i == k else np.zeros_like(other) for i, other in enumerate(spans)]


def _times(factor: Signals, shape: Signals) -> Signals:
    return [f * s for f, s in zip(factor, shape, strict=True)]


def _size(context: Context, signals: Signals, column: int) -> float:
    return rms(counted(context.views, context.even(signals, column), column))


def untimed(hypothesis: Hypothesis, column: int) -> Hypothesis:
    """Without the curves over time on a column that a reading which wanders looks like."""
    names = [
        term.effect
        for term in hypothesis.on(column)
        if issubclass(kind := effect(term.effect), Curve) and kind.follows_readings
        if "time" in term.words.get(column, {}).values()
    ]
    return hypothesis.less(names, column) if names else hypothesis
