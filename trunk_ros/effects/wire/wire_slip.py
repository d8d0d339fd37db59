"""The wire slips on its wheel: the zero jumps at one moment."""

from functools import cache
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.lasting import shown_between
from trunk_ros.effects.moments import RISE
from trunk_ros.effects.now import Motion
from trunk_ros.parameter import LATER, UNTIL, Parameter

MOMENTS = 80  # parts of a recording, of each of which the steepest is looked at
LIKELY = 6  # of them that a fit may start from
NEAR = 1.0  # s before and after a jump by which it shows where other things move the mean as well


class WireSlip(Effect):
    """u += step from the onset on; where it slips again, by the difference to its next size."""

    id = "wire_slip"
    sizes = ("step",)
    stage, place, regime = "wire", 50, "time"
    exact = True
    signature = "The residual's mean jumps at one moment and stays there."
    source = (
        "Euler-Eytelwein: beyond exp(mu alpha) the wire slides on its wheel at once and does not come back."
    )
    parameters = (
        Parameter("step", "rad", (-0.5, 0.5), "jump of the zero", typical=1e-3),
        Parameter("onset", "s", (0.0, 1e6), "moment of the jump", typical=2.0, moment=True),
    )
    imitated_by = ("knocks", "wrap")
    confused_with = (
        ("thermal_drift", "record longer: a drift goes on"),
        ("zero_offset", "look at the start, while the joint moves: before a slip its zero was right"),
        ("unknown_jumps", "record longer: a slipped wire does not come back"),
    )

    @classmethod
    @cache
    def moments(cls) -> tuple[Parameter, ...]:
        """It has begun at its onset; it may go on."""
        return (UNTIL, *LATER)

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """Nothing else jumps at once, so that joints that rest on their way need not come back to show it."""
        return cls.forms if motion.one_way and motion.holds else super().forms_shown(motion)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._jump(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._jump(now), None

    def _jump(self, now: Now) -> Array:
        risen = np.minimum(np.maximum((now.stamp[:, None] - self["onset"]) / RISE + 0.5, 0.0), 1.0)
        return np.asarray(self["step"] * risen)

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Seen before and after."""
        first, last = shown_between(now.stamp)
        return bool(np.all((first <= self["onset"]) & (self["onset"] <= last)))

    def starts(self, now: Now, column: int, rest: Array | None = None) -> list[dict[str, Any]]:
        """The likeliest jumps, each as large as it shows at once and in the long run: what is within the dead
        band shows in full once the joint moves.
        """
        ends = shown_between(now.stamp)
        if rest is None:
            step = self.parameters[0].typical
            return [{"step": step, "onset": at} for at in np.linspace(*ends, MOMENTS).tolist()]
        jumps = [_jumps(now.stamp, rest, ends, reach) for reach in (NEAR, np.inf)]
        likely = sorted({k for jump, gain in jumps for k in _peaks(gain)})
        at = _inside(now.stamp, ends)
        return [
            {"step": float(jump[k]), "onset": float(now.stamp[at[k] - 1 : at[k] + 1].mean())}
            for k in likely
            for jump, _ in jumps
            if jump[k]
        ]


def _inside(stamp: Array, ends: tuple[float, float]) -> np.ndarray:
    """(k,) samples between two ends [s], with one before each."""
    first, last = np.searchsorted(stamp, ends)
    return np.arange(max(int(first), 1), int(last))


def _jumps(stamp: Array, rest: Array, ends: tuple[float, float], reach: float) -> tuple[Array, Array]:
    """By how much the mean of ``rest`` (n,) jumps at each sample between two ``ends`` (s), by so many seconds
    before and after, and what that explains.
    """
    sums = np.concatenate([[0.0], np.cumsum(rest)])
    at = _inside(stamp, ends)
    low, high = (np.searchsorted(stamp, np.clip(stamp[at] + s * reach, *stamp[[0, -1]])) for s in (-1, 1))
    low, high = np.minimum(low, at - 1), np.maximum(high, at + 1)
    before, after = at - low, high - at
    jump = (sums[high] - sums[at]) / after - (sums[at] - sums[low]) / before
    return jump, jump**2 * before * after / (before + after)


def _peaks(gain: Array) -> list[int]:
    """The largest of ``gain`` (n,), each the best of its part and better than the parts around."""
    best = np.array(
        [k[np.argmax(gain[k])] for k in np.array_split(np.arange(len(gain)), MOMENTS) if len(k)], dtype=int
    )
    most = np.pad(gain[best], 1)
    peaks = best[(most[1:-1] >= most[:-2]) & (most[1:-1] > most[2:])]
    return [int(k) for k in peaks[np.argsort(-gain[peaks], kind="stable")[:LIKELY]]]
