"""The joint meets an obstacle."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.levels import HALF, HARDLY
from trunk_ros.parameter import Parameter

FREE = 100.0  # rad: no stop
LEVELS = (0.15, 0.35, 0.6, 0.75, 0.85, 0.92, 0.97)  # of the samples that a fit starts from as free
DEPTHS = (0.03, 0.01, 0.003, 0.001)  # of the motion that a fit starts from as beyond
YIELDING = 2.0 / 3.0  # share of the motion into it that goes on: of what is half as stiff as the wire


class HardStop(Effect):
    """theta = clip(p, lower, upper) + give (p - clip(p, lower, upper))."""

    id = "hard_stop"
    stage, place, regime = "wire", 600, "posture"
    begins = True
    signature = "Past one angle the joint stays where it is, and the residual grows as the gearbox goes on."
    source = "Unilateral contact, rigid or yielding."
    forms = ("upper", "lower")
    parameters = (
        Parameter("upper", "rad", (-FREE, FREE), "largest angle reached", typical=0.01, null=FREE),
        Parameter("lower", "rad", (-FREE, FREE), "smallest angle reached", typical=-0.01, null=-FREE),
        Parameter(
            "give",
            "1",
            (0.0, 0.95),
            "share of the motion into the obstacle that goes on",
            typical=0.1,
            gone=1.0,
        ),
    )
    confused_with = (("ratio_error", "move within the free range: there a stop shows nothing"),)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        free = np.minimum(np.maximum(x, self["lower"]), self["upper"])
        return free + self["give"] * (x - free), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        """Up to the stop and no further, also where it yields: no wire is pulled harder into an obstacle."""
        return np.minimum(np.maximum(y, self["lower"]), self["upper"]), None

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Met within the motion, and in its way; of what is met most of the time hardly anything goes on into
        it: or it is no more than another ratio and zero.
        """
        u = now.gearbox * now.ratio
        met = u > self["upper"] if self.form == "upper" else u < self["lower"]
        gives = YIELDING if met.mean() < HALF else HARDLY
        return bool(0.0 < met.mean() < 1.0 and np.all(self["give"] < gives))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        bound, give = cls.parameters[cls.forms.index(form)], cls.parameters[2]
        return bound, give

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        u = now.gearbox[:, column] * now.ratio[column]
        if parameter.name == "give":
            return (0.0,)
        low, high = float(u.min()), float(u.max())
        depth = np.array(DEPTHS) * (high - low)
        if parameter.name == "upper":
            return (*np.quantile(u, LEVELS), *(high - depth))
        return (*np.quantile(u, 1.0 - np.array(LEVELS)), *(low + depth))
