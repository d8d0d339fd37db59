"""Two streams of samples on one grid, as far as both have come; and the stage that runs between them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from trunk_ros.chain import Chain, State
from trunk_ros.compiled import Array
from trunk_ros.model import Model

GAP = 0.5  # s without samples after which a stage begins anew
BANDS = 4.0  # dead bands that a joint has to move until it is known where in its play it is
MOVED = 3e-3  # rad, at least
SETTLING = 1.0  # s in which a servo forgets how it began


@dataclass
class Buffer:
    """Samples (joints,) with stamps [s], rising."""

    stamps: list[float] = field(default_factory=list)
    values: list[Array] = field(default_factory=list)

    def add(self, stamp: float, value: Array) -> None:
        """One sample (joints,) at ``stamp`` s; one that does not come after the last is left out."""
        if not self.stamps or stamp > self.stamps[-1]:
            self.stamps.append(stamp)
            self.values.append(value)

    def drop(self, before: float) -> None:
        """Forget samples before a time, the last of them aside: the next begins from it."""
        first = max(int(np.searchsorted(self.stamps, before)) - 1, 0)
        del self.stamps[:first], self.values[:first]

    def clear(self) -> None:
        """Forget all."""
        self.stamps.clear()
        self.values.clear()

    def arrays(self) -> tuple[Array, Array]:
        """Stamps (n,) and values (n, joints)."""
        return np.array(self.stamps), np.array(self.values)


@dataclass(frozen=True)
class Piece:
    """What a stage shows in a while: stamps (n,), residual, angle and speed (n, joints) on the joint side;
    ``valid`` (n, joints): where it tells something.
    """

    stamp: Array
    residual: Array
    angle: Array
    speed: Array
    valid: np.ndarray


class Stage:
    """One stage of a model, run along as samples come: ``wire`` or ``servo``."""

    def __init__(self, model: Model, name: str):
        self.name, self.arm = name, model.arm
        self.chain = Chain(model, name, hold_time=True)
        self.given, self.shown = Buffer(), Buffer()
        self.scale = self.arm.ratio if name == "wire" else np.ones(len(self.arm.joints))
        self.least = np.maximum(BANDS * self.arm.dead_band, MOVED)
        self.restart()

    def restart(self) -> None:
        """Begin with no memory."""
        self.given.clear()
        self.shown.clear()
        self.state: State | None = None
        self.end = -np.inf
        self.begun = np.nan
        self.low = np.full(len(self.arm.joints), np.inf)
        self.high = -self.low

    def piece(self, least: float) -> Piece | None:
        """What has come since the last piece, where that is ``least`` seconds or more."""
        if len(self.given.stamps) < 2 or len(self.shown.stamps) < 2:
            return None
        until = min(self.given.stamps[-1], self.shown.stamps[-1])
        since = max(self.end, self.given.stamps[0])
        if until - since < least:
            return None
        out = self._compared(since, until)
        self.given.drop(until)
        self.shown.drop(until)
        return out

    def _compared(self, since: float, until: float) -> Piece | None:
        at, given = self.given.arrays()
        when, shown = self.shown.arrays()
        if np.diff(at).max() > GAP or (np.isfinite(self.end) and at[0] - self.end > GAP):
            self.restart()
            return None
        grid = np.union1d(at, when)
        grid = grid[(grid > since) & (grid <= until)]
        rows = np.searchsorted(grid, when[(when > since) & (when <= until)])
        if len(grid) < 2 or not len(rows):
            return None
        source = self._on(grid, at, given)
        predicted, self.state = self.chain.run(source, grid, self.state)
        self.end = float(grid[-1])
        self.begun = float(grid[0]) if np.isnan(self.begun) else self.begun
        measured = shown[(when > since) & (when <= until)]
        angle = (source * self.scale) if self.name == "wire" else predicted
        speed = np.gradient(angle, grid, axis=0)[rows]
        residual = measured - predicted[rows]
        valid = np.isfinite(residual) & self._known(angle, grid)[rows]
        return Piece(grid[rows], np.where(valid, residual, 0.0), angle[rows], speed, valid)

    def _on(self, grid: Array, at: Array, given: Array) -> Array:
        """Gearbox angles straight between samples; setpoints hold."""
        if self.name == "servo":
            held = np.clip(np.searchsorted(at, grid + 1e-9, side="right") - 1, 0, None)
            return np.ascontiguousarray(given[held])
        return np.column_stack([np.interp(grid, at, column) for column in given.T])

    def _known(self, angle: Array, grid: Array) -> np.ndarray:
        """(n, joints): from where on the memory of the stage has nothing left of its unknown start."""
        if self.name == "servo":
            return np.repeat((grid > self.begun + SETTLING)[:, None], angle.shape[1], axis=1)
        low = np.minimum(np.minimum.accumulate(angle, axis=0), self.low)
        high = np.maximum(np.maximum.accumulate(angle, axis=0), self.high)
        self.low, self.high = low[-1], high[-1]
        return np.asarray(high - low > self.least)
