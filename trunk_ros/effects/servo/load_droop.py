"""The load pulls the servo off its setpoint."""

from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter


class LoadDroop(Effect):
    """setpoint += gain tau."""

    id = "load_droop"
    stage, place, regime = "servo", 100, "posture"
    signature = "The gearbox stands off its setpoint in proportion to the weight on the joint."
    source = "Proportional loop without integral part: standing error = moment over loop stiffness."
    parameters = (
        Parameter("gain", "rad/(N*m)", (-5.0, 5.0), "standing error per moment", typical=1e-3, shared=True),
    )
    needs = ("load",)
    everywhere = True

    def adjust(self, core: Core, now: Now) -> None:
        core.pull = core.pull + self["gain"] * now.load
