"""Setpoint to gearbox angle, as a stage to be diagnosed."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.data.noise import Noise
from trunk_ros.data.seen import joined, now_of
from trunk_ros.data.span import Span
from trunk_ros.data.surroundings import View
from trunk_ros.diagnosis.hypothesis import Hypothesis, payload_of
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.stages.side_by_side import Seen, alike, bind_together
from trunk_ros.diagnosis.stages.stage import STANDING, Sight, Stage
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.servo.loop import fresh
from trunk_ros.look import slope_of
from trunk_ros.model import Model
from trunk_ros.passes import Passes
from trunk_ros.servo_run import run_servo, servo_core, with_profiles, with_sums
from trunk_ros.stage import through

LEFT_BY_LOOP = "what remains once the servo's loop is identified"


class ServoStage(Stage):
    """Setpoint to gearbox angle."""

    name = "servo"
    joint_by_joint = False
    ahead = STEP / 2.0
    least_rest = STANDING

    def __init__(
        self,
        spans: Sequence[Span],
        model: Model,
        units: dict[str, str] | None = None,
        filled: Array | None = None,
        loop_found: bool = False,
    ):
        """``filled``: by how much (joints,) rad rms setpoints are off that nobody recorded. ``loop_found``:
        the model's servos were found in these spans beforehand.
        """
        super().__init__(spans, model, units)
        self.filled = np.zeros(len(self.joints)) if filled is None else filled
        self.whole = LEFT_BY_LOOP if loop_found else self.whole
        self.tried: Array | None = None

    def trying(self, numbers: Array) -> ServoStage:
        """The same recordings, each prediction that is asked for at once of another servo, with ``numbers``
        (5, predictions) as in SERVO_OF_EACH.
        """
        other = copy(self)
        other.tried = numbers
        return other

    def predict_each(self, sight: Sight, index: int, pairs: Sequence[Seen]) -> list[Array]:
        if self.tried is None:
            return super().predict_each(sight, index, pairs)
        out: dict[int, Array] = {}
        for same in alike(pairs, self.joint_by_joint):
            seen = self.trying(self.tried[:, same])._predict_alike(sight, index, [pairs[k] for k in same])
            out |= zip(same, seen, strict=True)
        return [out[k] for k in range(len(pairs))]

    def _view(self, span: Span) -> View:
        """The joints are where their wires take them, not just where the gearboxes are."""
        view, wires = super()._view(span), Chain(self.model.only(self.joints), "wire")
        if not wires.effects:
            return view
        return view.turned(wires.angles(span.gearbox, span.grid, span.velocity, span.resistance))

    def noises(self, found: list[Noise]) -> list[Noise]:
        """At least the encoder's steps; what stands still between them says nothing of correlation. Setpoints
        that nobody recorded are known no better.
        """
        own = super().noises(found)
        return [Noise(float(np.hypot(n.std, filled))) for n, filled in zip(own, self.filled, strict=True)]

    def resolution(self, hypothesis: Hypothesis, column: int) -> float:
        return float(self.steps[column])

    def predict(self, sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> Array:
        return self._predict_alike(sight, index, [(hypothesis, column)])[0]

    def _predict_alike(self, sight: Sight, index: int, pairs: Sequence[Seen]) -> Sequence[Array]:
        view = sight.views[index]
        columns, payload = [column for _, column in pairs], payload_of(pairs[0][0])
        now = joined([sight.now(index, column, payload) for column in columns])
        out, blocks = self._run(view.span, now, pairs)
        for block in blocks:
            if block.acts_at > block.CORE:
                out, _ = block.run(out, now, None)
        return [view.span.measured(each) for each in out.T]

    def _run(self, span: Span, now: Now, pairs: Sequence[Seen]) -> tuple[Array, list[Effect]]:
        """Gearbox angles (m, pairs) that hypotheses which are alike lead to, and their blocks."""
        blocks = bind_together(pairs)
        core = servo_core(self.arm, blocks, now, self.tried)
        asked = span.source[:, [column for _, column in pairs]]
        before = [block for block in blocks if block.acts_at < block.CORE]
        source = np.ascontiguousarray(through(asked, before, now, {}, {}))
        start = fresh(now.gearbox[0], now.speed[0] / now.ratio)
        if np.isfinite(core.ramp).any():
            start = with_profiles(core, now, source, start)
        if core.ki.any():
            start = with_sums(core, now, source, start)
        anew = np.searchsorted(now.stamp, span.anew)
        return run_servo(core, now, source, now.stamp, start, anew)[0], blocks

    def free(self, sight: Sight, hypothesis: Hypothesis) -> tuple[View, ...]:
        if not any(hypothesis.on(column) for column in range(len(self.joints))):
            return sight.views
        seen = tuple(self._free(view, hypothesis, sight.work) for view in sight.views)
        same = all(before is after for before, after in zip(sight.views, seen, strict=True))
        return sight.views if same else seen

    def _free(self, view: View, hypothesis: Hypothesis, work: Work) -> View:
        """The view with gearboxes where a hypothesis takes them that goes by where they stand; the same where
        it does not.
        """
        passes, led = Passes(None), self._led(view, hypothesis)
        seen, measured = self._at(view, led), led
        while not passes.agree(better := self._led(seen, hypothesis), led):
            work.done += better.size
            led, seen = better, self._at(view, better)
        return view if np.array_equal(better, measured) else seen

    def _led(self, view: View, hypothesis: Hypothesis) -> Array:
        """(m, joints) gearbox angles, of all joints, by what there is to see in a view."""
        payload, pairs = payload_of(hypothesis), [(hypothesis, c) for c in range(len(self.joints))]
        out = np.empty_like(view.span.gearbox)
        for same in alike(pairs, self.joint_by_joint):
            now = joined([now_of(view, self.arm, column, payload) for column in same])
            out[:, same] = self._run(view.span, now, [pairs[column] for column in same])[0]
        return out

    def _at(self, view: View, gearbox: Array) -> View:
        """The view with gearboxes at other angles (m, joints), but where loops begin anew from their
        readings.
        """
        span, gearbox = view.span, gearbox.copy()
        velocity = slope_of(gearbox, view.dt, gearbox[0])
        read = [0, *np.searchsorted(span.grid, span.anew)]
        gearbox[read], velocity[read] = span.gearbox[read], span.velocity[read]
        other = self._view(replace(span, gearbox=gearbox, velocity=velocity))
        vars(other)["columns"] = view.columns  # how loud a sensor is goes by how fast it was
        return other
