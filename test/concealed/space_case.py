"""Concealed arms in space: what is built otherwise is drawn by a seed, two motions are recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from test.concealed.space_arm import URDFS, Array, Built, Plant, nothing

RATE, SECONDS = 100.0, 60.0
JOINT_NOISE, PLACE_NOISE, TURN_NOISE = 1e-4, 1e-4, 5e-4


@dataclass(frozen=True)
class Hidden:
    """An effect in the contract's words, the joints that have it, and other names that say the same."""

    effect: str
    joints: tuple[str, ...]
    same: tuple[str, ...] = ()


@dataclass(frozen=True)
class Recorded:
    """One motion: stamps (n,), motors, joints as read and true (n, joints), tip as read and true (n, 7)."""

    stamp: Array
    motors: Array
    joints: Array
    true: Array
    tip: Array
    true_tip: Array


@dataclass(frozen=True)
class SpaceCase:
    """What the diagnosis gets (URDF, coupling, recordings) and what it does not."""

    seed: int
    arm: str
    joints: tuple[str, ...]
    coupling: Array
    truth: tuple[Hidden, ...]
    train: Recorded
    test: Recorded


Draw = Callable[[np.random.Generator, Built, Plant], Hidden]


def _size(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _side(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _backlash(rng: np.random.Generator, b: Built, plant: Plant) -> Hidden:
    j = int(rng.integers(len(plant.joints)))
    b.half_width[j] = _size(rng, 5e-4, 4e-3) * _reach(plant)[j]
    return Hidden("backlash", (plant.joints[j],))


def _ratio(rng: np.random.Generator, b: Built, plant: Plant) -> Hidden:
    j = int(rng.integers(len(plant.joints)))
    b.ratio[j] = plant.turns[j] * _side(rng) * _size(rng, 0.004, 0.03)
    return Hidden("ratio_error", (plant.joints[j],))


def _zero(rng: np.random.Generator, b: Built, plant: Plant) -> Hidden:
    j = int(rng.integers(len(plant.joints)))
    b.zero[j] = _side(rng) * _size(rng, 2e-3, 1e-2) * _reach(plant)[j]
    return Hidden("zero_offset", (plant.joints[j],))


def _stretch(rng: np.random.Generator, b: Built, plant: Plant) -> Hidden:
    """All wires whose load changes give way, by a few milliradians."""
    carried = np.ptp(plant.load(_postures(rng, plant)), axis=0)  # what is constant is a zero
    loaded = carried > 1e-6 * carried.max()
    sag = np.array([_size(rng, 2e-3, 1e-2) for _ in plant.joints]) * _reach(plant)
    b.compliance[loaded] = sag[loaded] / carried[loaded]
    names = tuple(name for name, yes in zip(plant.joints, loaded, strict=True) if yes)
    return Hidden("load_elasticity", names)


def _capstan(rng: np.random.Generator, b: Built, plant: Plant) -> Hidden:
    carried = np.abs(plant.load(_postures(rng, plant))).max(axis=0)
    j = int(np.argmax(carried))
    b.friction[j] = _size(rng, 1e-3, 4e-3) * _reach(plant)[j] / carried[j]
    return Hidden("load_dependent_friction", (plant.joints[j],))


def _link(rng: np.random.Generator, b: Built, plant: Plant) -> Hidden:
    """A link is longer: the next one's place moves on along the line that leads there."""
    longer = [
        body for body in range(2, plant.model.nbody) if np.linalg.norm(plant.model.body_pos[body]) > 0.02
    ]
    body = int(rng.choice(longer))
    way = plant.model.body_pos[body] / np.linalg.norm(plant.model.body_pos[body])
    name = plant.model.body(body).name
    b.moved[name] = way * _side(rng) * _size(rng, 5e-4, 3e-3), np.zeros(3)
    joint = plant.joints[int(plant.model.body_dofadr[plant.model.body_parentid[body]])]
    return Hidden("link_length_error", (joint,), ("tool_offset", "base_shift", "link_offset_error"))


def _tool(rng: np.random.Generator, b: Built, plant: Plant) -> Hidden:
    b.moved["tool0"] = rng.normal(size=3) * 1e-3, rng.normal(size=3) * 4e-3
    return Hidden("tool_offset", ())


def _postures(rng: np.random.Generator, plant: Plant) -> Array:
    return np.asarray(rng.uniform(*plant.limits.T, (200, len(plant.joints))))


def _reach(plant: Plant) -> Array:
    """(joints,): half of the range, at most 1: what sizes are told in."""
    return np.asarray(np.minimum(np.ptp(plant.limits, axis=1) / 2, 1.0))


KINDS: dict[str, Draw] = {
    "backlash": _backlash, "ratio_error": _ratio, "zero_offset": _zero, "load_elasticity": _stretch,
    "load_dependent_friction": _capstan, "link_length_error": _link, "tool_offset": _tool,
}  # fmt: skip


def draw_case(seed: int) -> SpaceCase:
    """One arm of the five, by its seed: of four one is clean, two hide one effect and one hides two."""
    rng = np.random.default_rng((19, seed))
    arm = sorted(URDFS)[seed % len(URDFS)]
    bare = Plant(arm, nothing(1), np.zeros((1, 1)))
    joints = len(bare.joints)
    turns = np.diag(rng.uniform(0.3, 0.9, joints))
    if arm == "wrist":  # pitch and yaw by two motors together and against each other
        turns[1:, 1:] = 0.5 * np.array([[1.0, 1.0], [1.0, -1.0]])
    count = (1, 2, 0, 1)[seed // len(URDFS) % 4]
    plain = Plant(arm, nothing(joints), turns)
    built = nothing(joints)
    kinds = rng.choice(list(KINDS), count, replace=False)
    truth = tuple(KINDS[kind](rng, built, plain) for kind in kinds)
    plant = Plant(arm, built, turns)
    runs = [_recorded(rng, plant) for _ in range(2)]
    return SpaceCase(seed, arm, tuple(plant.joints), turns, truth, *runs)


def _recorded(rng: np.random.Generator, plant: Plant) -> Recorded:
    stamp = np.arange(int(RATE * SECONDS)) / RATE
    motors = np.linalg.solve(plant.turns, _motion(rng, plant, stamp).T).T
    true = plant.joints_of(motors)
    tip = plant.tip(true)
    shown = tip + np.hstack([PLACE_NOISE * rng.normal(size=(len(tip), 3)), np.zeros((len(tip), 4))])
    shown[:, 3:] = _shaken(rng, tip[:, 3:])
    joints = true + plant.built.zero + JOINT_NOISE * rng.normal(size=true.shape)
    return Recorded(stamp, motors, joints, true, shown, tip)


def _motion(rng: np.random.Generator, plant: Plant, stamp: Array) -> Array:
    """Wanted joint angles (n, joints): slow and fast sines with holds, over most of the range."""
    middle, half = plant.limits.mean(axis=1), np.ptp(plant.limits, axis=1) / 2
    out = np.empty((len(stamp), len(plant.joints)))
    for j in range(out.shape[1]):
        rests = np.clip(1.6 * np.sin(2 * np.pi * rng.uniform(0.03, 0.06) * stamp + rng.uniform(0, 6)), -1, 1)
        quick = sum(np.sin(2 * np.pi * rng.uniform(0.1, 0.5) * stamp + rng.uniform(0, 6)) for _ in range(2))
        moved = rests + 0.25 * quick * (np.abs(rests) < 1.0)
        moved = np.convolve(np.pad(moved, 25, "edge"), np.hanning(51) / np.hanning(51).sum(), "valid")
        out[:, j] = middle[j] + 0.7 * min(half[j], 1.2) * moved / np.abs(moved).max()
    return out


def _shaken(rng: np.random.Generator, quat: Array) -> Array:
    """Quaternions x, y, z, w, each turned a little."""
    x, y, z = (TURN_NOISE / 2 * rng.normal(size=len(quat)) for _ in range(3))
    a, b, c, w = quat.T
    turned = [a + x * w + y * c - z * b, b + y * w + z * a - x * c, c + z * w + x * b - y * a,
              w - x * a - y * b - z * c]  # fmt: skip
    out = np.column_stack(turned)
    return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))
