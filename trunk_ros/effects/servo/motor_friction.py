"""Dry friction in the motor and its gear holds the shaft back."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class MotorFriction(Effect):
    """tau_v v' = v_ref - v - kp friction s, s in the sign of v: from -1 to 1 where the shaft stands."""

    id = "motor_friction"
    sizes = ("friction",)
    stage, place, regime = "servo", 100, "reversal"
    signature = "The gearbox is behind its setpoint by the same amount at any speed, and stops short of it."
    source = (
        "Coulomb friction against a loop without integral part: Armstrong et al. (1994), Automatica 30(7)."
    )
    parameters = (
        Parameter(
            "friction",
            "rad",
            (0.0, 0.5),
            "error of the setpoint that it holds: its torque over the loop's stiffness",
            typical=2e-3,
            shared=True,
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = begins = True
    compensable = False
    confused_with = (
        ("servo_delay", "move at two speeds: what a delay leaves grows with the speed"),
        ("unknown_dead_zone", "move at a constant speed: errors that a loop ignores do not hold it back"),
        (
            "load_droop",
            "lift and lower the same weight: friction of the wire is felt past its dead band alone",
        ),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.dry = core.dry + self["friction"]
