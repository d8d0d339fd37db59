"""The noise of all joints of a stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.noise import FLOOR, Noise, differences_of
from trunk_ros.data.revisited import between_visits

PLAIN = 0.25  # of the joints: so many show little but noise


@dataclass(frozen=True)
class Rest:
    """What is left of a joint (n,) of each recording, where it counts (n,), over how many samples at most its
    noise is compared, the standard deviation of its encoder's steps, and whether there is enough of it.
    """

    residuals: list[Array]
    masks: list[np.ndarray]
    longest: int
    steps: float
    enough: bool


def noises(rests: Sequence[Rest], visits: Sequence[np.ndarray] = ()) -> list[Noise]:
    """A size for each joint, one colour for all, as their sensors are alike; some may have more than noise
    left, which only adds to the colour that is seen. ``visits``: of what stops to measure the row (n,) of
    each recording at the place nearest to that of each row; between these there is less than from one stop to
    the next where stops are far apart.
    """
    seen = [differences_of(rest.residuals, rest.masks, rest.longest, rest.steps) for rest in rests]
    several = [s for s, rest in zip(seen, rests, strict=True) if len(s.strides) > 1 and rest.enough]
    told = [s.correlation for s in several if not s.swings]
    colour = float(np.quantile(told, PLAIN)) if told else 0.0
    found = [s.noise(colour if len(s.strides) > 1 else 0.0) for s in seen]
    if not visits:
        return found
    there = [between_visits(rest.residuals, rest.masks, visits) for rest in rests]
    return [replace(n, std=s) if FLOOR < s < n.std else n for n, s in zip(found, there, strict=True)]
