"""The servo stands off its setpoint by a constant."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import ANY, Parameter


class ServoOffset(Effect):
    """setpoint += offset, which the loop then goes to."""

    id = "servo_offset"
    sizes = ("offset",)
    stage, place, regime = "servo", 100, "always"
    signature = "The gearbox stands beside every setpoint by the same amount."
    source = "Homing: the zero of the setpoints is not that of the motor's encoder."
    parameters = (Parameter("offset", "rad", ANY, "gearbox angle at a setpoint of zero", typical=1e-3),)
    everywhere = True
    confused_with = (
        ("load_droop", "turn the joint so that its load changes sign: an offset stays"),
        ("unknown_dead_zone", "approach one setpoint from both sides: a dead zone changes its sign"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.pull = core.pull + self["offset"]
