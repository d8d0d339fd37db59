"""What the effects of one stage do to a signal, given what they see of the arm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.body import Body
from trunk_ros.arm.geometry import Geometry, changed
from trunk_ros.compiled import Array
from trunk_ros.effects import lasting
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.wire.play import SharpPlay

SENSOR = 700  # wire effects from this place on change the reading, not the joint

Memory = dict[str, Any]
Lies = Callable[[Array, Array | None, Core], Any]
"""The memory with which a friction element begins, of what comes to it (n, columns), times (columns,)."""


@dataclass
class State:
    """The memory of a chain between two calls."""

    stamp: float
    x: Array
    """(columns,) the last gearbox angle."""
    angles: Array
    """(columns,) the last joint angle."""
    blocks: Memory = field(default_factory=dict)
    core: Any = None
    drift: Array | float = 0.0
    """(columns,) rad/s at which the joint angle was leaving the gearbox angle."""
    calm: float = 1.0
    """What a difference between two passes comes to in the next one."""
    swing: Array | None = None
    """(3, columns) memory of the joints' motion, where their inertia counts."""
    slope: Array | None = None
    """(columns,) of what a joint is off on the way back, over the gearbox angle that was tried."""


def drift(stamp: Array, x: Array, true: Array, before: State | None, ratio: Array) -> Array | float:
    """(columns,) rad/s at which joints at angles ``true`` leave the gearbox angles ``x``, after the last
    sample.
    """
    last = float(stamp[-1])
    if len(stamp) > 1:
        time, moved, turned = last - stamp[-2], x[-1] - x[-2], true[-1] - true[-2]
    elif before is not None:
        time, moved, turned = last - before.stamp, x[-1] - before.x, true[-1] - before.angles
    else:
        return 0.0
    return np.asarray((turned - ratio * moved) / time) if time > 0.0 else 0.0


@dataclass(frozen=True)
class Order:
    """The effects of a stage, by where they act."""

    path: list[Effect]
    core: list[Effect]
    after: list[Effect]
    sensor: list[Effect]

    @staticmethod
    def of(effects: Sequence[Effect]) -> Order:
        """Sort effects that are in physical order already."""
        order, before = Order([], [], [], []), []
        for e in effects:
            place, first = e.acts_at, e.upstream()
            if first is not None:
                before.append(first)
            if place < Effect.CORE:
                order.path.append(e)
            elif place == Effect.CORE:
                order.core.append(e)
            elif place >= SENSOR:
                order.sensor.append(e)
            elif (behind := e.downstream()) is not None:
                order.after.append(behind)
        order.path.extend(before)
        return order


def wire_pass(
    x: Array, now: Now, order: Order, core: Core, state: State | None, lies: Lies | None = None
) -> tuple[Array, Array, State]:
    """Gearbox angle (n, columns) to joint reading, and to the joint's own angle before the sensor."""
    old, new = state.blocks if state else {}, Memory()
    u, memory = friction(x, now, order, core, state.core if state else None, old, new, lies)
    true = through(u, order.after, now, old, new)
    shown = through(true, order.sensor, now, old, new)
    return shown, true, State(float(now.stamp[-1]), x[-1], true[-1], new, memory)


def friction(
    x: Array,
    now: Now,
    order: Order,
    core: Core,
    state: Any,
    old: Memory,
    new: Memory,
    lies: Lies | None = None,
) -> tuple[Array, Any]:
    """What the wire hands on to the joint, (n, columns) rad, and the friction element's memory; ``x``:
    gearbox angles, likewise. ``lies``: with which memory it begins.
    """
    adjusted(core, order, now, old, new)
    aside = np.ndim(core.middle) > 0
    if core.rounding is None and not order.path and not aside:
        state = lies(x, now.ratio, core) if lies else state
        return SharpPlay().run(x, core.width, state, now.ratio)
    u = through(_at_the_joint(x, now.ratio), order.path, now, old, new)
    u = u + core.middle if aside else u
    state = lies(u, None, core) if lies else state
    moved: tuple[Array, Any] = (core.rounding or SharpPlay()).run(u, core.width, state)
    return moved


def _at_the_joint(x: Array, ratio: Array) -> Array:
    """``x`` (n, columns) times ratios (columns,): one that all columns have goes over the array at once."""
    return x * ratio[0] if len(x) > 1 and (ratio == ratio[0]).all() else x * ratio


def adjusted(core: Core, order: Order, now: Now, old: Memory, new: Memory) -> None:
    """Sets the friction element."""
    core.old, core.new = old, new
    for e in order.core + order.path:
        lasting.adjust(e, core, now)


def through(x: Array, effects: Sequence[Effect], now: Now, old: Memory, new: Memory) -> Array:
    """Pass a signal (n, columns) through blocks; their memory goes from ``old`` to ``new``."""
    for e in effects:
        x, new[e.id] = lasting.run(e, x, now, old.get(e.id))
    return x


def back(y: Array, effects: Sequence[Effect], now: Now, old: Memory, new: Memory) -> Array:
    """Pass a signal (n, columns) backward through the blocks that can be compensated."""
    for e in reversed(effects):
        if e.compensable:
            y, new[e.id] = lasting.invert(e, y, now, old.get(e.id))
    return y


def tip_pass(arm: Arm, effects: Sequence[Effect], theta: Array, now: Now) -> Array:
    """Tip (n, 7) of joint angles (n, joints) with the effects of the arm stage: x, y, z [m], quaternion x, y,
    z, w, in the base link. Raises ModelError where the links are not known.
    """
    body = arm.body
    if effects:
        core = core_of(body)
        for e in effects:
            e.adjust(core, now)
        body, theta = changed(body, core.geometry), theta + core.bent
    return body.poses(theta)


def core_of(body: Body) -> Core:
    """What the effects of the arm stage may change of a body."""
    geometry = Geometry.nominal(len(body.own))
    return Core(geometry=geometry, along=body.along, across=body.across, beside=body.beside)
