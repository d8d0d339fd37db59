"""What the effects of one stage do to a signal, given what they see of the arm."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.arm import SERVO_OF_EACH
from trunk_ros.arm.body import Body
from trunk_ros.arm.geometry import Geometry, changed
from trunk_ros.compiled import Array
from trunk_ros.effects import lasting
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.servo.loop import SEVERAL, fresh, servo_loop, servo_loops
from trunk_ros.effects.wire.play import SharpPlay

LATE, EARLY = 1.5, 1e-3  # setpoint periods: what comes later than that stood before; rounding of stamps
SENSOR = 700  # wire effects from this place on change the reading, not the joint

LOOP = (*SERVO_OF_EACH, "uneven", "pull", "load", "torque", "rub", "dead_zone", "cogging")

Memory = dict[str, Any]


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
    x: Array, now: Now, order: Order, core: Core, state: State | None
) -> tuple[Array, Array, State]:
    """Gearbox angle (n, columns) to joint reading, and to the joint's own angle before the sensor."""
    old, new = state.blocks if state else {}, Memory()
    u, memory = friction(x, now, order, core, state.core if state else None, old, new)
    true = through(u, order.after, now, old, new)
    shown = through(true, order.sensor, now, old, new)
    return shown, true, State(float(now.stamp[-1]), x[-1], true[-1], new, memory)


def friction(
    x: Array, now: Now, order: Order, core: Core, state: Any, old: Memory, new: Memory
) -> tuple[Array, Any]:
    """What the wire hands on to the joint, (n, columns) rad, and the friction element's memory; ``x``:
    gearbox angles, likewise.
    """
    adjusted(core, order, now, old, new)
    aside = np.ndim(core.middle) > 0
    if core.rounding is None and not order.path and not aside:
        return SharpPlay().run(x, core.width, state, now.ratio)
    u = through(_at_the_joint(x, now.ratio), order.path, now, old, new)
    u = u + core.middle if aside else u
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


def servo_core(arm: Arm, effects: Sequence[Effect], now: Now, numbers: Array | None = None) -> Core:
    """The numbers of an arm's loops with effects on them; ``numbers`` (5, columns): of other servos."""
    columns = len(now.ratio)
    if numbers is None:
        numbers = np.stack([_seen(getattr(arm, name), now) for name in SERVO_OF_EACH])
    kp, tau_v, v_max, delay, feedforward = numbers[:, None]
    none = np.zeros((1, columns))
    core = Core(
        kp=kp,
        tau_v=tau_v,
        v_max=v_max,
        uneven=none,
        delay=delay,
        feedforward=feedforward,
        ahead=arm.ahead,
        pull=none,
        load=none,
        torque=none,
        rub=none,
        reach=reach(arm, now),
        dead_zone=none,
        cogging=none,
        teeth=np.zeros((2, 1, columns)),
    )
    for e in effects:
        if e.acts_at == Effect.CORE:
            _set(e, core, now)
    return core


def run_servo(
    core: Core, now: Now, setpoints: Array, stamps: Array, start: Array, anew: Iterable[int] = ()
) -> tuple[Array, Array]:
    """Gearbox angle (n, columns) of loops with these numbers and their state (4, columns) after it;
    ``setpoints`` may begin with past rows. After each of the rows ``anew`` it goes on from where the gearbox
    is there.
    """
    n, columns = len(now.stamp), len(now.ratio)
    out, state = np.empty((n, columns)), start.copy()
    skip, fed = len(stamps) - n, fed_forward(core, setpoints, stamps)
    edges = [0, *(row + 1 for row in sorted({*anew}) if row + 1 < n), n]
    for first, last in pairwise(edges):
        if first:
            state = fresh(now.gearbox[first - 1], now.speed[first - 1] / now.ratio)
        end = skip + last
        _step(_between(core, first, last), fed[:end], stamps[:end], skip + first, state, out[first:last])
    return out, state


def _between(core: Core, first: int, last: int) -> Core:
    """The loop from row to row."""
    over_time = {name: one[first:last] for name in LOOP if len(one := getattr(core, name)) > 1}
    return replace(core, **over_time) if over_time else core


