"""What the effects on a joint see of the arm during a recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.abreast import abreast
from trunk_ros.diagnosis.data.sensing.hum import Hum
from trunk_ros.diagnosis.data.span import Span, in_one_piece
from trunk_ros.diagnosis.machine import LOOKED, make_room
from trunk_ros.effects.effect import Now
from trunk_ros.effects.lasting import NOTHING, Payload


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

    def those(self, values: Array) -> Array:
        """(k,) of values (n,), where they count; a copy."""
        return values[self.counted].copy() if isinstance(self.counted, slice) else values.take(self.counted)


@dataclass(frozen=True)
class View:
    """A span as the effects see it: what is known of the whole arm at each step of its grid."""

    span: Span
    dt: Array
    arm: Arm
    speeds: Array
    follows: np.ndarray
    told: Array | None = None
    """Angles of the joints (m, joints), where these are not just where their motors take them."""
    hums: tuple[tuple[tuple[int, ...], Hum], ...] = ()
    """Tones of columns that showed beside the physics, and were taken out of the span's target."""
    cuts: dict[int, tuple[Array, Array]] = field(default_factory=dict, init=False, repr=False, compare=False)
    large: dict[tuple[str, float, int], tuple[Array | None, Array]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    """What is known at angles, and those: of long recordings only that of the last looks fits into memory."""
    rests: dict[tuple[int, float], Any] = field(default_factory=dict, init=False, repr=False, compare=False)
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
                span.measured(self.speeds[:, c]),
            )
            for c in range(span.target.shape[1])
        ]

    @property
    def wires(self) -> Array:
        """(m, joints) rad where the motors take the joints; made when it is asked for, as few effects do."""
        return self.arm.driven(self.span.gearbox)

    @property
    def angles(self) -> Array:
        """(m, joints) rad."""
        return self.wires if self.told is None else self.told

    @property
    def load(self) -> Array:
        """(m, joints) moment on the joints."""
        return self._kept("load", 0.0, self._load_at)

    def _load_at(self, angles: Array) -> Array:
        known = self.span.resistance
        load = self.arm.load(angles) if known is None else known.load(self.arm, angles)
        return np.asfortranarray(load if self.arm.coupling is None else self.arm.carried(load))

    @property
    def lever(self) -> Array:
        """(m, joints) what a kilogram more at the tip adds to it."""
        return self._kept("lever", 0.0, self._lever)

    def masses(self, payload: float) -> Array:
        """M (m, joints, joints) kg m^2 of the arm with so many kg more at the tip."""
        if not payload:
            return self._kept("masses", 0.0, partial(_by_pieces, self.arm.mass_matrix))
        return self._kept("loaded", payload, lambda _: self.masses(0.0) + payload * self._mass_lever)

    @property
    def _mass_lever(self) -> Array:
        return self._kept("mass_lever", 0.0, partial(_by_pieces, self.arm.mass_lever))

    def _lever(self, angles: Array) -> Array:
        known = self.span.resistance
        more = self.arm.lever(angles) if known is None else known.per_kilogram(self.arm, angles)
        return more if self.arm.coupling is None else self.arm.carried(more)

    def _kept(self, what: str, payload: float, of: Callable[[Array], Array]) -> Array:
        key = what, payload, id(self.told)
        if key not in self.large:
            make_room(self.large, len(self.span.grid), (k for k in self.large if k[0] == what))
            self.large[key] = self.told, of(self.angles)
        return self.large[key][1]

    def apart(self, angles: Array) -> float:
        """How far the joints are at most from other angles (m, joints); of one joint after the other."""
        own = self.angles
        return max(float(np.abs(one - other).max()) for one, other in zip(own.T, angles.T, strict=True))

    def turned(self, angles: Array) -> View:
        """The same with the joints at other angles (m, joints); what does not go by these is there once."""
        other = replace(self, told=angles)
        kept = {"cuts": self.cuts, "large": self.large, "rests": self.rests, "there": self.there}
        vars(other).update(kept, columns=self.columns)
        return other

    def only(self, rows: np.ndarray) -> View:
        """The same with these rows (n,) of the target alone counting."""
        valid = self.span.valid & rows[:, None]
        other = replace(self, span=replace(self.span, valid=valid), follows=following(valid))
        vars(other).update(cuts=self.cuts, large=self.large, there=self.there)
        return other

    def now(self, arm: Arm, column: int, payload: Payload = NOTHING) -> Now:
        """The surroundings of one joint, (m, 1) each."""
        gearbox, speed = self._of(column)
        seen = Seen(
            self.span.grid,
            self.dt,
            gearbox,
            speed,
            lambda: self._load(column, payload),  # type: ignore[arg-type]
            self.angles,
            lambda: self.wires,  # type: ignore[arg-type]
            self.span.joints,
            arm.ratio[column : column + 1],
            speeds=self.speeds,
            columns=(column,),
            arm=replace(arm, payload=arm.payload + payload.own) if payload.own else arm,
        )
        seen.known_masses = partial(self.masses, payload.own)
        return seen

    def _load(self, column: int, payload: Payload) -> Array:
        one = slice(column, column + 1)
        load = self.load[:, one]
        if payload.mass:
            mass = payload.mass if payload.always else payload.mass * self._there(payload)
            load = load + mass * self.lever[:, one]
        return np.ascontiguousarray(load)

    def _there(self, payload: Payload) -> Array:
        """(m, 1) how much of a payload is there: all joints ask for it, and a fit with one mass after the
        other.
        """
        if payload.when not in self.there:
            make_room(self.there, len(self.span.grid), self.there)
            self.there[payload.when] = payload.share(self.span.grid)
        return self.there[payload.when]

    def _of(self, column: int) -> tuple[Array, Array]:
        """Gearbox angle and speed at the joint of one joint, (m, 1) each."""
        if column not in self.cuts:
            one, span = slice(column, column + 1), self.span
            self.cuts[column] = (
                np.ascontiguousarray(span.gearbox[:, one]),
                np.ascontiguousarray(self.speeds[:, one]),
            )
        return self.cuts[column]


