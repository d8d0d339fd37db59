"""What was wanted of the joints beside what came of it, and what slow feedback makes of the difference."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.effect_values import lateness
from trunk_ros.model import Model
from trunk_ros.nodes.control.goal import State
from trunk_ros.nodes.control.measured import Measured
from trunk_ros.nodes.control.past import Past
from trunk_ros.nodes.control.slow_feedback import Settings, SlowFeedback
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.trajectory import Array

SETTLE = 0.2  # s
SLOW = 0.1  # rad/s; a joint that was faster within SETTLE teaches nothing: lag and delay look like an offset


class Observation:
    """``strict``: time is simulated, see Newest. Times are ns of the node's clock."""

    def __init__(self, model: Model, strict: bool):
        self.measured = Measured(model, strict)
        self.use(model)

    def use(self, model: Model) -> None:
        """Another model: what was learnt about the last one is forgotten."""
        self.measured.use(model)
        self.delay = lateness(model.at_end().effects)
        self.feedback = SlowFeedback(len(model.arm.joints))
        self.past = Past()

    def remember(self, now: int, reference: Array, velocity: Array) -> None:
        """Note what is wanted (joints,) rad, rad/s."""
        self.past.add(now / SECOND, np.array([reference, velocity]))

    def lose_sight(self) -> None:
        """The motors fell silent: what they said before is not where the arm stands by then."""
        self.measured.gearbox.clear()

    def stands(self, now: int) -> Array | None:
        """Gearbox angle (joints,) rad, None while that of any joint is not known."""
        gearbox = self.measured.gearbox.at(now)
        known = gearbox is not None and np.isfinite(gearbox[1].position).all()
        return gearbox[1].position if known and gearbox is not None else None

    def compared(self, now: int, fresh: bool) -> tuple[int, State, State]:
        """Stamp of the newest sample, what was wanted then, and what it shows.

        ``fresh``: whether joint_states come.
        """
        stamp, actual = self.measured.state(now, fresh)
        return stamp, State(*self.past.at(stamp / SECOND)), actual

    def correction(
        self, now: int, fresh: bool, settings: Settings, reference: Array, limited: Any, dt: float
    ) -> Array:
        """What the slow feedback adds to the reference (joints,) rad; ``limited`` joints learn nothing."""
        if settings.gain == 0 and not self.feedback.trim.any():
            return self.feedback.trim
        error = None
        sample = self.measured.joints.at(now) if fresh else None
        if sample is not None:
            error = self.past.at(sample[0] / SECOND - self.delay)[0] - sample[1].position
        fast = np.abs(reference - self.past.at(now / SECOND - SETTLE)[0]) > SLOW * SETTLE
        return self.feedback.step(settings, reference, error, fast | limited, dt)
