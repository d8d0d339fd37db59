"""A zero that jumps about for no reason that has a name."""

from functools import cached_property
from typing import ClassVar

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.curve import KNOTS, RANGE, VALUES, Curve
from trunk_ros.effects.effect import Now
from trunk_ros.parameter import Parameter

NEVER = 1e6  # s
MOMENTS = tuple(
    Parameter(
        f"moment_{k:02d}",
        "s",
        (0.0, NEVER),
        "when the level before gives way to this one",
        typical=1.0,
        measured=True,
        null=NEVER,
    )
    for k in range(1, KNOTS)
)


class UnknownJumps(Curve):
    """theta += value_k from moment_k on, until the next; t since the start of the recording."""

    id = "unknown_jumps"
    follows_readings = True
    linear = True
    stage = "wire"
    place = 255
    signature = "The residual's mean jumps between levels at moments that nothing in the motion predicts."
    parameters = (*RANGE, *VALUES, *MOMENTS)
    of = "the angle, by jumps,"
    confused_with: ClassVar[tuple[tuple[str, str], ...]] = (
        ("wire_slip", "record longer: a slipped wire does not come back"),
        ("unknown_slips", "stand still: what happens before the friction waits for a motion"),
    )

    @classmethod
    def bend(cls) -> Array:
        return np.empty((0, KNOTS))

    def _curve(self, now: Now) -> Array:
        out = np.zeros((len(now.stamp), len(self["low"])))
        for column, moments, levels in self._steps:
            out[:, column] = levels[moments.searchsorted(now.stamp, side="right")]
        return out

    @cached_property
    def _steps(self) -> list[tuple[int, Array, Array]]:
        """Column, moments and levels of each curve that there is."""
        moments, levels = (np.array([self[p.name] for p in some]) for some in (MOMENTS, VALUES))
        columns = np.flatnonzero(self["low"] < self["high"])
        return [(int(c), np.ascontiguousarray(moments[:, c]), levels[:, c]) for c in columns]
