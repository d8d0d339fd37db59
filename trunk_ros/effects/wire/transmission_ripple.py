"""A wheel out of round or out of centre."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Motion, Now
from trunk_ros.effects.periods import periods, positive
from trunk_ros.parameter import Parameter
from trunk_ros.sine import sines

LEAST = 1.05  # periods within the motion


class TransmissionRipple(Effect):
    """u += amplitude sin(cycles_per_rev phi + phase), with or without a second harmonic."""

    id = "transmission_ripple"
    stage, place, regime = "wire", 20, "posture"
    begins = True
    signature = "The residual swings periodically over the motor-side angle, the same in both directions."
    source = (
        "Tuttle & Seering (1996), IEEE T. Robotics Autom. 12(3): "
        "kinematic error as a sum of sinusoids of the shaft angle."
    )
    parameters = (
        Parameter("amplitude", "rad", (-0.2, 0.2), "size of the swing", typical=3e-4),
        Parameter(
            "cycles_per_rev",
            "1",
            (0.05, 120.0),
            "periods per turn of the gearbox shaft",
            typical=12.0,
            null=12.0,
        ),
        Parameter(
            "phase",
            "rad",
            (-10.0, 10.0),
            "phase at motor-side angle 0",
            typical=1.0,
            scan=(0.0, 0.785, 1.571, 2.356),
        ),
        Parameter("harmonic", "1", (-2.0, 2.0), "size at twice the periods over amplitude", typical=0.2),
        Parameter(
            "harmonic_phase",
            "rad",
            (-10.0, 10.0),
            "phase of it at motor-side angle 0",
            typical=1.0,
            scan=(0.0, 1.571),
        ),
    )
    forms = ("sine", "two_harmonics")
    refined = ("two_harmonics",)
    imitated_by = ("steps",)
    confused_with = (("ratio_error", "move over a wide range: a ripple turns back, a ratio error grows"),)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._ripple(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._ripple(now), None

    def _ripple(self, now: Now) -> Array:
        turn = self["cycles_per_rev"] * now.gearbox
        wave = sines(turn, self["phase"])
        if self.form == "two_harmonics":
            wave += self["harmonic"] * sines(2 * turn, self["harmonic_phase"])
        return np.asarray(self["amplitude"] * wave)

    def credible(self, now: Now, beside: bool = False) -> bool:
        """A good period has to lie within the motion, or it is no more than a bent curve."""
        if beside:
            return bool(np.all(self._periods(now) > LEAST))
        harmonic = (self.form == "two_harmonics") & (self["harmonic"] != 0.0)
        return bool(np.all(self._periods(now) > np.where(harmonic, 2.0, 1.6)))

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """None in a wide loop: a ripple is lost in its form, and can imitate it."""
        return () if motion.wide_loop else super().forms_shown(motion)

    def _periods(self, now: Now) -> Array:
        """How many lie within the motion, (columns,)."""
        return np.asarray(self["cycles_per_rev"] * np.ptp(now.gearbox, axis=0) / (2 * np.pi))

    @classmethod
    def plain(cls, values: dict[str, float]) -> dict[str, float]:
        out = positive(values, "amplitude", "phase")
        if "harmonic" not in values:
            return out
        side = np.sign(values["amplitude"]) or 1.0
        return positive({**out, "harmonic": side * values["harmonic"]}, "harmonic", "harmonic_phase")

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "two_harmonics" else cls.parameters[:3]

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        """Only ripples of which the motion spans a period can be told from a bent curve."""
        if parameter.name != "cycles_per_rev" or rest is None:
            return super().grid(parameter, now, column, rest)
        phi = now.gearbox[:, column]
        low = max(parameter.bounds[0], LEAST * 2 * np.pi / max(float(np.ptp(phi)), 1e-3))
        return periods(phi, rest, low, parameter.bounds[1])
