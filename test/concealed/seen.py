"""A recording as the comparisons see it: what the nominal arm says, what the joints showed, and features."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from test.concealed.nominal import HALF_WIDTH, KP, RATIO, V_MAX, Array, load, nominal_wire
from test.concealed.removed import SKIP, at_stamps, read_angles, servo_angles
from test.concealed.sensing import PERIOD

SMOOTH = 5  # samples over which speeds are taken


@dataclass(frozen=True)
class Seen:
    """At the stamps of joint_states: shown (what the sensors said), nominal (n, 5) rad; late (n,).

    On an even grid of 10 ms: grid_phi, grid_nominal (m, 5) rad; place (n,): the grid's index of each stamp.
    ``late`` are the samples that count: the play has engaged.
    """

    shown: Array
    nominal: Array
    late: NDArray[np.bool_]
    fine_phi: Array
    fine_place: NDArray[np.int64]
    grid_phi: Array
    grid_nominal: Array
    place: NDArray[np.int64]

    def error(self, theta: Array, truth: Array | None, noise: float) -> float:
        """Rms of theta (n, 5) against the truth; None: against the readings, whose noise is taken off."""
        wrong = (theta - (self.shown if truth is None else truth))[self.late]
        left = noise**2 if truth is None else 0.0
        return float(np.sqrt(max((wrong**2).mean() - left, 0.0)))


def look_at(bag: Path, source: str, servo: tuple[float, float] = (KP, V_MAX)) -> Seen:
    """Reads a recording. source: "gearbox_states" or "setpoints", what the nominal arm is driven by.

    servo: Kp 1/s and top speed rad/s, used from setpoints.
    """
    shown = read_angles(bag, "joint_states")
    by_servo = source == "setpoints"
    driven = servo_angles(bag, servo) if by_servo else read_angles(bag, "trunk/gearbox_states")
    fine = np.unique(np.concatenate([driven.stamp, shown.stamp]))
    fine_phi = at_stamps(fine, driven)
    nominal = nominal_wire(fine_phi)
    places = np.searchsorted(fine, shown.stamp)
    step = round(PERIOD * 1e9)
    grid = np.arange(fine[0], fine[-1] + step, step)
    grid_phi = at_stamps(grid, driven)
    place = np.clip(np.round((shown.stamp - fine[0]) / step).astype(np.int64), 0, grid.size - 1)
    late = shown.stamp - shown.stamp[0] > SKIP * 1e9
    return Seen(shown.angle, nominal[places], late, fine_phi, places, grid_phi, nominal_wire(grid_phi), place)


@dataclass(frozen=True)
class Features:
    """On the grid: theta, speed, load, memory of direction -1 ... 1 (m, 5) each, and time t (m,) s."""

    theta: Array
    speed: Array
    load: Array
    memory: Array
    t: Array


def features_of(seen: Seen) -> Features:
    """What may explain a residual, from the gearbox angle alone."""
    theta = seen.grid_nominal
    even = uniform_filter1d(RATIO * seen.grid_phi, SMOOTH, axis=0, mode="nearest")
    speed = np.gradient(even, PERIOD, axis=0)
    memory = (RATIO * seen.grid_phi - theta) / HALF_WIDTH
    return Features(theta, speed, load(theta), memory, np.arange(len(theta), dtype=np.float64) * PERIOD)
