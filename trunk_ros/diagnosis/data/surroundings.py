"""What the effects on a joint see of the arm during a recording."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.align import Span
from trunk_ros.effects.effect import Now


@dataclass
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

    def only(self, rows: np.ndarray) -> View:
        """The same with these rows (n,) of the target alone counting."""
        valid = self.span.valid & rows[:, None]
        return replace(self, span=replace(self.span, valid=valid), follows=following(valid))

    def now(self, arm: Arm, column: int, payload: float) -> Now:
        """The surroundings of one joint, (m, 1) each."""

        def cut(values: Array) -> Array:
            return np.ascontiguousarray(values[:, column : column + 1])

        ratio = arm.ratio[column : column + 1]
        load = cut(self.load) + payload * cut(self.lever) if payload else cut(self.load)
        return Now(
            self.span.grid,
            self.dt,
            cut(self.span.gearbox),
            cut(self.span.velocity) * ratio,
            load,
            self.angles,
            self.wires,
            self.span.joints,
            ratio,
            speeds=self.speeds,
            columns=(column,),
            arm=replace(arm, payload=arm.payload + payload) if payload else arm,
        )


def following(valid: np.ndarray) -> np.ndarray:
    """(n, joints): where the sample before counts as well."""
    out = np.zeros_like(valid)
    out[1:] = valid[1:] & valid[:-1]
    return out


def first(now: Now, steps: int) -> Now:
    """The surroundings of the first steps."""
    whole = ("joints", "ratio", "held", "columns", "arm")
    return replace(now, **{f.name: getattr(now, f.name)[:steps] for f in fields(now) if f.name not in whole})
