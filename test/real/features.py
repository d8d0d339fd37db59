"""What the peers see of a recording: commands, past commands, plays of many widths, loads."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trunk_ros.recording.recording import Recording

Array = NDArray[np.float64]
WIDTHS = np.geomspace(0.015, 0.9, 11)  # of the range of a motion
PAST = 6  # samples
STANDS = 1e-6  # of a column: it stands, and shows nothing


@dataclass(frozen=True)
class Run:
    """A recording at the stamps of its joints: commands (n, k), loads of motors and load cells (n, any),
    joints (n, m), NaN where lost.
    """

    stamp: Array
    commands: Array
    loads: Array
    angles: Array

    def part(self, first: int, last: int) -> Run:
        """Some of its rows."""
        rows = slice(first, last)
        return Run(self.stamp[rows], self.commands[rows], self.loads[rows], self.angles[rows])


def ends(recording: Recording) -> tuple[str, str]:
    """The topic that drives, and the one that shows where that led."""
    wires = "gearbox_states", "joint_states"
    return wires if "joint_states" in recording.series else ("setpoints", "gearbox_states")


def run_of(recording: Recording, joints: tuple[str, ...]) -> Run:
    """Commands are held at what was last asked for; angles of ``joints`` alone. Of a recording without joints
    the servos' setpoints, and where these went.
    """
    driven, shown = (recording.require(topic) for topic in ends(recording))
    shown = shown.select(joints)
    last = np.clip(np.searchsorted(driven.stamp, shown.stamp + 1e-6, side="right") - 1, 0, None)
    motors = [] if driven.effort is None else [driven.effort[last]]
    cells = [] if shown.effort is None else [shown.effort]
    loads = np.hstack([np.empty((len(last), 0)), *motors, *cells])
    return Run(shown.stamp, np.nan_to_num(driven.position[last]), np.nan_to_num(loads), shown.position)


@njit(cache=True)
def play(x: Array, width: float) -> Array:
    """Play of a half-width over (n,)."""
    out, at = np.empty_like(x), x[0]
    for k in range(len(x)):
        at = min(max(at, x[k] - width), x[k] + width)
        out[k] = at
    return out


class Features:
    """The same columns for every run of an arm, scaled as its first one was."""

    def __init__(self, run: Run, own: list[int]):
        """``own``: places of the joints of interest among the commands, whose sums and differences count."""
        self.pairs = list(combinations(own, 2))
        self.ranges = [max(float(np.ptp(m)), 1e-9) for m in self._motions(run)]
        raw = self._raw(run)
        std = raw.std(axis=0)
        self.mean, self.std = raw.mean(axis=0), np.where(std > STANDS, std, 1.0)

    def __call__(self, run: Run) -> Array:
        """(n, columns)."""
        return np.asarray((self._raw(run) - self.mean) / self.std)

    def _motions(self, run: Run) -> list[Array]:
        u = run.commands
        both = [u[:, a] + sign * u[:, b] for a, b in self.pairs for sign in (1.0, -1.0)]
        return [*(np.ascontiguousarray(c) for c in u.T), *both]

    def _raw(self, run: Run) -> Array:
        moved = [
            play(m, float(w * size))
            for m, size in zip(self._motions(run), self.ranges, strict=True)
            for w in WIDTHS
        ]
        past = [np.vstack([run.commands[:1]] * k + [run.commands[:-k]]) for k in range(1, PAST + 1)]
        turned = [run.commands * load[:, None] for load in run.loads.T]
        loads = [run.loads, run.loads**2, *turned] if run.loads.size else []
        return np.column_stack([run.commands, *moved, *past, *loads])
