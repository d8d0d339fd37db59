"""The setpoint that the loop goes to follows the one that was sent no faster than at some rate."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.now import View
from trunk_ros.effects.servo.velocity_saturation import speeds_seen
from trunk_ros.parameter import Parameter

UNLIMITED = 1e3  # rad/s
BEFORE = 50  # place of what acts on setpoints
DUE = 0.999  # of a period: stamps are rounded
SLOWEST = 0.2  # s between setpoints: who sends them more slowly stops to measure


class SetpointRate(Effect):
    """The loop goes to led, which moves to the setpoint at up to rate: all the time in a drive, by
    clip(setpoint - led, -rate dt, rate dt) with each setpoint where a controller before it limits them.
    """

    id = "setpoint_rate"
    stage, place, regime = "servo", 100, "high_speed"
    scalable = False
    signature = (
        "In fast moves the gearbox falls behind at a constant speed, and slows down before it gets there as "
        "after any move at that speed."
    )
    source = "Slew-rate limiters and profile generators of drives, such as object 0x6081 of CiA 402."
    parameters = (
        Parameter(
            "rate",
            "rad/s",
            (1e-3, UNLIMITED),
            "fastest that the drive moves its own setpoint",
            typical=0.5,
            null=UNLIMITED,
            scale="log",
        ),
    )
    forms = ("drive", "each_setpoint")
    everywhere = True
    view = View("time", window=6.0)
    compensable = False
    tried = False  # a top speed and a delay leave little more than one, and it little more than they do
    confused_with = (
        (
            "velocity_saturation",
            "step the setpoint by far: at the top speed the shaft goes on straight until just before it",
        ),
    )

    @property
    def acts_at(self) -> int:
        return self.place if self.form == "drive" else BEFORE

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        columns = x.shape[1]
        if state is None:
            begun = np.full(columns, now.stamp[0])
            state = np.stack([x[0], x[0], begun, begun, begun + np.nan])
        out, after = np.empty_like(x), state.copy()
        each_limited(x, now.stamp, self["rate"] + np.zeros(columns), after, out)
        return out, after

    def adjust(self, core: Core, now: Now) -> None:
        rate = np.where(self["rate"] < UNLIMITED, self["rate"], np.inf)
        core.quickest = np.minimum(core.quickest, rate)

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        return speeds_seen(now, column)


@compiled
def each_limited(x: Array, stamp: Array, rate: Array, state: Array, out: Array) -> None:
    """Setpoints ``x`` (n, columns) that stand in several rows, each limited when it came, and again after a
    period in which none did: the shortest that was seen between two that differ, or else with each row.
    ``state`` (5, columns): the last setpoint, what it was limited to, when, when another one came, and the
    period (NaN: none yet).
    """
    for j in range(x.shape[1]):
        last, led, at, came, period = state[0, j], state[1, j], state[2, j], state[3, j], state[4, j]
        for k in range(len(x)):
            since, new, seen = stamp[k] - at, x[k, j] != last, period == period
            if since > 0.0 and (new or not seen or since >= DUE * period):
                most = rate[j] * (max(since, period) if seen else since)
                led = min(max(x[k, j], led - most), led + most)
                at = stamp[k]
            if new:
                apart, came = stamp[k] - came, stamp[k]
                if 0.0 < apart < SLOWEST and not period < apart:
                    period = apart
            last = x[k, j]
            out[k, j] = led
        state[0, j], state[1, j], state[2, j], state[3, j], state[4, j] = last, led, at, came, period
