"""What the effects on a joint see of the arm during a recording."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array, compiled
from trunk_ros.data.sensing.hum import Hum
from trunk_ros.data.span import Span, in_one_piece
from trunk_ros.effects.moments import NOTHING, Payload
from trunk_ros.effects.now import Made
from trunk_ros.machine import CELLS, make_room, pieces, precision

WIRES = "wires", 0, 0


class Column(NamedTuple):
    """One joint's measured values (n,), where they count (n,), where the one before counts as well (n,), and
    the speed (n,) rad/s that its gearbox would give it there.
    """

    target: Array
    valid: np.ndarray
    counted: np.ndarray | slice
    """The rows (k,) that count: mostly they are one piece."""
    follows: np.ndarray
    speed: Array

    def off(self, predicted: Array) -> Array:
        """(n,) measured less ``predicted`` (n,), 0 where nothing counts."""
        out = np.empty_like(self.target)
        _off(self.target, predicted, self.valid, out)
        return out

    def middle(self, values: Array) -> Array:
        """(n,) the median of values (n,) where they count, 0 elsewhere."""
        return np.where(self.valid, np.median(values[self.valid]), 0.0) if self.valid.any() else 0.0 * values

    def those(self, values: Array) -> Array:
        """(k,) of values (n,), where they count; a copy."""
        return values[self.counted].copy() if isinstance(self.counted, slice) else values.take(self.counted)


@dataclass(frozen=True)
class View:
    """A span as the effects see it: what is known of the whole arm at each step of its grid."""

    span: Span
    dt: Array
    arm: Arm
    follows: np.ndarray
    told: Array | None = None
    """Angles of the joints (m, joints), where these are not just where their motors take them."""
    posture: Array | None = None
    """Those by which loads and masses go, likewise: these need them less exactly than what swings does."""
    hums: tuple[tuple[tuple[int, ...], Hum], ...] = ()
    """Tones of columns that showed beside the physics, and were taken out of the span's target."""
    cuts: dict[int, tuple[Array, Array]] = field(default_factory=dict, init=False, repr=False, compare=False)
    large: dict[tuple[Hashable, Hashable, int], tuple[Array | None, Any]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    """What is known at angles, and those, and what effects make of it: of long recordings only that of the
    last looks fits into memory.
    """
    rests: dict[tuple[int, Hashable], Any] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    """How columns rest from moments [s] on."""
    there: dict[tuple[tuple[str, float], ...], Array] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    """How much of a payload is there, by its moments."""

    @cached_property
    def columns(self) -> list[Column]:
        """What was measured of each joint."""
        span = self.span
        return [
            Column(
                np.ascontiguousarray(span.target[:, c]),
                np.ascontiguousarray(span.valid[:, c]),
                in_one_piece(np.flatnonzero(span.valid[:, c])),
                np.ascontiguousarray(self.follows[:, c]),
                span.measured(self.of(c)[1][:, 0]),
            )
            for c in range(span.target.shape[1])
        ]

    @property
    def speeds(self) -> Array:
        """(m, joints) rad/s at which the motors take the joints; not kept, few ask for it."""
        return np.asarray(self.span.velocity * self.arm.ratio)

    @property
    def wires(self) -> Array:
        """(m, joints) rad where the motors take the joints; made when it is asked for."""
        return self._keep(WIRES, None, lambda: self.arm.driven(self.span.gearbox))

    @property
    def angles(self) -> Array:
        """(m, joints) rad."""
        return self.wires if self.told is None else self.told

    @property
    def load(self) -> Array:
        """(m, joints) moment on the joints."""
        return self._kept("load", 0, self._load_at)

    def _load_at(self, angles: Array) -> Array:
        known = self.span.resistance
        load = self.arm.load(angles) if known is None else known.load(self.arm, angles)
        load = load if self.arm.coupling is None else self.arm.carried(load)
        return np.asfortranarray(load, precision(len(load)))

    @property
    def lever(self) -> Array:
        """(m, joints) what a kilogram more at the tip adds to it."""
        return self._kept("lever", 0, self._lever)

    def masses(self, payload: Payload = NOTHING) -> Array:
        """M (m, joints, joints) kg m^2 of the arm that carries so much."""
        if not payload.mass:
            return self._kept("masses", 0, partial(_by_pieces, self.arm.mass_matrix))
        return self._kept("loaded", payload, partial(self._loaded, payload))

    def _loaded(self, payload: Payload, _: Array) -> Array:
        return self.masses() + self._carried(payload)[..., None] * self._mass_lever

    def inertia(self, joint: int, payload: Payload, rows: np.ndarray | None = None) -> Array:
        """(m, joints) a joint's row of that, or (k, joints) at some steps; not to be changed."""
        row = self._kept("row", joint, lambda _: _row_of(self.masses(), joint))
        row = row if rows is None else row[rows]
        if not payload.mass:
            return row
        lever = self._kept("row lever", joint, lambda _: _row_of(self._mass_lever, joint))
        more = np.asarray(self._carried(payload) * lever)
        return np.asarray(row + (more if rows is None else more[rows]))

    def cached(self, what: Hashable, payload: Payload, make: Callable[[], Made]) -> Made:
        """What an effect makes of the joints' angles and the masses, made once for these."""
        return self._keep((what, payload, id(self.told)), self.told, make)

    @property
    def _mass_lever(self) -> Array:
        return self._kept("mass_lever", 0, partial(_by_pieces, self.arm.mass_lever))

    def _lever(self, angles: Array) -> Array:
        known = self.span.resistance
        more = _by_pieces(self.arm.lever, angles) if known is None else known.per_kilogram(self.arm, angles)
        return more if self.arm.coupling is None else self.arm.carried(more)

    def _kept(self, what: Hashable, which: Hashable, of: Callable[[Array], Array]) -> Array:
        key = what, which, id(self.posture)
        return self._keep(key, self.posture, lambda: of(self.wires if self.posture is None else self.posture))

    def _keep(self, key: tuple[Hashable, Hashable, int], at: Array | None, make: Callable[[], Made]) -> Made:
        if key not in self.large:
            make_room(self.large, len(self.span.grid), (k for k in self.large if k[0] == key[0]))
            self.large[key] = at, make()
        made: Made = self.large[key][1]
        return made

    def apart(self, angles: Array) -> float:
        """How far the joints are at most from other angles (m, joints)."""
        return _apart(self.angles, angles)

    def turned(self, angles: Array, least: float = 0.0) -> View:
        """The same with the joints at other angles (m, joints); what does not go by these is there once.
        Loads and masses stay as they are where all angles lie within a share ``least`` of their range.
        """
        before = self.wires if self.posture is None else self.posture
        stands = _apart(before, angles) <= least * np.ptp(angles)
        other = replace(self, told=angles, posture=self.posture if stands else angles)
        if len(self.span.grid) > CELLS:
            self.large.pop(WIRES, None)  # whoever still asks for them has them made anew
        kept = {"cuts": self.cuts, "large": self.large, "rests": self.rests, "there": self.there}
        vars(other).update(kept, columns=self.columns)
        return other

    def only(self, rows: np.ndarray) -> View:
        """The same with these rows (n,) of the target alone counting."""
        valid = self.span.valid & rows[:, None]
        other = replace(self, span=replace(self.span, valid=valid), follows=following(valid))
        vars(other).update(cuts=self.cuts, large=self.large, there=self.there)
        return other

    def load_of(self, column: int, payload: Payload) -> Array:
        """(m, 1) N m on one joint, of an arm that carries so much."""
        one = slice(column, column + 1)
        load = self.load[:, one]
        if payload.mass:
            load = load + self._carried(payload) * self.lever[:, one]
        return np.ascontiguousarray(load, float)

    def _carried(self, payload: Payload) -> Array:
        """(m, 1) or (1, 1) kg."""
        return payload.mass * (np.ones((1, 1)) if payload.always else self._there(payload))

    def _there(self, payload: Payload) -> Array:
        """(m, 1) how much of a payload is there: all joints ask for it, and a fit with one mass after the
        other.
        """
        if payload.when not in self.there:
            make_room(self.there, len(self.span.grid), self.there)
            self.there[payload.when] = payload.share(self.span.grid)
        return self.there[payload.when]

    def of(self, column: int) -> tuple[Array, Array]:
        """Gearbox angle and speed at the joint of one joint, (m, 1) each."""
        if column not in self.cuts:
            gearbox = np.ascontiguousarray(self.span.gearbox[:, column])
            speed = self.span.velocity[:, column] * self.arm.ratio[column]
            self.cuts[column] = gearbox[:, None], speed[:, None]
        return self.cuts[column]


@compiled
def _off(target: Array, predicted: Array, valid: np.ndarray, out: Array) -> None:
    for k in range(len(out)):
        out[k] = target[k] - predicted[k] if valid[k] else 0.0


def _by_pieces(of: Callable[[Array], Array], angles: Array) -> Array:
    """What is known (m, ...) at angles (m, joints); of long recordings in single precision."""
    many, kept = pieces(len(angles)), precision(len(angles))
    return of(angles) if len(many) == 1 else np.concatenate([of(angles[k]).astype(kept) for k in many])


def _row_of(masses: Array, joint: int) -> Array:
    """(m, joints) of M (m, joints, joints)."""
    return np.ascontiguousarray(masses[:, joint], dtype=float)


def _apart(angles: Array, others: Array) -> float:
    """How far joints are apart at most; of one joint after the other."""
    return max(float(np.abs(one - other).max()) for one, other in zip(angles.T, others.T, strict=True))


def counted(views: Sequence[View], signals: Iterable[Array], column: int) -> Array:
    """(rows,) of signals, (n,) a span, where a column counts."""
    pairs = zip(views, signals, strict=True)
    return np.concatenate([view.columns[column].those(signal) for view, signal in pairs])


def following(valid: np.ndarray) -> np.ndarray:
    """(n, joints): where the sample before counts as well."""
    out = np.zeros_like(valid)
    out[1:] = valid[1:] & valid[:-1]
    return out
