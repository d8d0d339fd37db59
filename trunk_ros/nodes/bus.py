"""What drives the motors: an interface, and a simulated bus that implements it."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.chain import Chain, State
from trunk_ros.errors import ArgumentError
from trunk_ros.model import Model
from trunk_ros.nodes.parameters import SIMULATED
from trunk_ros.trajectory import Array

WAITING = 1000  # setpoints of the future that are kept
SLOW = 1e-3  # rad/s below which friction takes no side


@dataclass(frozen=True)
class Sample:
    """State of the gearbox shafts: (joints,) rad, rad/s, N m."""

    position: Array
    velocity: Array
    effort: Array


class Bus(Protocol):
    """Motors with position control. Times are seconds that never run backwards."""

    def read(self, at: float) -> Sample:
        """The state at ``at``. Raises TrunkError where the motors do not answer."""

    def write(self, setpoint: Array, at: float) -> None:
        """Ask for gearbox angles (joints,) rad from ``at`` on; the caller has checked the limits."""

    def close(self) -> None:
        """Leave the motors holding."""


class SimulatedBus:
    """The servo stage of a model behind encoders."""

    def __init__(self, model: Model, position: Array | None = None):
        """``position``: gearbox angle (joints,) rad at the start, by default the arm's rest."""
        self.arm = model.arm
        self._chain = Chain(model, "servo", hold_time=True)
        self._load = model.at_end().loaded_arm().load
        self._count = 2 * np.pi / self.arm.counts_per_rev
        self._setpoint = self.arm.asked(self.arm.rest) if position is None else position.copy()
        self._waiting: list[tuple[float, Array]] = []
        self._state: State | None = None
        self._read: tuple[float, Array] | None = None
        self._chain.run(
            np.tile(self._setpoint, (3, 1)), np.arange(3.0) / 100
        )  # compiles, so that no step is late

    def write(self, setpoint: Array, at: float) -> None:
        """The setpoint acts from its time on, or at once where that is past."""
        self._waiting = sorted([*self._waiting[-WAITING:], (at, setpoint)], key=lambda pair: pair[0])

    def read(self, at: float) -> Sample:
        """Encoder position, speed and motor torque at ``at``."""
        phi = self._advance(at)
        before, self._read = self._read, (at, phi)
        speed = np.zeros_like(phi)
        if before is not None and at > before[0]:
            speed = (phi - before[1]) / (at - before[0])
        return Sample(np.round(phi / self._count) * self._count, speed, self._torque(phi, speed))

    def close(self) -> None:
        """Nothing holds a simulated motor."""

    def _advance(self, at: float) -> Array:
        """Gearbox angle at ``at``, read before a setpoint of the same time acts."""
        stamps, rows = [], []
        if self._state is not None:
            due = [pair for pair in self._waiting if pair[0] < at]
            self._waiting = [pair for pair in self._waiting if pair[0] >= at]
            stamps = [max(begin, self._state.stamp) for begin, _ in due]
            rows = [setpoint for _, setpoint in due]
        self._setpoint = rows[-1] if rows else self._setpoint
        out, self._state = self._chain.run(
            np.array([*rows, self._setpoint]), np.array([*stamps, at]), self._state
        )
        return out[-1]

    def _torque(self, phi: Array, speed: Array) -> Array:
        """Against the weight, plus the wire's friction in the direction of motion [N m]."""
        torque = -self.arm.carried(self._load(self.arm.driven(phi)[None]))[0]
        if self.arm.wire is None:
            return torque
        wire = self.arm.wire
        friction = wire.pull_tension * (1 - wire.efficiency) * wire.shaft_radius
        return torque + friction * between(speed / SLOW, -1.0, 1.0)


def bus_of(name: str, model: Model) -> Bus:
    """The bus of a name: ``simulated``, or ``module:Class`` of one that is called with the model.

    Raises ArgumentError where there is no such class, and what the class raises.
    """
    if name == SIMULATED:
        return SimulatedBus(model)
    module, _, kind = name.partition(":")
    try:
        made = getattr(importlib.import_module(module), kind)
    except (ImportError, AttributeError, TypeError, ValueError) as error:
        raise ArgumentError(f"bus {name!r} is neither {SIMULATED} nor MODULE:CLASS: {error}") from None
    if not (isinstance(made, type) and all(hasattr(made, name) for name in ("read", "write", "close"))):
        raise ArgumentError(f"bus {name!r} is no class with read, write and close")
    bus: Bus = made(model)
    return bus


def between(values: Array, lower: Array | float, upper: Array | float) -> Array:
    """What np.clip does, in a third of its time for a handful of joints."""
    return np.asarray(np.minimum(np.maximum(values, lower), upper))


def gearbox_limits(arm: Arm) -> tuple[Array, Array]:
    """Lowest and highest gearbox angle (joints,) rad: joint limits through the ratio, plus the dead band; of
    motors that move several joints, what they need at most for that.
    """
    if arm.coupling is not None:
        back, middle = np.linalg.inv(arm.coupling), (arm.lower + arm.upper) / 2
        reach = np.abs(back) @ ((arm.upper - arm.lower) / 2 + arm.dead_band)
        return back @ middle - reach, back @ middle + reach
    ends = np.sort(np.stack([arm.lower, arm.upper]) / arm.ratio, axis=0)
    play = arm.dead_band / np.abs(arm.ratio)
    return ends[0] - play, ends[1] + play


def within(setpoint: Array, arm: Arm) -> Array:
    """The gearbox angles (joints,) next to a setpoint at which all joints are within their limits."""
    if arm.coupling is None:
        return setpoint
    there = arm.driven(setpoint)
    return arm.asked(between(there, arm.lower - arm.dead_band, arm.upper + arm.dead_band))
