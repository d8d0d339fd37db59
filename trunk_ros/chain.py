"""The effects of a stage in physical order: run forward, or backward for the compensator.

A block like ``scipy.signal.lfilter``: state goes in and comes out, so that a whole recording and a single
node tick are the same call.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect
from trunk_ros.effects.servo.loop import fresh
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.errors import ModelError
from trunk_ros.look import UNKNOWN, Given, Look
from trunk_ros.passes import Crossing, Passes
from trunk_ros.resistance import Resistance
from trunk_ros.servo_run import run_servo, servo_core
from trunk_ros.stage import (
    Memory,
    Order,
    State,
    adjusted,
    back,
    drift,
    friction,
    through,
    tip_pass,
    wire_pass,
)

# Wire effects from this place on end the motion or show it: neither load nor coupling depends on them.
STOP = 600
AGREED_BACK = 2e-8  # rad: on the way back a reversal makes more of what is left, and blocks would show
AHEAD = 0.1  # s over which the last sample's trend is trusted
REMEMBERED = 0.6  # s of past setpoints, longer than any servo delay
MOTOR = ("gearbox", "winding")  # what on the way back is not known beforehand
BLOCK = 40_000  # joint-steps that are worked on at once, so that they stay in the processor's cache

Advance = Callable[..., tuple[Array, Array, State]]
__all__ = ["Chain", "State", "run_servo", "tip_pass", "wire_pass"]


class Chain:
    """One stage of a model over all its joints: ``wire``, ``servo`` or ``arm``."""

    def __init__(self, model: ArmModel, stage: str, hold_time: bool = False):
        """``hold_time``: effects of time stay at the model's ``duration`` (live nodes).

        Raises ModelError for a wrong stage.
        """
        if stage not in ("wire", "servo", "arm"):
            raise ModelError(f"unknown stage {stage!r}: choose wire, servo or arm")
        self.stage = stage
        self.model = model = model.at_end() if hold_time else model
        self.carried = model.taken_up
        self.motors: Arm = model.loaded_arm()
        self.arm = self.motors.uncoupled() if stage == "wire" else self.motors
        self.effects = model.bound(stage)
        self.order = Order.of(self.effects)
        self.duration = model.duration if hold_time else None
        bears = any(e.bears(e.form) for e in self.effects)
        hung = Chain(model, "wire", hold_time) if stage == "servo" and bears else None
        self.wires = hung if hung is not None and hung.effects else None
        """What hangs on servos that bear its load, where it is not just where they are."""
        self._inner = [e for e in self.order.after if e.acts_at < STOP]
        self._outer = [e for e in self.effects if e.acts_at >= STOP]
        self._rows = max(BLOCK // len(self.arm.joints), 1)

    def run(
        self,
        x: Array,
        stamp: Array,
        state: State | None = None,
        velocity: Array | None = None,
        resistance: Resistance | None = None,
    ) -> tuple[Array, State]:
        """Pass ``x`` (n, joints) at ``stamp`` (n,) s through the stage; state None at the start of a
        recording.

        wire: gearbox angle to joint reading; servo: setpoint to gearbox angle; arm: joint angle to tip (n,
        7), see ``tip``.
        ``velocity`` (n, joints): speed of the gearbox where it is measured; ``resistance``: what a
        recording tells of the load.
        """
        if self.stage == "arm":
            now = self._look(stamp, x, state.x if state else None, state, UNKNOWN)
            return tip_pass(self.arm, self.effects, x, now), State(float(stamp[-1]), x[-1], x[-1])
        if self.stage == "servo":
            out, _, after = self._blockwise(self._servo, x, stamp, state, Given(velocity, resistance))
            return out, after
        out, _, after = self._blockwise(self._wire, *self._led(x, velocity, stamp, state, resistance))
        return out, after

    def _led(
        self, x: Array, velocity: Array | None, stamp: Array, state: State | None, known: Resistance | None
    ) -> tuple[Array, Array, State | None, Given]:
        """What the wires see of motors that move several joints: one path of its own for each."""
        if self.motors.coupling is not None:
            x = self.motors.driven(x)
            velocity = None if velocity is None else self.motors.driven(velocity)
        return x, stamp, state, Given(velocity, known)

    def invert(self, y: Array, stamp: Array, state: State | None = None) -> tuple[Array, State]:
        """Wire: the gearbox angle (n, joints) that makes the joint angle ``y``; never compensates a late
        sensor.
        """
        if self.stage != "wire":
            raise ModelError(f"the {self.stage} stage has no inverse")
        x, _, after = self._blockwise(self._wire_back, y, stamp, state, UNKNOWN)
        return (x if self.motors.coupling is None else self.motors.asked(x)), after

    def angles(
        self, x: Array, stamp: Array, velocity: Array | None = None, resistance: Resistance | None = None
    ) -> Array:
        """The joints' own angles (n, joints) under gearbox angles ``x``, before the sensors change them."""
        return self._blockwise(self._wire, *self._led(x, velocity, stamp, None, resistance))[1]

    def tip(self, theta: Array, stamp: Array) -> Array:
        """Tip (n, 7) of joint angles (n, joints): x, y, z [m], quaternion x, y, z, w, in the base link.

        Raises ModelError where the links are not known.
        """
        return self.run(theta, stamp)[0]

    def _blockwise(
        self, advance: Advance, x: Array, stamp: Array, state: State | None, given: Given
    ) -> tuple[Array, Array, State]:
        """Output, joint angles and state; a recording is taken block by block, in each joint after joint.

        With contiguous columns a sum with one value per joint runs five times as fast.
        """
        x, stamp = np.asarray(x, dtype=float), np.asarray(stamp, dtype=float)
        if not len(x):
            raise ModelError("there is nothing to run: the signal has no samples")
        if not self.effects or len(x) == 1:
            return advance(np.ascontiguousarray(x), stamp, state, given)
        out, angles = np.empty_like(x), np.empty_like(x)
        for start in range(0, len(x), self._rows):
            rows = slice(start, start + self._rows)
            block = np.asfortranarray(x[rows])
            out[rows], angles[rows], state = advance(block, stamp[rows], state, given.part(rows))
        assert state is not None
        return out, angles, state

    def _look(self, stamp: Array, path: Array, last: Array | None, state: State | None, given: Given) -> Look:
        """What the effects see of the arm, at the time that counts for them; ``last``: the path before."""
        before = None if state is None or last is None else (state.stamp, last)
        look = Look(self.arm, stamp, path, before, given, state.swing if state else None, self.carried)
        if self.duration is not None:
            look.stamp, look.held = stamp * 0.0 + self.duration, True
        return look

    def _core(self) -> Core:
        nominal = self.arm.dead_band[None]
        return Core(nominal_width=nominal, width=nominal, wire=self.arm.wire)

    def _wire(self, x: Array, stamp: Array, state: State | None, given: Given) -> tuple[Array, Array, State]:
        """Joint reading, joint angle, state: passes until the joints agree on what they see of each other."""
        ratio, begun = self.arm.ratio, state.core if state else None
        if not self.effects:
            u, memory = SharpPlay().run(x, self.arm.dead_band[None], begun, ratio)
            return u, u, State(float(stamp[-1]), x[-1], u[-1], {}, memory)
        path = x * ratio
        now = self._look(stamp, path, state.x * ratio if state else None, state, given)
        now.see(x, path + self._deflection(stamp, state))
        old, new, passes, again = state.blocks if state else {}, Memory(), Passes(state), True
        while True:
            if again:
                u, memory = friction(x, now, self.order, self._core(), begun, old, new)
                again = "angles" in now.asked
                moved = now.swing_along(u)
            true = through(u, self.order.after, now, old, new)
            settled = "angles" not in now.asked or passes.agree(true, now.angles, moved if again else 0.0)
            now.see(x, true)
            if settled:
                break
        shown = through(true, self.order.sensor, now, old, new)
        leaving = drift(stamp, x, true, state, ratio)
        after = State(float(stamp[-1]), x[-1], true[-1], new, memory, leaving, passes.calm, now.swing)
        return shown, true, after

    def _wire_back(
        self, y: Array, stamp: Array, state: State | None, given: Given
    ) -> tuple[Array, Array, State]:
        """Gearbox angle, joint angle, state: passes until what depends on the gearbox agrees with it."""
        old, new, begun = (state.blocks, Memory(), state.core) if state else ({}, Memory(), None)
        now = self._look(stamp, y, state.angles if state else None, state, given)
        true = back(y, self._outer, now, old, new)
        now.follow(true)
        x = (true - self._deflection(stamp, state)) / self.arm.ratio
        stood, towards = (x[0], 0.0 * x[0]) if state is None else (state.x, true[0] - state.angles)
        crossing = Crossing(
            x[0], stood, towards * self.arm.ratio, state.slope if state else None, AGREED_BACK
        )
        now.winds(crossing.at[None], stood)
        now.see(x, true)
        inside, inner = self._known_back(true, now, old, new)
        passes, again = Passes(state, AGREED_BACK), True
        while True:
            if again:
                u, memory = self._friction_back(inside, inner, now, begun, old, new)
                again = not now.asked.isdisjoint(MOTOR)
            better = back(u, self.order.path, now, old, new) / self.arm.ratio
            if "winding" in now.asked:
                if len(x) > 1:
                    return self._row_by_row(y, stamp, state, given)
                if not crossing.found(better[0]):
                    now.winds(crossing.at[None], stood)
                    continue
            if "gearbox" not in now.asked or passes.agree(better, x):
                break
            x = better
            now.see(x, true)
            crossing.anew()
        x, leaving = better, drift(stamp, better, true, state, self.arm.ratio)
        seen = passes.calm, now.swing, crossing.slope
        return x, true, State(float(stamp[-1]), x[-1], true[-1], new, memory, leaving, *seen)

    def _row_by_row(
        self, y: Array, stamp: Array, state: State | None, given: Given
    ) -> tuple[Array, Array, State]:
        """The same where a gearbox's speed counts, which hangs on where it stood before."""
        x, true = np.empty_like(y), np.empty_like(y)
        for k in range(len(y)):
            row = slice(k, k + 1)
            x[row], true[row], state = self._wire_back(y[row], stamp[row], state, given)
        assert state is not None
        return x, true, state

    def _known_back(self, true: Array, now: Look, old: Memory, new: Memory) -> tuple[Array, list[Effect]]:
        """The joints' angles as far back as nothing depends on the gearbox yet, and the effects before
        that.
        """
        inner = list(self._inner)
        while inner:
            further = back(true, inner[-1:], now, old, new)
            if not now.asked.isdisjoint(MOTOR):
                break
            true = further
            inner.pop()
        return true, inner

    def _friction_back(
        self, y: Array, inner: list[Effect], now: Look, begun: Any, old: Memory, new: Memory
    ) -> tuple[Array, Any]:
        """What the wire takes in for ``y`` to come out of ``inner``, and the friction element's memory."""
        core = self._core()
        adjusted(core, self.order, now, old, new)
        u = back(y, inner, now, old, new)
        out, memory = (core.rounding or SharpPlay()).invert(u, core.width, begun)
        return out - core.middle, memory

    def _deflection(self, stamp: Array, state: State | None) -> Array | float:
        """A first guess of how far the joints are from where the gearbox alone would have them."""
        if state is None:
            return 0.0
        ahead = min(stamp[0] - state.stamp, AHEAD) if len(stamp) == 1 else 0.0
        return np.asarray(state.angles - state.x * self.arm.ratio + state.drift * ahead)

    def _servo(self, x: Array, stamp: Array, state: State | None, given: Given) -> tuple[Array, Array, State]:
        """Gearbox angle (twice) and state: passes until load and gearbox angle agree."""
        at_joints = self.arm.driven
        past, asked, start, hung = state.core if state else (stamp[:0], x[:0], fresh(x[0]), None)
        old, new, last = state.blocks if state else {}, Memory(), at_joints(state.x) if state else None
        phi, passes, settled = np.broadcast_to(start[0], x.shape), Passes(state), False
        if self.order.path:
            x = through(x, self.order.path, self._look(stamp, at_joints(phi), last, state, given), old, new)
        stamps, setpoints = np.concatenate([past, stamp]), np.ascontiguousarray(np.concatenate([asked, x]))
        while not settled:
            now = self._look(stamp, at_joints(phi), last, state, given)
            angles, hangs = self._hanging(phi, stamp, hung, given)
            now.see(phi, angles)
            better, after = run_servo(servo_core(self.arm, self.effects, now), now, setpoints, stamps, start)
            settled = not (now.asked or now.has_told("speed")) or passes.agree(better, phi)
            phi = better
        out, behind = phi, self.order.after + self.order.sensor
        if behind or now.swing is not None:
            now = self._look(stamp, at_joints(phi), last, state, given)
            now.see(phi, self._hanging(phi, stamp, hung, given)[0])
            out = through(phi, behind, now, {}, {})
        kept = max(int(stamps.searchsorted(stamps[-1] - REMEMBERED)) - 1, 0)
        core = stamps[kept:], setpoints[kept:], after, hangs
        return out, phi, State(float(stamp[-1]), phi[-1], phi[-1], new, core, 0.0, passes.calm, now.swing)

    def _hanging(
        self, phi: Array, stamp: Array, state: State | None, given: Given
    ) -> tuple[Array, State | None]:
        """Where the joints (n, joints) are that hang on gearboxes at ``phi``, and their wires' state."""
        if self.wires is None:
            return self.arm.driven(phi), None
        led = self.wires._led(phi, None, stamp, state, given.resistance)
        return self.wires._wire(*led)[1:]
