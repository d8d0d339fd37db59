"""Gearbox to joint, and setpoint to gearbox, as problems to be diagnosed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.chain import Chain, run_servo, wire_pass
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.align import Span
from trunk_ros.diagnosis.data.noise import Noise
from trunk_ros.diagnosis.hypothesis import Explanation, payload_of
from trunk_ros.diagnosis.stage import Problem
from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.model import Model
from trunk_ros.resistance import loads
from trunk_ros.stage import Order, State, through
from trunk_ros.start import Driven, first_rows, history

CLOSE = 0.01  # of the motion: a change of the angles that coupling and load need not be computed again for


class WireProblem(Problem):
    """Gearbox angle to joint reading."""

    stage = "wire"

    def predict(self, index: int, explanation: Explanation, column: int) -> Array:
        view = self.views[index]
        now = self.now(index, column, payload_of(explanation))
        width = self.arm.dead_band[None, column : column + 1]
        blocks = explanation.bound(column)
        state = None
        if len(view.span.start[column]):
            until = int(view.span.rows[view.span.start[column][-1]]) + 1
            seen, one = (self.now(index, column, payload_of(explanation), steps) for steps in (until, 1))
            state = begun(seen, one, blocks, width, view.span, column)
        core = Core(nominal_width=width, width=width)
        shown, _, _ = wire_pass(now.gearbox, now, blocks, core, state)
        return self._besides(view.span, column, now, blocks, np.asarray(shown[view.span.rows, 0]))

    def _besides(self, span: Span, column: int, now: Now, blocks: list[Effect], shown: Array) -> Array:
        """The prediction (n,) with what went on besides, as far as the recording shows it."""
        for block in blocks:
            shapes = block.transients(now)
            if shapes is not None:
                shapes, valid = shapes[span.rows], span.valid[:, column]
                off = span.target[valid, column] - shown[valid]
                seen = shapes[valid]
                normal = seen.T @ seen + 1e-9 * len(seen) * np.eye(seen.shape[1])
                shown = shown + shapes @ np.linalg.solve(normal, seen.T @ off)
        return shown

    def look_again(self, explanation: Explanation) -> None:
        """Predicted angles of all joints, as a simulation with this explanation would have them."""
        model = Model(self.arm, explanation.model_effects(len(self.joints)))
        for view in self.views:
            span = view.span
            view.angles = Chain(model, "wire").angles(span.gearbox, span.grid, span.velocity, span.resistance)
            view.load, view.lever = loads(self.arm, view.angles, span.resistance)
        self.version = self._version()
        self._cache.clear()

    def settle(self, explanation: Explanation, seconds: float) -> bool:
        """Have recordings that stop to measure begin as an explanation says that their wires lay, going by the
        joint angles of the first ``seconds``; whether there is such a recording.
        """
        chain = Chain(Model(self.arm, explanation.model_effects(len(self.joints))), "wire")
        slow = [view for view in self.views if view.span.before and seconds > 0.0]
        for view in slow:
            span, before = view.span, view.span.before
            seen = first_rows(span.stamp, seconds)
            angles = np.where(span.valid, span.target, np.nan)[:seen]
            known = None if span.resistance is None else span.resistance.part(slice(before, None))
            driven = Driven(
                span.gearbox[before:], span.grid[before:], span.rows[:seen] - before, angles,
                span.velocity[before:], known,
            )  # fmt: skip
            path = span.gearbox.copy()
            path[:before] = path[before] + history(chain, driven) / self.arm.ratio
            view.span, view.wires = replace(span, source=path, gearbox=path), path * self.arm.ratio
        if slow:
            self.look_again(explanation)
        return bool(slow)

    def _version(self) -> int:
        """A number for the angles that are seen now, the same for angles that are nearly the same."""
        angles = [view.angles for view in self.views]
        for number, known in enumerate(self._known):
            if all(np.max(np.abs(a - b)) < CLOSE * np.ptp(a) for a, b in zip(angles, known, strict=True)):
                return number
        self._known.append(angles)
        return len(self._known) - 1


def begun(seen: Now, one: Now, blocks: list[Effect], width: Array, span: Span, column: int) -> State:
    """The state in which the friction element shows what was measured while the joint stood, as far as its
    play lets it. ``seen``: the surroundings until then, ``one``: at the first step.
    """
    rows, core = span.start[column], Core(nominal_width=width, width=width)
    shown, true, _ = wire_pass(seen.gearbox, seen, blocks, core, None)
    off = np.median(span.target[rows, column] - shown[span.rows[rows], 0])
    element = core.rounding or SharpPlay()
    u = through(one.gearbox * one.ratio, Order.of(blocks).path, one, {}, {})
    _, memory = element.run(np.vstack([u + off, u]), core.width[:1], None)
    return State(float(one.stamp[0]), one.gearbox[0], true[0], {}, memory)


class ServoProblem(Problem):
    """Setpoint to gearbox angle."""

    stage = "servo"

    def estimate_noise(self, explanation: Explanation) -> None:
        """At least the encoder's steps; what stands still between them says nothing of correlation."""
        super().estimate_noise(explanation)
        self.noise = [Noise(max(noise.std, self.resolution(0))) for noise in self.noise]

    def rest(self, column: int) -> float:
        """A joint that stands shows one step of the encoder, up to three times its mean power."""
        return 3.0

    def resolution(self, column: int) -> float:
        return float(2 * np.pi / self.arm.counts_per_rev / np.sqrt(12.0))

    def predict(self, index: int, explanation: Explanation, column: int) -> Array:
        view = self.views[index]
        now = self.now(index, column, payload_of(explanation))
        source = np.ascontiguousarray(view.span.source[:, column : column + 1])
        start = np.array([[now.gearbox[0, 0]], [now.speed[0, 0] / now.ratio[0]]])
        out, _ = run_servo(self.arm, explanation.bound(column), now, source, now.stamp, start)
        for block in explanation.bound(column):
            if block.place > block.CORE:
                out, _ = block.run(out, now, None)
        return np.asarray(out[view.span.rows, 0])
