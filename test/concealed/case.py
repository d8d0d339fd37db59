"""One concealed arm: what is hidden in it, a run to diagnose and another one to judge on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from test.concealed.behind import LOADED
from test.concealed.catalogue import CATALOGUE
from test.concealed.draws import ALL
from test.concealed.hidden import ARM, KNOWN, UNKNOWN, Hidden
from test.concealed.nominal import COUNT, JOINTS, RATIO, Array
from test.concealed.plant import Motion, moved, run
from test.concealed.recipe import Look, sized
from test.concealed.sensing import PERIOD, Run, Sensing, draw_sensing, record
from test.concealed.servo import compensated
from test.concealed.trajectory import KINDS, draw_reference

TEST_KIND = {"mixed": "multisine"}


@dataclass(frozen=True)
class Case:
    """``truth``: list of what is hidden, with strengths; ``noise``: how it was recorded; two runs."""

    seed: int
    truth: list[dict[str, Any]]
    noise: dict[str, Any]
    train: Run
    test: Run
    hidden: tuple[Hidden, ...] = ()

    def told(self) -> dict[str, Any]:
        """Contents of truth.json."""
        known = all(one["known"] for one in self.truth)
        kinds = {"train": self.train.kind, "test": self.test.kind}
        return {"seed": self.seed, "truth": self.truth, "known": known, "noise": self.noise, **kinds}


@dataclass(frozen=True)
class Knobs:
    """What is asked of a draw. None: drawn as well."""

    count: int | None = 1
    unknown: bool = False
    effects: Sequence[str] | None = None
    joints: Sequence[int] | None = None
    level: tuple[float, float] = (1.0, 30.0)
    hard: bool = False
    train: str | None = None
    test: str | None = None
    seconds: float = 60.0
    sensing: Sensing | None = None
    compensator: bool | None = None


def strengths(hidden: tuple[Hidden, ...], which: int, setpoint: Array, how: Sensing) -> Array:
    """Strength of one effect beside the others: rms with minus without, over the noise; (5,), arm: (3,)."""
    others = hidden[:which] + hidden[which + 1 :]
    return _difference(run(hidden, setpoint), run(others, setpoint), hidden[which], how)


def _difference(on: Motion, off: Motion, h: Hidden, how: Sensing) -> Array:
    at_tip = h.stage == "arm"
    noise = np.array([how.tip_noise_m, how.tip_noise_m, how.tip_noise_rad]) if at_tip else how.noise
    apart = on.tip - off.tip if at_tip else on.theta - off.theta
    out: Array = np.sqrt((apart**2).mean(axis=0)) / noise
    return out


def _pooled(strength: Array, h: Hidden) -> float:
    some = strength if h.stage == "arm" else strength[list(h.joints)]
    return float(np.sqrt((some**2).mean()))


def _some_joints(rng: np.random.Generator, moving: Sequence[int]) -> tuple[int, ...]:
    many = min(int(rng.choice([1, 2, 3, 5], p=[0.45, 0.3, 0.15, 0.1])), len(moving))
    return tuple(sorted(int(j) for j in rng.choice(moving, many, replace=False)))


def turn(seed: int, names: Sequence[str]) -> str:
    """Every name once in as many seeds in a row, in an order of their own."""
    order = np.random.default_rng(seed // len(names)).permutation(len(names))
    return names[int(order[seed % len(names)])]


def _names(seed: int, round_: int, knobs: Knobs) -> list[str]:
    """Effects to hide: not two of those that replace each other; the first in turn but for later rounds."""
    rng = np.random.default_rng([seed, round_, 1])
    table = UNKNOWN if knobs.unknown else KNOWN
    if knobs.effects is not None:
        return list(knobs.effects)
    count = int(rng.integers(1, 5)) if knobs.count is None else knobs.count
    names: list[str] = []
    for name in ([] if round_ else [turn(seed, table)]) + list(rng.permutation(table)):
        if name in names:
            continue
        if len(names) < count and not (name in LOADED and any(other in LOADED for other in names)):
            names.append(str(name))
    return names


def _draw_one(rng: np.random.Generator, name: str, look: Look, knobs: Knobs, how: Sensing,
              setpoint: Array) -> Hidden | None:  # fmt: skip
    """One effect at a strength drawn from the knobs' range; None where this motion cannot bring it out."""
    joints = _some_joints(rng, look.moving) if knobs.joints is None else tuple(knobs.joints)
    level = float(np.exp(rng.uniform(*np.log(knobs.level))))
    recipe = CATALOGUE[name](rng, joints, look)
    bare = look.motion

    def strength(h: Hidden) -> float:
        on = run((h,), setpoint) if h.stage == "servo" else moved((h,), bare.phi, bare.v)
        return _pooled(_difference(on, bare, h, how), h)

    found = sized(recipe, strength, level)
    return found if recipe.fixed or strength(found) > 0.9 * level else None


