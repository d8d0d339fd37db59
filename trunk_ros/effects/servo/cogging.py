"""Periodic position error over the shaft angle."""

from collections.abc import Mapping

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.periods import periods, positive
from trunk_ros.parameter import Parameter

MOST_CYCLES = 200.0
STEEPEST = 0.6  # of the angle: beyond 1 the shaft would snap from tooth to tooth


class Cogging(Effect):
    """setpoint += amplitude sin(cycles_per_rev phi + phase)."""

    id = "cogging"
    sizes = ("amplitude",)
    stage, place, regime = "servo", 100, "posture"
    signature = "The gearbox's error swings periodically over its own angle, moving or not."
    source = (
        "Hanselman, Brushless Permanent Magnet Motor Design (2003), ch. 3: "
        "cogging torque over the pole pitch."
    )
    parameters = (
        Parameter("amplitude", "rad", (0.0, 0.2), "size of the swing", typical=2e-4, shared=True),
        Parameter(
            "cycles_per_rev",
            "1",
            (2.0, MOST_CYCLES),
            "periods per turn",
            typical=24.0,
            null=24.0,
            shared=True,
            slide="1/(2 pi m)",
        ),
        Parameter(
            "phase",
            "rad",
            (-10.0, 10.0),
            "phase at motor-side angle 0",
            typical=1.0,
            scan=(0.0, 1.571, 3.142, 4.712),
            slide="rad",
            periodic=True,
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = begins = True
    compensable = False
    confused_with = (
        ("load_droop", "turn one joint alone over its whole range: a cogging comes back many times"),
        ("unknown_dead_zone", "approach one setpoint from both sides: a dead zone changes its sign"),
    )

    @classmethod
    def turning(cls, form: str) -> Mapping[str, tuple[str, float]]:
        return {"phase": ("cycles_per_rev", 1.0)}

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        if parameter.name != "cycles_per_rev" or rest is None:
            return super().grid(parameter, now, column, rest)
        return periods(now.gearbox[:, column], rest, *parameter.bounds, most=1) or (parameter.typical,)

    def credible(self, now: Now, beside: bool = False) -> bool:
        """A swing that a servo can be held in, of a period that is not the shortest looked for."""
        slope = self["amplitude"] * self["cycles_per_rev"]
        return bool(np.all((slope < STEEPEST) & (self["cycles_per_rev"] < 0.95 * MOST_CYCLES)))

    @classmethod
    def plain(cls, values: dict[str, float]) -> dict[str, float]:
        return positive(values, "amplitude", "phase")

    def adjust(self, core: Core, now: Now) -> None:
        high, *teeth = (np.broadcast_to(self[p.name], now.ratio.shape) for p in self.parameters)
        core.cogging, core.teeth = high[None], np.stack(teeth)[:, None]
