"""The load, and the friction of the wire, pull the servo off its setpoint."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.now import borne
from trunk_ros.levels import ROWS
from trunk_ros.parameter import Parameter


class LoadDroop(Effect):
    """setpoint += gain tau - abs(gain) friction s, s from -1 to 1 being the place in the dead band; the share
    as_torque of it acts past the top speed that the position loop may ask for.
    """

    id = "load_droop"
    sizes = ("gain",)
    stage, place, regime = "servo", 100, "posture"
    signature = "The gearbox stands off its setpoint in proportion to the weight on the joint."
    source = "Proportional loop without integral part: standing error = moment over loop stiffness."
    forms = ("weight", "weight_and_friction", "apart")
    apart = "apart"
    parameters = (
        Parameter("gain", "rad/(N*m)", (-1e3, 1e3), "standing error per moment", typical=1e-3, shared=True),
        Parameter(
            "friction", "N*m", (0.0, 1e3), "dry friction that the motor pulls as well", typical=0.1,
            scan=(0.03, 0.1, 0.3),
        ),
        Parameter(
            "as_torque", "1", (0.0, 1.0), "share of it that acts past the speed limit, as a torque does",
            typical=1.0, shared=True, optional=True,
        ),
    )  # fmt: skip
    needs = ("load",)
    everywhere = begins = True

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        """Friction is of a size with what the arm is built for, on joints that bear little of it as well."""
        found = super().grid(parameter, now, column, rest)
        if parameter.shared:
            return found
        arm = now.arm if now.arm is not None and now.arm.has_load else None
        some = slice(None, None, max(len(now.load) // ROWS, 1))
        loads = now.load if arm is None else arm.load(now.angles[some])
        size = parameter.under(max(map(borne, loads.T)))
        return tuple(size * start for start in found)

    def adjust(self, core: Core, now: Now) -> None:
        core.load = core.load + self["gain"] * now.load
        core.torque = core.torque + self["as_torque"]
        if self.form == "weight_and_friction":
            core.rub = core.rub + np.abs(self["gain"]) * self["friction"]

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        gain, _, torque = cls.parameters
        if form == cls.apart:
            return (cls.of_each()[0], torque)
        return cls.parameters if form == "weight_and_friction" else (gain, torque)
