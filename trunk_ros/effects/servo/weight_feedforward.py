"""The drive feeds forward a torque by the joint's angle, as against its weight, beside its loop's own."""

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.periods import positive
from trunk_ros.parameter import Parameter

STEEPEST = 0.6  # of the angle: beyond 1 the shaft would run away from its setpoint


class WeightFeedforward(Effect):
    """setpoint += amplitude sin(ratio phi + phase): the torque that the drive adds, over its stiffness."""

    id = "weight_feedforward"
    sizes = ("amplitude",)
    stage, place, regime = "servo", 100, "posture"
    signature = (
        "Beside what its recorded torque makes it yield, the gearbox's error goes with the sine of its angle."
    )
    source = (
        "An impedance servo pulls tau = kp (q* - q) + tau_ff(q): of the recorded torque only tau - tau_ff "
        "shows as an error. A link's weight, and what is fed forward against it, goes with the sine of its "
        "angle."
    )
    parameters = (
        Parameter(
            "amplitude", "rad", (-3.0, 3.0), "largest torque fed forward, over the stiffness", typical=0.01
        ),
        Parameter(
            "phase",
            "rad",
            (-10.0, 10.0),
            "phase at joint angle 0",
            typical=1.0,
            scan=(0.0, 1.571),
            slide="rad",
            periodic=True,
        ),
    )
    needs = ("effort",)
    everywhere = begins = True
    compensable = False
    confused_with = (
        ("load_droop", "load the joint otherwise at one angle: what is fed forward stays as it is"),
        ("servo_offset", "turn the joint over more of its range: an offset stays"),
    )

    def credible(self, now: Now, beside: bool = False) -> bool:
        """A joint that still comes to where it is asked."""
        return bool(np.all(np.abs(self["amplitude"]) < STEEPEST))

    @classmethod
    def plain(cls, values: dict[str, float]) -> dict[str, float]:
        return positive(values, "amplitude", "phase")

    def adjust(self, core: Core, now: Now) -> None:
        core.pull = core.pull + self["amplitude"] * np.sin(now.ratio * now.gearbox + self["phase"])
