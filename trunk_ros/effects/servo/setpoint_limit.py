"""The drive clips its setpoints to a range of its own."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter

FREE = 1e4  # rad: no limit, also where a drum turns many times
STANDS = (1.0, 0.99, 0.9)  # quantiles of where a shaft was on that side: most of them where it stood


class SetpointLimit(Effect):
    """setpoint = clip(setpoint, lower, upper), the feedforward's as well."""

    id = "setpoint_limit"
    stage, place, regime = "servo", 100, "posture"
    scalable = False
    signature = "Past one angle the gearbox stays where it is while its setpoint goes on."
    source = "Software position limits of drives, such as object 0x607D of CiA 402."
    forms = ("upper", "lower", "both")
    refined = ("both",)
    parameters = (
        Parameter("upper", "rad", (-FREE, FREE), "largest setpoint that is taken", typical=0.01, null=FREE),
        Parameter(
            "lower", "rad", (-FREE, FREE), "smallest setpoint that is taken", typical=-0.01, null=-FREE
        ),
    )
    compensable = False
    confused_with = (
        ("velocity_saturation", "move slowly to and fro there: what is too slow comes after, a limit never"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.lowest = np.maximum(core.lowest, self["lower"])
        core.highest = np.minimum(core.highest, self["upper"])

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Within where the shaft went: a limit that it never came to is a guess."""
        low, high = now.gearbox.min(), now.gearbox.max()
        met = [low < self["upper"], self["upper"] < high + self._near(low, high)]
        met += [self["lower"] < high, self["lower"] > low - self._near(low, high)]
        asked = {"upper": met[:2], "lower": met[2:], "both": met}[self.form]
        return bool(np.all(asked))

    @staticmethod
    def _near(low: float, high: float) -> float:
        return 0.01 * (high - low)  # as a slow loop comes near to it

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "both" else (cls.parameters[cls.forms.index(form)],)

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        phi = now.gearbox[:, column]
        if parameter.name == "upper":
            return tuple(np.quantile(phi, STANDS).tolist())
        return tuple(np.quantile(phi, 1.0 - np.array(STANDS)).tolist())
