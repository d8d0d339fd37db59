"""The loops of a stage's servos, with what effects make of them, run over their setpoints."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.arm import SERVO_OF_EACH
from trunk_ros.compiled import Array
from trunk_ros.effects import lasting
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.servo.leaps import leaping_loops
from trunk_ros.effects.servo.loop import fresh, servo_loop
from trunk_ros.effects.servo.loops import SEVERAL, servo_loops
from trunk_ros.levels import ENOUGH, HARDLY

LATE, EARLY = 1.5, 1e-3  # setpoint periods: what comes later than that stood before; rounding of stamps

STEADY = ("kp", "tau_v", "v_max", "uneven", "delay", "feedforward", "torque", "rub", "cogging", "dry")
LASTS = 200  # rows from which on loops that change meanwhile are stepped side by side up to there

LOOP = (*SERVO_OF_EACH, "uneven", "pull", "load", "torque", "rub", "dead_zone", "cogging", "dry")


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
        quickest=none + np.inf,
        ramp=none + np.inf,
        hardest=none + np.inf,
        dry=none,
        ki=none,
        windup=none,
        speed_ki=none,
        teeth=np.zeros((2, 1, columns)),
    )
    for e in effects:
        if e.acts_at == Effect.CORE:
            _set(e, core, now)
    return core


def run_servo(
    core: Core, now: Now, setpoints: Array, stamps: Array, start: Array, anew: Iterable[int] = ()
) -> tuple[Array, Array]:
    """Gearbox angle (n, columns) of loops with these numbers and their state (8, columns) after it;
    ``setpoints`` may begin with past rows. After each of the rows ``anew`` it goes on from where the gearbox
    is there.
    """
    n, columns = len(now.stamp), len(now.ratio)
    out, state = np.empty((n, columns)), start.copy()
    within = np.minimum(np.maximum(setpoints, core.lowest), core.highest) if core.bounded else setpoints
    skip, fed = len(stamps) - n, fed_forward(core, within, stamps)
    beside = fed - within if fed is not within and core.ki.any() else within[:0]
    edges = [0, *(row + 1 for row in sorted({*anew}) if row + 1 < n), n]
    for first, last in pairwise(edges):
        if first:
            state = fresh(now.gearbox[first - 1], now.speed[first - 1] / now.ratio)
        _step(_between(core, first, last), fed, beside, stamps, skip + first, state, out[first:last])
    return out, state


def with_sums(core: Core, now: Now, setpoints: Array, start: Array) -> Array:
    """The state (8, columns) of a start with what integral parts hold then: as much as has the shafts go as
    they were read to from there. By the first reading alone it would be known no better than a speed is, and
    it dies away slowly.
    """
    run, tried = _from_starts(core, now, setpoints), HARDLY * core.kp[0] * (core.ki[0] != 0.0)
    without, more = (run(np.vstack([start[:-1], held])) for held in (0.0 * tried, tried))
    per, off = more - without, now.gearbox[: len(without)] - without
    squares = np.sum(per**2, axis=0)
    share = np.divide(np.sum(per * off, axis=0), squares, out=np.zeros_like(squares), where=squares > 0.0)
    return np.vstack([start[:-1], share * tried])


def with_profiles(core: Core, now: Now, setpoints: Array, start: Array) -> Array:
    """The state (8, columns) of a start with how far the profiles of drives are then, and how fast: as ahead
    of shafts as loops lag that go at one speed, gather it, or brake, whichever leads on as they were read.
    """
    run, best, least = _from_starts(core, now, setpoints), start, np.full(start.shape[1], np.inf)
    for way in (0.0, -1.0, -0.5, 0.5, 1.0):
        change = way * np.where(core.ramp[0] < np.inf, core.ramp[0], 0.0)
        pace = start[1] + change / core.kp[0]
        led = start[0] + (start[1] + core.tau_v[0] * change) / core.kp[0] - core.told[0] * pace
        there = np.vstack([start[:4], led, pace, start[6:]])
        went = run(there)
        left = np.sum((now.gearbox[: len(went)] - went) ** 2, axis=0)
        best, least = np.where(left < least, there, best), np.minimum(left, least)
    return best


def _from_starts(core: Core, now: Now, setpoints: Array) -> Callable[[Array], Array]:
    """Gearbox angles of the first rows, as many as tell how a run began, from a state (8, columns)."""
    rows = min(len(now.stamp), ENOUGH)
    first, begun = _between(core, 0, rows), replace(now, stamp=now.stamp[:rows])
    return lambda start: run_servo(first, begun, setpoints[:rows], begun.stamp, start)[0]


def _between(core: Core, first: int, last: int) -> Core:
    """The loop from row to row."""
    over_time = {name: one[first:last] for name in LOOP if len(one := getattr(core, name)) > 1}
    return replace(core, **over_time) if over_time else core


def fed_forward(core: Core, setpoints: Array, stamps: Array) -> Array:
    """What the position loop would have to be asked for (m, columns) to go as one that is told, beside its
    ``setpoints`` (m, columns) at ``stamps`` (m,), how fast these move; not of drives with setpoints of their
    own.
    """
    if not core.feedforward.any():
        return setpoints
    share = core.feedforward / core.kp - core.told
    if not share.any():
        return setpoints
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


def _step(
    core: Core, setpoints: Array, beside: Array, stamps: Array, skip: int, state: Array, out: Array
) -> None:
    """Step the loops, several steps at once or side by side where that pays."""
    leaps, alongside = _is_plain(core), out.shape[1] >= SEVERAL
    edges = _changes(core, len(out)) if leaps or alongside else []
    reached = np.where(core.rub.any(axis=0), np.maximum(core.reach, np.abs(core.rub).max(axis=0)), 0.0)
    if not edges:
        cogging = _stacked(core.cogging, *core.teeth)
        numbers = core.kp, core.tau_v, *core.tops, core.delay, core.pull, core.load, core.torque, core.rub
        kp, tau_v, up, down, delay, pull, load, torque, rub = map(np.ascontiguousarray, numbers)
        servo_loop(
            setpoints, stamps, kp, tau_v, up, down, delay, pull, load, torque, rub, reached, core.dead_zone,
            cogging, _limits(core), core.ki, beside, core.ahead, skip, state, out,
        )  # fmt: skip
    for first, last in pairwise(edges):
        here = _between(core, first, last) if len(edges) > 2 else core
        if leaps:
            _leaping(here, setpoints, stamps, skip + first, state, out[first:last])
        else:
            _side_by_side(here, reached, setpoints, beside, stamps, skip + first, state, out[first:last])


def _is_plain(core: Core) -> bool:
    """Whether nothing but top speeds keeps a step of the loop from being linear."""
    none = core.rub, core.dead_zone, core.cogging, core.dry, core.ki, core.speed_ki
    unlimited = core.quickest, core.ramp, core.hardest
    return not any(one.any() for one in none) and all((one == np.inf).all() for one in unlimited)


def _leaping(core: Core, setpoints: Array, stamps: Array, skip: int, state: Array, out: Array) -> None:
    """Loops of which nothing but the load and what pulls changes, and that are plain."""
    steady = core.kp, core.tau_v, *core.tops, core.delay, core.torque
    kp, tau_v, up, down, delay, torque = (np.ascontiguousarray(number[0]) for number in steady)
    pull, load = np.ascontiguousarray(core.pull), np.ascontiguousarray(core.load)
    leaping_loops(
        setpoints, stamps, kp, tau_v, up, down, delay, pull, load, torque, core.ahead, skip, state, out
    )


def _side_by_side(
    core: Core,
    reached: Array,
    setpoints: Array,
    beside: Array,
    stamps: Array,
    skip: int,
    state: Array,
    out: Array,
) -> None:
    """Step loops of which nothing but the load and what pulls changes."""
    numbers = core.kp, core.tau_v, *core.tops, core.delay, core.torque, core.rub, core.ki
    kp, tau_v, up, down, delay, torque, rub, ki = (np.ascontiguousarray(number[0]) for number in numbers)
    pull, load, zone = (np.zeros_like(out) + number for number in (core.pull, core.load, core.dead_zone))
    cogging = _stacked(core.cogging[0], *core.teeth[:, 0])
    servo_loops(
        setpoints, stamps, kp, tau_v, up, down, delay, pull, load, torque, rub, reached, zone, cogging,
        np.ascontiguousarray(_limits(core)[:, 0]), ki, beside, core.ahead, skip, state, out,
    )  # fmt: skip


def _limits(core: Core) -> Array:
    limits = core.paces, core.hardest, core.dry, core.windup, core.ramp, core.told, core.speed_ki
    return _stacked(*limits)


def _stacked(*numbers: Array) -> Array:
    """Numbers one above the other, always in one layout in memory: each other one compiles the loops anew."""
    return np.ascontiguousarray(np.stack(np.broadcast_arrays(*numbers)))


def _changes(core: Core, rows: int) -> list[int]:
    """The rows between which a loop stays as it is, and both ends; none where it changes too often."""
    over_time = [one for name in STEADY if len(one := getattr(core, name)) > 1]
    edges = {0, rows}
    for one in over_time:
        edges |= {*(np.flatnonzero((one[1:] != one[:-1]).any(axis=1)) + 1).tolist()}
    return sorted(edges) if LASTS * (len(edges) - 1) <= rows or not over_time else []


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
