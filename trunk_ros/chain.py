"""The effects of a stage in physical order: run forward, or backward for the compensator.

A block like ``scipy.signal.lfilter``: state goes in and comes out, so that a whole recording and a single node tick are
the same call.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.effects.servo.loop import servo_loop
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.errors import ModelError
from trunk_ros.model import Model

SENSOR = 700  # blocks from this place on change the reading, not the joint
PASSES = 6  # joints that drag each other are computed until they agree
AGREED = 1e-9  # rad
REMEMBERED = 0.6  # s of past setpoints, longer than any servo delay


@dataclass
class State:
    """The memory of a chain between two calls."""

    stamp: float
    x: Array
    """(columns,) the last input."""
    blocks: dict[str, Any] = field(default_factory=dict)
    core: Any = None


def wire_pass(x: Array, now: Now, effects: Sequence[Effect], core: Core, state: State | None) -> tuple[Array, Array, State]:
    """Gearbox angle (n, columns) to joint reading, and to the joint's own angle before the sensor."""
    blocks = {} if state is None else dict(state.blocks)
    u = x * now.ratio
    u = _through(u, [e for e in effects if e.place < Effect.CORE], now, blocks)
    for e in effects:
        if e.place == Effect.CORE:
            e.adjust(core, now)
    u, memory = (core.rounding or SharpPlay()).run(u, core.width, None if state is None else state.core)
    true = _through(u, [e for e in effects if Effect.CORE < e.place < SENSOR], now, blocks)
    shown = _through(true, [e for e in effects if e.place >= SENSOR], now, blocks)
    return shown, true, State(float(now.stamp[-1]), x[-1], blocks, memory)


def wire_pass_back(y: Array, now: Now, effects: Sequence[Effect], core: Core, state: State | None) -> tuple[Array, State]:
    """Wanted joint angle (n, columns) to gearbox angle; readings' errors and what has no inverse are left out."""
    blocks = {} if state is None else dict(state.blocks)
    for e in effects:
        if e.place == Effect.CORE:
            e.adjust(core, now)
    possible = [e for e in effects if e.compensable]
    u = _back(y, [e for e in possible if e.place > Effect.CORE], now, blocks)
    u, memory = (core.rounding or SharpPlay()).invert(u, core.width, None if state is None else state.core)
    u = _back(u, [e for e in possible if e.place < Effect.CORE], now, blocks)
    return u / now.ratio, State(float(now.stamp[-1]), y[-1], blocks, memory)


def _through(x: Array, effects: Sequence[Effect], now: Now, blocks: dict[str, Any]) -> Array:
    for e in effects:
        x, blocks[e.id] = e.run(x, now, blocks.get(e.id))
    return x


def _back(y: Array, effects: Sequence[Effect], now: Now, blocks: dict[str, Any]) -> Array:
    for e in reversed(effects):
        y, blocks[e.id] = e.invert(y, now, blocks.get(e.id))
    return y