def _balanced(h: Hidden, strength: Array, floor: float) -> bool:
    """Every joint that is named shows the effect, unless the effect is shared by all."""
    if h.stage != "wire" or h.joints == ALL:
        return _pooled(strength, h) >= 0.7 * floor
    return bool(strength[list(h.joints)].min() >= max(0.3 * _pooled(strength, h), 0.7 * floor))


@dataclass(frozen=True)
class Motions:
    """References and setpoints (n, 5) at 100 Hz of the two runs, and the joints that move in the first."""

    kinds: tuple[str, str]
    reference: tuple[Array, Array]
    setpoint: tuple[Array, Array]
    moving: tuple[int, ...]
    compensator: bool


def draw_motions(rng: np.random.Generator, knobs: Knobs) -> Motions:
    """Motions of both runs, of the kinds that the knobs ask for or drawn ones."""
    t = np.arange(round(knobs.seconds / PERIOD), dtype=np.float64) * PERIOD
    first = knobs.train or str(rng.choice(KINDS, p=[0.15, 0.1, 0.2, 0.15, 0.1, 0.3]))
    kinds = (first, knobs.test or TEST_KIND.get(first, "mixed"))
    train, test = (draw_reference(rng, kind, t) for kind in kinds)
    moving = ALL
    if knobs.hard and rng.uniform() < 0.25:  # one or two joints hardly move
        still = rng.choice(COUNT, int(rng.integers(1, 3)), replace=False)
        moving = tuple(j for j in ALL if j not in still)
        train[:, still] = train[0, still] + 0.003 * (train[:, still] - train[0, still])
    runs = bool(knobs.hard and rng.uniform() < 0.35) if knobs.compensator is None else knobs.compensator
    asked = [compensated(x, PERIOD) if runs else x / RATIO for x in (train, test)]
    return Motions(kinds, (train, test), (asked[0], asked[1]), moving, runs)


_Drawn: TypeAlias = tuple[Motions, Sensing, tuple[Hidden, ...], list[Array]]


def _try(rng: np.random.Generator, names: list[str], knobs: Knobs) -> _Drawn | None:
    """One attempt; None where an effect does not come out in the drawn motion."""
    motions = draw_motions(rng, knobs)
    tip = any(name in ARM for name in names) or bool(rng.uniform() < 0.4)
    how = knobs.sensing or draw_sensing(rng, knobs.hard, tip)
    how = replace(how, tip=tip or how.tip)
    setpoint = motions.setpoint[0]
    look = Look(run((), setpoint), motions.moving)
    drawn = [_draw_one(rng, name, look, knobs, how, setpoint) for name in names]
    hidden = tuple(h for h in drawn if h is not None)
    if len(hidden) < len(names):
        return None
    found = [strengths(hidden, k, setpoint, how) for k in range(len(hidden))]
    if not all(_balanced(h, s, knobs.level[0]) for h, s in zip(hidden, found, strict=True)):
        return None
    return motions, how, hidden, found


def told_with(h: Hidden, strength: Array) -> dict[str, Any]:
    """The entry of truth.json with the strength, pooled and of each joint (arm: of y, z, roll)."""
    keys = ("y", "z", "roll") if h.stage == "arm" else JOINTS
    per = {key: float(s) for key, s in zip(keys, strength, strict=True)}
    return {**h.told(), "strength": _pooled(strength, h), "strength_per_joint": per}


def draw_case(seed: int, **knobs: Any) -> Case:
    """The concealed arm of a seed. Knobs: the fields of `Knobs`.

    Raises RuntimeError where the asked effects do not come out at the asked strength in 40 attempts.
    """
    asked = Knobs(**knobs)
    for attempt in range(40):
        names = _names(seed, attempt // 10, asked)  # kept for ten motions: not only those that come easily
        rng = np.random.default_rng([seed, attempt])
        made = _try(rng, names, asked)
        if made is not None:
            return _recorded(rng, seed, asked, *made)
    raise RuntimeError(f"seed {seed}: {asked.effects or 'effects'} not brought out at strength {asked.level}")


def _recorded(rng: np.random.Generator, seed: int, knobs: Knobs, motions: Motions, how: Sensing,
              hidden: tuple[Hidden, ...], found: list[Array]) -> Case:  # fmt: skip
    anywhere = bool(knobs.hard and rng.uniform() < 0.3)
    runs = []
    for kind, reference, setpoint in zip(motions.kinds, motions.reference, motions.setpoint, strict=True):
        start = rng.uniform(-1, 1, COUNT) if anywhere else None
        here = replace(how, phase=int(rng.integers(5)) if how.phase else 0)
        runs.append(record(rng, kind, reference, setpoint, run(hidden, setpoint, start), here))
    still = [JOINTS[j] for j in ALL if j not in motions.moving]
    noise = {**asdict(how), "compensator": motions.compensator, "still": still, "anywhere": anywhere}
    truth = [told_with(h, s) for h, s in zip(hidden, found, strict=True)]
    return Case(seed, truth, noise, runs[0], runs[1], hidden)