def _by_pieces(of: Callable[[Array], Array], angles: Array) -> Array:
    """What is known (m, ...) at angles (m, joints); of long recordings in single precision."""
    if len(angles) <= LOOKED:
        return of(angles)
    return np.concatenate(
        [of(angles[k : k + LOOKED]).astype(np.float32) for k in range(0, len(angles), LOOKED)]
    )


class Seen(Now):
    """Surroundings whose load and wires are worked out when an effect asks for them; what is known of the
    arm's masses at all its angles serves every joint.
    """

    _load: Any
    _wires: Any
    known_masses: Callable[[], Array] | None = None

    @property
    def masses(self) -> Array:
        """M (n, all joints, all joints) kg m^2 of the arm at ``angles``."""
        return super().masses if self.known_masses is None else self.known_masses()

    @property
    def load(self) -> Array:
        """(n, columns) N m."""
        if callable(self._load):
            self._load = self._load()
        return np.asarray(self._load)

    @load.setter
    def load(self, load: Array | Callable[[], Array]) -> None:
        self._load = load

    @property
    def wires(self) -> Array:
        """(n, all joints) rad."""
        return np.asarray(self._wires() if callable(self._wires) else self._wires)

    @wires.setter
    def wires(self, wires: Array | Callable[[], Array]) -> None:
        self._wires = wires


def following(valid: np.ndarray) -> np.ndarray:
    """(n, joints): where the sample before counts as well."""
    out = np.zeros_like(valid)
    out[1:] = valid[1:] & valid[:-1]
    return out


def beside(now: Now, times: int) -> Now:
    """The surroundings of one joint, side by side as many times."""
    return now if times == 1 else joined([now] * times)


def joined(each: Sequence[Now]) -> Now:
    """The surroundings of single joints in one recording, side by side."""
    first = each[0]
    if len(each) == 1:
        return first
    out = replace(
        first,
        gearbox=abreast([now.gearbox for now in each]),
        speed=abreast([now.speed for now in each]),
        load=lambda: abreast([now.load for now in each]),  # type: ignore[arg-type]
        wires=lambda: first.wires,  # type: ignore[arg-type]
        ratio=np.concatenate([now.ratio for now in each]),
        columns=tuple(column for now in each for column in now.columns),
    )
    if isinstance(out, Seen):
        out.known_masses = lambda: first.masses
    return out


def at(now: Now, rows: np.ndarray) -> Now:
    """The surroundings at some steps (k,) alone, the time between them with them."""
    lazy = isinstance(now, Seen)
    whole = ("joints", "ratio", "held", "columns", "arm", "dt", *(["load", "wires"] if lazy else []))
    steps = {f.name: getattr(now, f.name)[rows] for f in fields(now) if f.name not in whole}
    if lazy:
        steps |= {"load": lambda: now.load[rows], "wires": lambda: now.wires[rows]}
    out = replace(now, **steps, dt=np.diff(steps["stamp"], prepend=steps["stamp"][:1]))
    if isinstance(out, Seen):
        out.known_masses = lambda: now.masses[rows]
    return out