class Chain:
    """One stage of a model over all its joints: ``wire``, ``servo`` or ``arm``."""

    def __init__(self, model: Model, stage: str, hold_time: bool = False):
        """``hold_time``: effects of time stay at the model's ``duration`` (live nodes). Raises ModelError for a wrong stage."""
        if stage not in ("wire", "servo", "arm"):
            raise ModelError(f"unknown stage {stage!r}: choose wire, servo or arm")
        self.stage = stage
        self.model = model
        self.arm: Arm = model.loaded_arm()
        self.effects = model.bound(stage)
        self.duration = model.duration if hold_time else None
        words = any(e.texts for e in self.effects)
        self._looks_around = words or any("load" in e.needs for e in self.effects)
        self._looks_at_gearbox = any(e.id in ("transmission_ripple", "unknown") for e in self.effects)

    def run(self, x: Array, stamp: Array, state: State | None = None, velocity: Array | None = None) -> tuple[Array, State]:
        """Pass ``x`` (n, joints) at ``stamp`` (n,) s through the stage; state None at the start of a recording.

        wire: gearbox angle to joint reading; servo: setpoint to gearbox angle; arm: joint angle to tip (n, 3) y, z, roll.
        ``velocity`` (n, joints): speed of the gearbox where it is measured.
        """
        if self.stage == "wire":
            shown, _, after = self._wire(x, stamp, state, velocity)
            return shown, after
        if self.stage == "servo":
            return self._servo(x, stamp, state)
        return self.tip(x, stamp), State(float(stamp[-1]), x[-1])

    def invert(self, y: Array, stamp: Array, state: State | None = None) -> tuple[Array, State]:
        """Wire: the gearbox angle (n, joints) that makes the joint angle ``y``; never compensates a late sensor."""
        if self.stage != "wire":
            raise ModelError(f"the {self.stage} stage has no inverse")
        x = y / self.arm.ratio
        last = None if state is None else State(state.stamp, state.x / self.arm.ratio)
        for _ in range(3 if self._looks_at_gearbox else 1):
            now = self.look(x, stamp, last, None, y)
            x, after = wire_pass_back(y, now, self.effects, self._core(), state)
        return x, after

    def look(self, gearbox: Array, stamp: Array, state: State | None, velocity: Array | None, angles: Array) -> Now:
        """What the effects see of the arm."""
        before = stamp[:1] if state is None else np.array([state.stamp])
        dt = np.diff(stamp, prepend=before)
        if velocity is None:
            moved = np.diff(gearbox, axis=0, prepend=gearbox[:1] if state is None else state.x[None])
            velocity = np.divide(moved, dt[:, None], out=np.zeros_like(moved), where=dt[:, None] > 0)
        clock = stamp if self.duration is None else np.full_like(stamp, self.duration)
        load = self.arm.load(angles) if self._looks_around else np.broadcast_to(0.0, gearbox.shape)
        return Now(clock, dt, gearbox, velocity * self.arm.ratio, load, angles, self.arm.joints, self.arm.ratio)

    def _core(self) -> Core:
        nominal = self.arm.dead_band[None]
        return Core(nominal_width=nominal, width=nominal)

    def angles(self, x: Array, stamp: Array, velocity: Array | None = None) -> Array:
        """The joints' own angles (n, joints) under gearbox angles ``x``, before the sensors have their say."""
        return self._wire(x, stamp, None, velocity)[1]

    def _wire(self, x: Array, stamp: Array, state: State | None, velocity: Array | None) -> tuple[Array, Array, State]:
        angles = x * self.arm.ratio
        for _ in range(PASSES if self._looks_around else 1):
            now = self.look(x, stamp, state, velocity, angles)
            shown, true, after = wire_pass(x, now, self.effects, self._core(), state)
            change = np.max(np.abs(true - angles), initial=0.0)
            angles = true
            if change < AGREED:
                break
        return shown, angles, after

    def _servo(self, x: Array, stamp: Array, state: State | None) -> tuple[Array, State]:
        start = np.vstack([x[0], np.zeros_like(x[0])]) if state is None else state.core[2]
        past = (stamp[:0], x[:0]) if state is None else state.core[:2]
        stamps, setpoints = np.concatenate([past[0], stamp]), np.concatenate([past[1], x])
        phi = x if state is None else np.broadcast_to(start[0], x.shape)
        for _ in range(3 if self._looks_around or any(e.place > Effect.CORE for e in self.effects) else 1):
            now = self.look(phi, stamp, state, None, phi * self.arm.ratio)
            phi, core = run_servo(self.arm, self.effects, now, setpoints, stamps, start)
        blocks = {} if state is None else dict(state.blocks)
        out = _through(phi, [e for e in self.effects if e.place > Effect.CORE], now, blocks)
        kept = max(int(np.searchsorted(stamps, stamps[-1] - REMEMBERED)) - 1, 0)
        return out, State(float(stamp[-1]), phi[-1], blocks, (stamps[kept:], setpoints[kept:], core))

    def tip(self, theta: Array, stamp: Array) -> Array:
        """Tip (n, 3) y, z [m], roll [rad] of joint angles (n, joints). Raises ModelError without link lengths."""
        if not self.arm.has_geometry:
            raise ModelError("the model has no arm.link_length, so there is no tip")
        now = self.look(theta / self.arm.ratio, stamp, None, None, theta)
        return tip_pass(self.arm, self.effects, theta, now)


def run_servo(arm: Arm, effects: Sequence[Effect], now: Now, setpoints: Array, stamps: Array, start: Array) -> tuple[Array, Array]:
    """Gearbox angle (n, columns) and the loop's state (2, columns) after it; ``setpoints`` may begin with past rows."""
    n, columns = now.gearbox.shape
    core = Core(
        kp=np.full(columns, arm.kp), tau_v=np.full(columns, arm.tau_v), v_max=np.full(columns, arm.v_max),
        delay=np.zeros(columns), pull=np.zeros((n, columns)), cogging=np.zeros((3, columns)),
    )
    for e in effects:
        if e.place == Effect.CORE:
            e.adjust(core, now)
    out, state = np.empty((n, columns)), start.copy()
    skip = len(stamps) - n
    pull = np.concatenate([np.repeat(core.pull[:1], skip, axis=0), core.pull])
    spread = (np.ascontiguousarray(np.broadcast_to(v, columns)) for v in (core.kp, core.tau_v, core.v_max, core.delay))
    servo_loop(np.ascontiguousarray(setpoints), stamps, *spread, pull, core.cogging, skip, state, out)
    return out, state


def tip_pass(arm: Arm, effects: Sequence[Effect], theta: Array, now: Now) -> Array:
    """Tip (n, 3) of joint angles (n, joints) with the effects of the arm stage."""
    core = Core(link_length=arm.link_length)
    for e in effects:
        if e.place == Effect.CORE:
            e.adjust(core, now)
    heading = np.cumsum(theta, axis=1)
    out = np.column_stack([-(np.sin(heading) @ core.link_length), np.cos(heading) @ core.link_length, heading[:, -1]])
    return _through(out, [e for e in effects if e.place > Effect.CORE], now, {})
