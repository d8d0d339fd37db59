"""Setpoint to gearbox angle, as a stage to be diagnosed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trunk_ros.chain import Chain, run_servo
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.noise import Noise
from trunk_ros.diagnosis.data.seen import joined
from trunk_ros.diagnosis.data.span import Span
from trunk_ros.diagnosis.data.surroundings import View
from trunk_ros.diagnosis.hypothesis import Hypothesis, payload_of
from trunk_ros.diagnosis.side_by_side import Seen, bind_together
from trunk_ros.diagnosis.stage import STANDING, Sight, Stage
from trunk_ros.effects.servo.loop import STEP, fresh
from trunk_ros.model import Model


class ServoStage(Stage):
    """Setpoint to gearbox angle."""

    name = "servo"
    joint_by_joint = False
    ahead = STEP / 2.0

    def __init__(
        self,
        spans: Sequence[Span],
        model: Model,
        units: dict[str, str] | None = None,
        filled: Array | None = None,
    ):
        """``filled``: by how much (joints,) rad rms setpoints are off that nobody recorded."""
        super().__init__(spans, model, units)
        self.filled = np.zeros(len(self.joints)) if filled is None else filled

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
        own = [max(n.std, self.resolution(c)) for c, n in enumerate(super().noises(found))]
        return [Noise(float(np.hypot(*both))) for both in zip(own, self.filled, strict=True)]

    def least_rest(self, sight: Sight, column: int) -> float:
        return STANDING

    def resolution(self, column: int) -> float:
        return float(2 * np.pi / self.arm.counts_per_rev / np.sqrt(12.0))

    def predict(self, sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> Array:
        return self._predict_alike(sight, index, [(hypothesis, column)])[0]

    def _predict_alike(self, sight: Sight, index: int, pairs: Sequence[Seen]) -> Sequence[Array]:
        span, columns = sight.views[index].span, [column for _, column in pairs]
        payload, blocks = payload_of(pairs[0][0]), bind_together(pairs)
        now = joined([sight.now(index, column, payload) for column in columns])
        source = np.ascontiguousarray(span.source[:, columns])
        start = fresh(now.gearbox[0], now.speed[0] / now.ratio)
        anew = np.searchsorted(now.stamp, span.anew)
        out, _ = run_servo(self.arm, blocks, now, source, now.stamp, start, anew)
        for block in blocks:
            if block.acts_at > block.CORE:
                out, _ = block.run(out, now, None)
        return [span.measured(each) for each in out.T]
