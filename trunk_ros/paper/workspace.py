"""What the paper leaves to further work: the tip's error with all joints turned, the stretch under load."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.model import Model

LEVELS = 9
WORST, HYSTERESIS = "dead bands, worst signs", "dead bands, as the hysteresis"
STRETCH, BOTH = "stretch under the weight", "hysteresis and stretch"


@dataclass(frozen=True)
class Workspace:
    """Tip errors: of the straight arm first, then with all joints at their upper limit, then all over."""

    tip: Array
    """(n, 2) m: y, z."""
    errors: dict[str, Array]
    """(n,) m, by what causes them."""
    tension: float
    """N, the most that the weight asks of a wire."""

    def summary(self) -> dict[str, list[float]]:
        """Median, largest, straight arm and all joints at their upper limit, m."""
        return {way: [float(np.median(e)), float(e.max()), *e[:2].tolist()] for way, e in self.errors.items()}


def workspace(arm: Arm, levels: int = LEVELS) -> Workspace:
    """The errors at all postures made of ``levels`` angles per joint, for the hysteresis in random order."""
    theta = postures(arm, levels)
    stretch = {"load_elasticity": {"compliance": arm.compliance}}
    tight = replace(arm, dead_band=np.zeros_like(arm.dead_band))
    tip = tip_of(arm, theta)
    errors = {
        WORST: worst_signs(arm, theta),
        HYSTERESIS: tip_error(arm, through_wire(arm, theta), tip),
        STRETCH: tip_error(arm, through_wire(tight, theta, stretch), tip),
        BOTH: tip_error(arm, through_wire(arm, theta, stretch), tip),
    }
    radius = arm.wire.cylinder_radius if arm.wire else np.inf
    visited = {name: error[1:] for name, error in errors.items()}
    return Workspace(tip[1:], visited, float(np.abs(arm.load(theta)).max() / radius))


def postures(arm: Arm, levels: int) -> Array:
    """Joint angles (3 + levels^joints, joints) rad in the order visited.

    First all at the lower limit (the play has not settled yet), then straight, then all at the upper limit.
    """
    spread = np.linspace(arm.lower, arm.upper, levels).T
    grid = np.random.default_rng(5).permutation(np.array(list(product(*spread))))
    return np.vstack([arm.lower, np.zeros_like(arm.lower), arm.upper, grid])


def tip_of(arm: Arm, theta: Array) -> Array:
    """(n, 2) m: y, z at postures (n, joints), all of them together."""
    return arm.body.ends(theta)[:, 1:3]


def tip_error(arm: Arm, theta: Array, wanted: Array) -> Array:
    """Distance (n,) m of the tip at postures (n, joints) from where it is wanted (n, 2) m."""
    off = tip_of(arm, theta) - wanted
    distance: Array = np.hypot(off[:, 0], off[:, 1])
    return distance


def worst_signs(arm: Arm, theta: Array) -> Array:
    """Tip error (n,) m with every joint off by its dead band, each whichever way is worst."""
    tip = tip_of(arm, theta)
    off = np.array(list(product((-1.0, 1.0), repeat=len(arm.joints)))) * arm.dead_band
    worst: Array = np.max([tip_error(arm, theta + each, tip) for each in off], axis=0)
    return worst


def through_wire(arm: Arm, theta: Array, effects: dict[str, Any] | None = None) -> Array:
    """Joint angles (n, joints) reached where ``theta`` is wanted, each joint straight from angle to angle.

    Play does not know of speed: its turning points are all that it needs to be given.
    """
    stamp = np.arange(len(theta), dtype=float)
    return Chain(Model(arm, effects or {}), "wire").run(theta / arm.ratio, stamp)[0]
