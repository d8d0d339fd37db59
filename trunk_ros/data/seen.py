"""Surroundings of joints that are looked at again and again."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.data.surroundings import View
from trunk_ros.effects.effect import Now
from trunk_ros.effects.moments import NOTHING, Payload
from trunk_ros.effects.now import Made


class Inertia(NamedTuple):
    """What is known of an arm's masses that carries so much, at all steps of a view or at some."""

    view: View
    payload: Payload
    rows: np.ndarray | None = None

    @property
    def masses(self) -> Array:
        """M (n, all joints, all joints) kg m^2."""
        every = self.view.masses(self.payload)
        return every if self.rows is None else every[self.rows]

    def of(self, joint: int) -> Array:
        """(n, all joints) a joint's row of it."""
        return self.view.inertia(joint, self.payload, self.rows)

    def speed_of(self, joint: int) -> Array:
        """(n,) rad/s of a joint."""
        speed = self.view.of(joint)[1][:, 0]
        return speed if self.rows is None else speed[self.rows]

    def at(self, rows: np.ndarray) -> Inertia:
        """The same at some steps (k,)."""
        return self._replace(rows=rows if self.rows is None else self.rows[rows])

    def cached(self, what: Hashable, make: Callable[[], Made]) -> Made:
        """What ``make`` makes of angles and masses, once for all steps."""
        return make() if self.rows is not None else self.view.cached(what, self.payload, make)


def _when_asked(name: str, kept: bool = False) -> Any:
    """A value that may be given as what makes it: it is made when it is asked for, and ``kept`` or not."""
    place = f"_{name}"

    def get(seen: Seen) -> Array:
        said = vars(seen)[place]
        made = said() if callable(said) else said
        if kept:
            vars(seen)[place] = made
        return np.asarray(made)

    return property(get, lambda seen, said: vars(seen).update({place: said}))


class Seen(Now):
    """Surroundings whose load, wires and speeds are worked out when an effect asks for them; what is known of
    the arm's masses at all its angles serves every joint.
    """

    known: Inertia | None = None

    @property
    def masses(self) -> Array:
        """M (n, all joints, all joints) kg m^2 of the arm at ``angles``."""
        return super().masses if self.known is None else self.known.masses

    def inertia(self, joint: int) -> Array:
        """(n, all joints) a joint's row of that."""
        return super().inertia(joint) if self.known is None else self.known.of(joint)

    def speed_of(self, joint: int) -> Array:
        """(n,) rad/s of one of all joints."""
        return super().speed_of(joint) if self.known is None else self.known.speed_of(joint)

    def cached(self, what: Hashable, make: Callable[[], Made]) -> Made:
        """What ``make`` makes of angles and masses, once for these."""
        return make() if self.known is None else self.known.cached(what, make)

    load = _when_asked("load", kept=True)
    wires = _when_asked("wires")
    speeds = _when_asked("speeds")


def now_of(view: View, arm: Arm, column: int, payload: Payload = NOTHING) -> Now:
    """The surroundings of one joint of an arm that carries a payload, (m, 1) each."""
    gearbox, speed = view.of(column)
    seen = Seen(
        view.span.grid,
        view.dt,
        gearbox,
        speed,
        lambda: view.load_of(column, payload),  # type: ignore[arg-type]
        view.angles,
        lambda: view.wires,  # type: ignore[arg-type]
        view.span.joints,
        arm.ratio[column : column + 1],
        speeds=lambda: view.speeds,  # type: ignore[arg-type]
        columns=(column,),
        arm=replace(arm, payload=arm.payload + payload.own) if payload.own else arm,
        carried=NOTHING if payload.always else payload,
        grain=0.0 if view.span.shown is None else float(view.span.shown[column]),
        unseen=view.span.lost[column] if view.span.lost else np.empty((0, 2)),
    )
    seen.known = Inertia(view, payload)
    return seen


def abreast(columns: Sequence[Array]) -> Array:
    """(n, k) of columns (n, 1), each of which lies in memory by itself: numpy goes through columns of a value
    each five times as fast.
    """
    return np.concatenate([column.T for column in columns]).T


def beside(now: Now, times: int) -> Now:
    """The surroundings of one joint, side by side as many times; the last ones are kept with it."""
    if times == 1:
        return now
    kept: Now | None = vars(now).get("_beside")
    if kept is None or len(kept.columns) != times:
        kept = joined([now] * times)
        vars(now)["_beside"] = kept
    return kept


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
        speeds=lambda: first.speeds,  # type: ignore[arg-type]
        ratio=np.concatenate([now.ratio for now in each]),
        columns=tuple(column for now in each for column in now.columns),
    )
    if isinstance(first, Seen) and isinstance(out, Seen):
        out.known = first.known
    return out


def at(now: Now, rows: np.ndarray) -> Now:
    """The surroundings at some steps (k,) alone, the time between them with them."""
    asked = ("load", "wires", "speeds") if isinstance(now, Seen) else ()
    whole = {"joints", "ratio", "held", "columns", "arm", "carried", "dt", "unseen", "grain", *asked}
    steps = {f.name: getattr(now, f.name)[rows] for f in fields(now) if f.name not in whole}
    steps |= {name: partial(_some, now, name, rows) for name in asked}
    out = replace(now, **steps, dt=np.diff(steps["stamp"], prepend=steps["stamp"][:1]))
    if isinstance(now, Seen) and isinstance(out, Seen) and now.known is not None:
        out.known = now.known.at(rows)
    return out


def _some(now: Now, name: str, rows: np.ndarray) -> Array:
    """Some rows of what is made when it is asked for."""
    return np.asarray(getattr(now, name)[rows])
