"""The position loop of the servo has an integral part."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter

WOUND = 100.0  # rad/s: more than any error asks for


class IntegralAction(Effect):
    """v_ref = clip(Kp e + ki sum, -v_max, v_max), sum' = e, but for errors that lead further beyond v_max, or
    what may wind up past it.
    """

    id = "integral_action"
    sizes = ("ki",)
    stage, place, regime = "servo", 100, "high_speed"
    signature = (
        "At a constant speed the gearbox catches up with its setpoint little by little, and after each stop "
        "it comes back from beyond it as slowly."
    )
    source = (
        "PI and PID position loops, such as those of ros2_control and hobby servos; ki = Kp / Ti, Ti being "
        "the integral or reset time."
    )
    parameters = (
        Parameter(
            "ki",
            "1/s^2",
            (0.0, 1e5),
            "gain of the integral part, Kp over the integral time",
            typical=5.0,
            shared=True,
            scan=(5.0, 50.0),
        ),
        Parameter(
            "windup",
            "rad/s",
            (0.0, 1e4),
            "speed that it asks for beyond the top speed until it sums up no further",
            typical=1.0,
            shared=True,
            scan=(1.0, WOUND),
            optional=True,
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = True
    changes = "ki"
    compensable = False
    confused_with = (
        (
            "speed_feedforward",
            "move at a constant speed: what is fed forward acts at once, a sum late",
        ),
        ("servo_bandwidth", "move at a constant speed: a higher gain leaves an error that stays"),
        ("velocity_loop", "stop after a long move: a slow velocity loop comes back at once"),
    )

    @classmethod
    def options(cls, form: str) -> tuple[dict[str, float], ...]:
        return ({}, {"windup": WOUND})  # a drive that winds up without end is far from one that does not

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        own, windup = cls.parameters
        return (cls.of_each()[0] if form == cls.apart else own, windup)

    @classmethod
    def changed(cls, number: Any, values: Mapping[str, Any]) -> Any:
        return number + np.asarray(values.get("ki", 0.0), dtype=float)

    def adjust(self, core: Core, now: Now) -> None:
        core.ki = core.ki + self["ki"]
        core.windup = core.windup + self["windup"]
