"""Setpoint to gearbox angle, as a stage to be diagnosed."""

from __future__ import annotations

import numpy as np

from trunk_ros.chain import run_servo
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.noise import Noise
from trunk_ros.diagnosis.hypothesis import Hypothesis, payload_of
from trunk_ros.diagnosis.stage import STANDING, Sight, Stage


class ServoStage(Stage):
    """Setpoint to gearbox angle."""

    name = "servo"

    def noises(self, found: list[Noise]) -> list[Noise]:
        """At least the encoder's steps; what stands still between them says nothing of correlation."""
        return [Noise(max(n.std, self.resolution(c))) for c, n in enumerate(super().noises(found))]

    def least_rest(self, sight: Sight, column: int) -> float:
        return STANDING

    def resolution(self, column: int) -> float:
        return float(2 * np.pi / self.arm.counts_per_rev / np.sqrt(12.0))

    def predict(self, sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> Array:
        span = sight.views[index].span
        now, blocks = sight.now(index, column, payload_of(hypothesis)), hypothesis.bound(column)
        source = np.ascontiguousarray(span.source[:, column : column + 1])
        begin = now.gearbox[0, 0]
        start = np.array([[begin], [now.speed[0, 0] / now.ratio[0]], [begin]])
        out, _ = run_servo(self.arm, blocks, now, source, now.stamp, start)
        for block in blocks:
            if block.acts_at > block.CORE:
                out, _ = block.run(out, now, None)
        return np.asarray(out[span.rows, 0])
