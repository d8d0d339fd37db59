"""The wire slips on its wheel: the zero jumps at one moment."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter

RISE = 0.02  # s, so that a fit can move the onset
MOMENTS = 80  # of a recording, in which a jump is looked for
LIKELY = 6  # of them that a fit may start from
NEAR = 1.0  # s before and after a jump by which it shows where other things move the mean as well


class WireSlip(Effect):
    """u += step from the onset on."""

    id = "wire_slip"
    stage, place, regime = "wire", 50, "time"
    signature = "The residual's mean jumps at one moment and stays there."
    source = (
        "Euler-Eytelwein: beyond exp(mu alpha) the wire slides on its wheel at once and does not come back."
    )
    parameters = (
        Parameter("step", "rad", (-0.5, 0.5), "jump of the zero", typical=1e-3),
        Parameter("onset", "s", (0.0, 1e6), "moment of the jump", typical=2.0, moment=True),
    )
    imitated_by = ("wrap",)
    confused_with = (
        ("thermal_drift", "record longer: a drift goes on"),
        ("zero_offset", "look at the start, while the joint moves: before a slip its zero was right"),
        ("unknown_jumps", "record longer: a slipped wire does not come back"),
    )

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._jump(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._jump(now), None

    def _jump(self, now: Now) -> Array:
        risen = np.minimum(np.maximum((now.stamp[:, None] - self["onset"]) / RISE + 0.5, 0.0), 1.0)
        return np.asarray(self["step"] * risen)

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Seen before and after."""
        return bool(np.all((now.stamp[0] < self["onset"]) & (self["onset"] < now.stamp[-1])))

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        if parameter.name != "onset":
            return super().grid(parameter, now, column, rest)
        span = now.stamp[-1] - now.stamp[0]
        moments = now.stamp[0] + span * np.linspace(0.04, 0.97, MOMENTS)
        if rest is None:
            return tuple(moments.tolist())
        likely = {k for reach in (NEAR, np.inf) for k in _steepest(now.stamp, rest, moments, reach)}
        return tuple(moments[sorted(likely)].tolist())


def _steepest(stamp: Array, rest: Array, moments: Array, reach: float) -> list[int]:
    """At which of the ``moments`` the mean of ``rest`` (n,) jumps more than around them, the most first,
    by what that explains of so many seconds before and after.
    """
    sums = np.concatenate([[0.0], np.cumsum(rest)])
    low, middle, high = (
        np.searchsorted(stamp, np.clip(t, stamp[0], stamp[-1]))
        for t in (moments - reach, moments, moments + reach)
    )
    before, after = np.maximum(middle - low, 1), np.maximum(high - middle, 1)
    jump = (sums[high] - sums[middle]) / after - (sums[middle] - sums[low]) / before
    gain = np.pad(jump**2 * before * after / (before + after), 1)
    peaks = np.flatnonzero((gain[1:-1] >= gain[:-2]) & (gain[1:-1] > gain[2:]))
    likeliest = np.argsort(-gain[1 + peaks], kind="stable")[:LIKELY]
    return [int(k) for k in peaks[likeliest]]
