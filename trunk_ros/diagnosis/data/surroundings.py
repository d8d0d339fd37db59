"""What the effects on a joint see of the arm during a recording."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.align import Span
from trunk_ros.effects.effect import Now


@dataclass(frozen=True)
class View:
    """A span as the effects see it: what is known of the whole arm at each step of its grid."""

    span: Span
    dt: Array
    angles: Array
    load: Array
    lever: Array
    wires: Array
    speeds: Array
    follows: np.ndarray
    cuts: dict[int, tuple[Array, Array, Array, Array]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def only(self, rows: np.ndarray) -> View:
        """The same with these rows (n,) of the target alone counting."""
        valid = self.span.valid & rows[:, None]
        return replace(self, span=replace(self.span, valid=valid), follows=following(valid))

    def now(self, arm: Arm, column: int, payload: float) -> Now:
        """The surroundings of one joint, (m, 1) each."""
        gearbox, speed, load, lever = self._of(column)
        ratio = arm.ratio[column : column + 1]
        return Now(
            self.span.grid,
            self.dt,
            gearbox,
            speed * ratio,
            load + payload * lever if payload else load,
            self.angles,
            self.wires,
            self.span.joints,
            ratio,
            speeds=self.speeds,
            columns=(column,),
            arm=replace(arm, payload=arm.payload + payload) if payload else arm,
        )

    def _of(self, column: int) -> tuple[Array, Array, Array, Array]:
        """Gearbox angle, its speed, load and lever of one joint, (m, 1) each."""
        if column not in self.cuts:
            both = (self.span.gearbox, self.span.velocity, self.load, self.lever)
            gearbox, speed, load, lever = (np.ascontiguousarray(a[:, column : column + 1]) for a in both)
            self.cuts[column] = gearbox, speed, load, lever
        return self.cuts[column]


def following(valid: np.ndarray) -> np.ndarray:
    """(n, joints): where the sample before counts as well."""
    out = np.zeros_like(valid)
    out[1:] = valid[1:] & valid[:-1]
    return out


def at(now: Now, rows: np.ndarray) -> Now:
    """The surroundings at some steps (k,) alone, the time between them with them."""
    whole = ("joints", "ratio", "held", "columns", "arm", "dt")
    steps = {f.name: getattr(now, f.name)[rows] for f in fields(now) if f.name not in whole}
    return replace(now, **steps, dt=np.diff(steps["stamp"], prepend=steps["stamp"][:1]))
