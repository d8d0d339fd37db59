"""The zero drifts slowly: with time, with the distance that the joint travels, or as its motion heats it."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Motion, Now
from trunk_ros.effects.wire.travelled import SPEED, Travelled
from trunk_ros.parameter import Parameter

LASTS = ("exponential", "heated")
"""Forms that come to an end."""
BY = {"travel": "with the distance that the joint travels", "heated": "as the joint's motion heats it"}


class ThermalDrift(Travelled):
    """u += amplitude (1 - exp(-t/time_constant)), or rate t, or rate s/speed with the path s gone so far,
    which at a mean ``speed`` is the same as rate t; heated: amplitude lowpass(|s'|/speed), which at
    that speed is the same as the first, and cools in pauses.
    """

    id = "thermal_drift"
    stage, place, regime = "wire", 40, "time"
    signature = "The residual's mean wanders slowly in one direction in the course of the recording."
    source = (
        "Newton's law of cooling: an assembly nears its new temperature as "
        "exp(-t/time_constant); straight at first. With the path: an incremental encoder that loses "
        "counts in one direction, a wire that creeps over its wheel one way. heated: the power of "
        "steady friction goes with the speed."
    )
    forms = ("exponential", "straight", "travel", "heated")
    refined = ("travel", "heated")
    parameters = (
        Parameter("amplitude", "rad", (-0.2, 0.2), "drift after a long time", typical=1e-3),
        Parameter(
            "time_constant",
            "s",
            (3.0, 3000.0),
            "time to 63 % of the drift",
            typical=60.0,
            null=60.0,
            scale="log",
            scan=(10.0, 30.0, 90.0),
        ),
        Parameter("rate", "rad/s", (-0.01, 0.01), "speed of a straight drift", typical=1e-5),
        SPEED,
    )
    imitated_by = ("skew",)
    confused_with = (
        ("viscoelastic_creep", "hold at zero, then far from it: a drift does not care"),
        ("wire_slip", "record longer: a slip is over at once"),
    )

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        drift, state = self._drift(now, state)
        return x + drift, state

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        drift, state = self._drift(now, state)
        return y - drift, state

    def _drift(self, now: Now, state: Any) -> tuple[Array, Any]:
        t = now.stamp[:, None]
        if self.form == "travel" and not now.held:
            gone = now.travelled(state)
            return np.asarray(self["rate"] * gone / self["speed"]), gone[-1]
        if self.form == "heated" and not now.held:
            heat, state = self.heat(now, state)
            return self["amplitude"] * heat, state
        if self.form in LASTS:
            return np.asarray(-self["amplitude"] * np.expm1(-t / self["time_constant"])), None
        return np.asarray(self["rate"] * t), None

    def credible(self, now: Now, beside: bool = False) -> bool:
        """It is not over at once: or it is an offset."""
        share = self["time_constant"] / (now.stamp[-1] - now.stamp[0])
        return bool(self.form not in LASTS or np.all(share > 0.03))

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """Not by the distance or the motion where each stroke is like the last in a wide loop: there it grows
        with the angle, as a loop that is no parallelogram does.
        """
        return tuple(f for f in super().forms_shown(motion) if f not in cls.refined or not motion.wide_loop)

    @classmethod
    def title(cls, form: str | None = None) -> str:
        return super().title() if form is None else f"The zero drifts slowly {BY.get(form, 'with time')}"

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        amplitude, time_constant, rate, speed = cls.parameters
        own = {"straight": (rate,), "travel": (rate, speed), "heated": (amplitude, time_constant, speed)}
        return own.get(form, (amplitude, time_constant))
