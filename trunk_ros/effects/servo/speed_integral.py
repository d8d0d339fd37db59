"""The loop of the servo's speed has an integral part."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class SpeedIntegral(Effect):
    """tau_v v' = v_ref + sum - v, sum' = rate (v_ref - v), but while the speed changes as fast as it may.

    What pulls at the motor is no part of v_ref: it is made up for.
    """

    id = "speed_integral"
    sizes = ("rate",)
    stage, place, regime = "servo", 100, "high_speed"
    signature = (
        "After each change of speed the gearbox overshoots, and comes back as the integral part forgets; at "
        "a constant speed nothing is left of it."
    )
    source = (
        "P-PI cascades, as in drives with a PI velocity controller (CiA 402; ODrive: vel_integrator_gain): "
        "rate = 1 / Tn, Tn being the reset time of the velocity controller."
    )
    parameters = (
        Parameter(
            "rate",
            "1/s",
            (0.0, 500.0),
            "how fast the velocity loop sums up its error, 1 / reset time",
            typical=5.0,
            shared=True,
            scan=(3.0, 15.0, 60.0),
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = True
    compensable = False
    confused_with = (
        ("velocity_loop", "ramp the setpoint: a slow velocity loop overshoots once and is done"),
        ("integral_action", "ramp the setpoint: an integral part of the position loop catches up with it"),
        ("speed_feedforward", "move at a constant speed: what is fed forward leaves less error"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.speed_ki = core.speed_ki + self["rate"]
