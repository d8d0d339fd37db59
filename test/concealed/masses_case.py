"""Concealed arms integrated from their pieces: at everyday work, under awkward sensors, with events."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from test.concealed.awkward import ALLOWED, EVERY_RUN, MOTION, Awkward, acting, draw_awkward, spoiled
from test.concealed.awkward import KINDS as AWKWARD
from test.concealed.case import Case, told_with, turn
from test.concealed.draws import ALL, Rng, logarithmic
from test.concealed.everyday import EVERYDAY, draw_motion
from test.concealed.hidden import Hidden
from test.concealed.masses import run_masses
from test.concealed.masses_arm import Arm, soft
from test.concealed.masses_draw import MAKE, SIMPLE, Change, carried, place
from test.concealed.masses_events import EVENTS
from test.concealed.mujoco_draw import Wish
from test.concealed.nominal import COMPLIANCE, COUNT, RATIO, Array
from test.concealed.plant import Motion
from test.concealed.sensing import PERIOD, Run, Sensing, draw_sensing, record
from test.concealed.trajectory import KINDS as USUAL

KINDS = ("masses", "everyday", "events", "awkward", "clean_masses", "clean_everyday", "clean_awkward")
PAIRED = tuple(name for name in MAKE if name not in ("backlash", "servo_bandwidth", "load_droop"))
AT_REST = (
    "load_elasticity",
    "wire_slack",
    "wire_stiffening",
    "backlash",
    *SIMPLE,
)  # what shows where an arm stands
Arms = list[tuple[float, Arm]]


@dataclass(frozen=True)
class Plan:
    """What of a case is drawn from where; None: at random."""

    names: tuple[str, ...] = ()
    event: str | None = None
    awkward: str | None = None
    motion: str | None = None
    other: str | None = None
    level: tuple[float, float] = (2.0, 30.0)
    seconds: float = 60.0


@dataclass(frozen=True)
class _Work:
    """References and setpoints (n, 5) at 100 Hz of both runs, and what acts on the drives at 2 ms."""

    kinds: tuple[str, str]
    reference: tuple[Array, Array]
    setpoint: tuple[Array, Array]
    asked: tuple[Array, Array]


def plan_of(seed: int, kind: str) -> Plan:
    """What the seed of a kind asks for: every name once in as many seeds in a row."""
    rng = np.random.default_rng([seed, 8])
    if kind == "events":
        return Plan(event=turn(seed, tuple(EVENTS)), motion=str(rng.choice([*EVERYDAY, *USUAL])))
    made: tuple[str, ...] = (turn(seed, tuple(MAKE)),)
    if kind.endswith("awkward"):
        which = turn(seed, AWKWARD)
        made = (turn(seed, AT_REST),) if which == "stations" else made
        motion = MOTION.get(which) or str(rng.choice([*EVERYDAY, *USUAL]))
        seconds = 180.0 if which == "stations" else 60.0
        return Plan(made, awkward=which, motion=motion, other="mixed", seconds=seconds, level=(4.0, 30.0))
    if kind.endswith("everyday"):
        other = str(rng.choice([*EVERYDAY, "mixed", "mixed"]))
        return Plan(made, motion=turn(seed, tuple(EVERYDAY)), other=other, level=(3.0, 30.0))
    if made[0] in PAIRED and made[0] not in SIMPLE and rng.uniform() < 0.4:
        made += (str(rng.choice(list(SIMPLE))),)
    return Plan(made, motion=str(rng.choice(USUAL)))


def _work(rng: Rng, plan: Plan) -> _Work:
    t = np.arange(round(plan.seconds / PERIOD), dtype=np.float64) * PERIOD
    kinds = (plan.motion or "mixed", plan.other or "mixed")
    train, test = (draw_motion(rng, kind, t) for kind in kinds)
    slides = plan.awkward == "wandering"  # of the drives' own, in every run
    asked = acting(rng, train / RATIO, slides), acting(rng, test / RATIO, slides)
    return _Work(kinds, (train, test), (train / RATIO, test / RATIO), asked)


def _wish(rng: Rng, plan: Plan, noise: float, theta: Array) -> Wish:
    some = rng.choice(COUNT, int(rng.integers(1, 4)), replace=False)
    joints = tuple(sorted(int(j) for j in some))
    return Wish(joints, noise * float(logarithmic(rng, *plan.level)), noise, theta)


def _clean(rng: Rng) -> Arm:
    """An arm that is as it should be: on stiff wires, or on real ones with its weight carried."""
    return Arm() if rng.uniform() < 0.5 else soft(carried(Arm()), ALL, COMPLIANCE, place(rng))


def _built(changes: list[Change]) -> Arms:
    arm = Arm()
    for change in changes:
        arm = change.apply(arm)
    return [(0.0, arm)]


def _with_and_without(
    rng: Rng, plan: Plan, wish: Callable[[], Wish]
) -> tuple[Arms, list[tuple[Hidden, Arms, Arms]]]:
    """How the arm is built, and of each thing that is hidden how it is with it and without."""
    if plan.event is not None:
        event = EVENTS[plan.event](rng, wish(), plan.seconds)
        return event.arms(), [(event.hidden, event.arms(), event.arms(happens=False))]
    if not plan.names:
        return [(0.0, _clean(rng))], []
    changes = [change for name in plan.names for change in MAKE[name](rng, wish())]
    stages = [_built(changes[:n]) for n in range(len(changes) + 1)]
    return stages[-1], [(c.hidden, stages[n + 1], stages[n]) for n, c in enumerate(changes)]


def _told(hidden: Hidden, both: tuple[Arms, Arms], asked: Array, noise: float) -> dict[str, Any] | None:
    """Entry of truth.json, from the arm with and without; None where nothing shows on any joint."""
    on, off = (run_masses(arms, asked) for arms in both)
    strength = np.sqrt(((on.theta - off.theta) ** 2).mean(axis=0)) / noise
    if hidden.effect == "zero_offset":
        hidden = _as_it_reads(hidden, on, off)
    if hidden.form == "whole_arm":
        hidden = replace(hidden, joints=tuple(int(j) for j in np.flatnonzero(strength > 1.0)))
    return told_with(hidden, strength) if hidden.joints else None


def _as_it_reads(hidden: Hidden, on: Motion, off: Motion) -> Hidden:
    """A wire that was cut too long turns the joint, and the weight on it with that: where the wire stretches
    the reading is off by more than it was cut.
    """
    joint, shaft = ((getattr(on, name) - getattr(off, name)).mean(axis=0) for name in ("theta", "phi"))
    return replace(hidden, parameters={"offset": (joint - RATIO * shaft)[list(hidden.joints)]})


def draw_masses_case(seed: int, kind: str = "masses", plan: Plan | None = None) -> Case:
    """The integrated arm of a seed; kind: one of KINDS. plan: in place of the seed's own.

    Raises RuntimeError where nothing comes out at a strength that counts in 20 attempts.
    """
    asked = plan or plan_of(seed, kind)
    asked = replace(asked, names=(), event=None) if kind.startswith("clean") else asked
    for attempt in range(20):
        case = _try(np.random.default_rng([seed, attempt, 5]), seed, asked)
        if all(one["strength"] > 0.5 * asked.level[0] for one in case.truth):
            return case
    raise RuntimeError(f"seed {seed}: {asked.names or asked.event} not brought out at strength {asked.level}")


def _try(rng: Rng, seed: int, plan: Plan) -> Case:
    awkward = draw_awkward(rng, plan.awkward) if plan.awkward else None
    work, how = _work(rng, plan), draw_sensing(rng, False, bool(rng.uniform() < 0.3))
    if plan.awkward == "coarse":
        how = replace(how, noise=2e-5)
    noise = float(np.hypot(how.noise, awkward.adds if awkward else 0.0))
    theta = RATIO * run_masses([(0.0, Arm())], work.asked[0]).phi
    arms, hidden = _with_and_without(rng, plan, lambda: _wish(rng, plan, noise, theta))
    done = [run_masses(arms, asked) for asked in work.asked]
    told = [_told(one, (on, off), work.asked[0], noise) for one, on, off in hidden]
    runs = _recorded(rng, work, done, how, awkward)
    faint = [one.effect for (one, _, _), entry in zip(hidden, told, strict=True) if entry is None]
    about = {**asdict(how), "noise": noise, "plant": "masses",
             "awkward": asdict(awkward) if awkward else None,
             "allowed": [*ALLOWED.get(plan.awkward or "", ()), *faint]}  # fmt: skip
    return Case(seed, [one for one in told if one is not None], about, *runs)


def _recorded(
    rng: Rng, work: _Work, done: list[Motion], how: Sensing, awkward: Awkward | None
) -> tuple[Run, Run]:
    runs = [
        record(rng, kind, reference, setpoint, motion, how)
        for kind, reference, setpoint, motion in zip(
            work.kinds, work.reference, work.setpoint, done, strict=True
        )
    ]
    if awkward is not None:
        runs[0] = spoiled(rng, runs[0], awkward)
        runs[1] = spoiled(rng, runs[1], awkward) if awkward.kind in EVERY_RUN else runs[1]
    return runs[0], runs[1]