def fed_forward(core: Core, setpoints: Array, stamps: Array) -> Array:
    """What the position loop would have to be asked for (m, columns) to go as one that is told, beside its
    ``setpoints`` (m, columns) at ``stamps`` (m,), how fast these move.
    """
    if not core.feedforward.any():
        return setpoints
    share = core.feedforward / core.kp
    if len(share) > 1:  # what changes in mid-run, of past rows as it is at first
        past = np.repeat(share[:1], len(stamps) - len(share), axis=0)
        share = np.concatenate([past, share])
    fed, first = setpoints.copy(), setpoints[:, :1]
    alone = first if (setpoints == first).all() else setpoints  # one joint, as several hypotheses have it
    fed[1:] += (share[1:] if len(share) > 1 else share) * speeds(alone, stamps)
    return fed


def speeds(setpoints: Array, stamps: Array) -> Array:
    """(m - 1, columns) rad/s at which setpoints (m, columns) came to each but the first. One may stand in
    several rows: its speed is that from the setpoint before, and lasts until the next one is due.
    """
    out = np.zeros_like(setpoints[1:])
    moved = np.flatnonzero(np.diff(setpoints, axis=0).any(axis=1)) + 1
    came = np.concatenate([[0], moved])
    apart = np.diff(stamps[came])
    if not (apart > 0.0).any():
        return out
    period = float(np.median(apart[apart > 0.0]))
    apart = np.where((apart > 0.0) & (apart < LATE * period), apart, period)  # else it stood before
    speed = np.diff(setpoints[came], axis=0) / apart[:, None]
    last = np.searchsorted(moved, np.arange(1, len(stamps)), side="right") - 1
    lasts = (last >= 0) & (stamps[1:] < stamps[moved[last]] + (1.0 - EARLY) * apart[last])
    out[lasts] = speed[last[lasts]]
    return out


def _step(core: Core, setpoints: Array, stamps: Array, skip: int, state: Array, out: Array) -> None:
    """Step the loops, side by side where that pays and nothing of them changes."""
    numbers = core.kp, core.tau_v, *core.tops, core.delay, core.pull, core.load, core.torque, core.rub
    reached = np.where(core.rub.any(axis=0), np.maximum(core.reach, np.abs(core.rub).max(axis=0)), 0.0)
    steady = all(len(one) == 1 for one in (*numbers[:5], core.torque, core.rub, core.cogging))
    cogging = np.stack(np.broadcast_arrays(core.cogging, *core.teeth))
    least = SEVERAL if core.rub.any() or core.cogging.any() else 2 * SEVERAL
    if out.shape[1] < least or not steady:
        kp, tau_v, up, down, delay, pull, load, torque, rub = map(np.ascontiguousarray, numbers)
        servo_loop(
            setpoints, stamps, kp, tau_v, up, down, delay, pull, load, torque, rub, reached, core.dead_zone,
            cogging, core.ahead, skip, state, out,
        )  # fmt: skip
        return
    kp, tau_v, up, down, delay, _, _, torque, rub = (number[0] for number in numbers)
    pull, load, zone = (np.zeros_like(out) + number for number in (core.pull, core.load, core.dead_zone))
    cogging = np.ascontiguousarray(cogging[:, 0])
    servo_loops(
        setpoints, stamps, kp, tau_v, up, down, delay, pull, load, torque, rub, reached, zone, cogging,
        core.ahead, skip, state, out,
    )  # fmt: skip


def _set(e: Effect, core: Core, now: Now) -> None:
    """``Effect.adjust`` of a servo's numbers, each in proportion to how much of the effect acts."""
    before = {name: getattr(core, name) for name in LOOP}
    e.adjust(core, now)
    if not lasting.lasts(e):
        acts = lasting.acting(e, now)
        for name, number in before.items():
            if (changed_to := getattr(core, name)) is not number:
                setattr(core, name, number + acts * (changed_to - number))


def _seen(values: float | Array, now: Now) -> Array:
    """(columns,) of an arm's values, which may be one for all joints."""
    some = values[list(now.columns)] if isinstance(values, np.ndarray) and now.columns else values
    return np.full(len(now.ratio), some)


def reach(arm: Arm, now: Now) -> Array:
    """(columns,) rad of the gearbox from the middle of the nominal dead bands to where wires slide."""
    return np.abs(_seen(arm.dead_band, now) / now.ratio)


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
