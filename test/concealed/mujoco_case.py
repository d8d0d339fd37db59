"""Concealed arms in MuJoCo: what is hidden is how the arm is built, not a formula of what that does."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from test.concealed.case import Case, Knobs, draw_motions, told_with
from test.concealed.draws import ALL, logarithmic
from test.concealed.hidden import Hidden
from test.concealed.mujoco_arm import Build, run_mujoco
from test.concealed.mujoco_draw import BUILD, Change, Wish
from test.concealed.nominal import COMPLIANCE, COUNT, STEP, Array, load, nominal_wire
from test.concealed.plant import Motion
from test.concealed.sensing import Sensing, draw_sensing, record
from test.concealed.servo import run_servo

PAIRED = ("backlash", "tension_error", "ratio_error", "joint_coupling", "zero_offset", "load_elasticity",
          "base_tilt", "link_length_error", "sensor_delay")  # fmt: skip
KINDS = (*BUILD, "whole", "pair")
SHOWS = 1.0  # strength from which a whole arm's joint counts as swinging


def _wished(rng: np.random.Generator, name: str, level: tuple[float, float], noise: float,
            theta: Array) -> Change:  # fmt: skip
    some = rng.choice(COUNT, int(rng.integers(1, 4)), replace=False)
    joints = tuple(sorted(int(j) for j in some))
    return BUILD[name](rng, Wish(joints, noise * float(logarithmic(rng, *level)), noise, theta))


def _whole(rng: np.random.Generator) -> list[Change]:
    """Wires of their real stiffness under links of their real mass: they stretch, and the links swing."""
    payload = float(logarithmic(rng, 0.01, 0.05))
    values = {"compliance": COMPLIANCE, "payload": payload}
    gives = Hidden("load_elasticity", ALL, "whole_arm", values, ("compliance", "payload"))
    swings = Hidden("link_resonance", ALL, "whole_arm", {})
    settle = np.full(COUNT, float(logarithmic(rng, 1e-3, 4e-3)))
    soft: dict[str, Any] = {"compliance": COMPLIANCE.copy(), "payload": payload, "settle": settle}
    return [
        Change(lambda b: replace(b, **soft, light=100.0), gives),
        Change(lambda b: replace(b, light=1.0), swings),
    ]


def _built(changes: list[Change]) -> Build:
    b = Build()
    for change in changes:
        b = change.apply(b)
    return b


def _moved(changes: list[Change], servo: tuple[Array, Array]) -> Motion:
    """The arm with the changes under what its servos do, as it is to be recorded."""
    b = _built(changes)
    ran = run_mujoco(b, *servo)
    t = np.arange(len(ran.phi), dtype=np.float64) * STEP
    late = sum(change.late for change in changes)
    shown = np.stack([np.interp(t - late, t, column) for column in ran.theta.T], axis=1)
    return Motion(t, ran.phi, ran.v, shown, ran.theta, load(ran.theta, b.payload), ran.tip)


def _strength(with_: Motion, without: Motion, hidden: Hidden, how: Sensing) -> Array:
    if hidden.stage == "arm":
        noise = np.array([how.tip_noise_m, how.tip_noise_m, how.tip_noise_rad])
        return np.asarray(np.sqrt(((with_.tip - without.tip) ** 2).mean(axis=0)) / noise)
    # of the same wheel angle: the nominal wire takes out what little the wheels differ
    apart = (with_.theta - nominal_wire(with_.phi)) - (without.theta - nominal_wire(without.phi))
    return np.asarray(np.sqrt((apart**2).mean(axis=0)) / how.noise)


def _changes(rng: np.random.Generator, kind: str, level: tuple[float, float], noise: float,
             theta: Array) -> list[Change]:  # fmt: skip
    """What is built otherwise."""
    if kind == "whole":
        return _whole(rng)
    names = {"clean": [], "pair": [str(name) for name in rng.choice(PAIRED, 2, replace=False)]}
    return [_wished(rng, name, level, noise, theta) for name in names.get(kind, [kind])]


def _told(
    changes: list[Change], servo: tuple[Array, Array], whole: Motion, how: Sensing
) -> list[dict[str, Any]]:
    """Entries of truth.json; the strength of each change is what the engine shows with it and without."""
    out = []
    for n, change in enumerate(changes):
        others = changes[:n] + changes[n + 1 :]
        strength = _strength(whole, _moved(others, servo), change.hidden, how)
        if change.hidden.form == "whole_arm" and change.hidden.effect == "link_resonance":
            joints = tuple(j for j in ALL if strength[j] > SHOWS)
            change = replace(change, hidden=replace(change.hidden, joints=joints))
        if change.hidden.joints:
            out.append(told_with(change.hidden, strength))
    return out


def draw_mujoco_case(
    seed: int, kind: str | None = None, level: tuple[float, float] = (1.0, 30.0), seconds: float = 60.0
) -> Case:
    """A concealed arm in MuJoCo; kind: one of KINDS, in turn where None, or "clean"."""
    rng = np.random.default_rng([seed, 3])
    asked, how = (
        draw_motions(rng, Knobs(seconds=seconds)),
        draw_sensing(rng, False, bool(rng.uniform() < 0.3)),
    )
    servos = [run_servo((), setpoint, 0.0) for setpoint in asked.setpoint]
    theta = nominal_wire(servos[0][0])
    changes = _changes(rng, kind or KINDS[seed % len(KINDS)], level, how.noise, theta)
    how = replace(how, tip=how.tip or any(c.hidden.stage == "arm" for c in changes))
    done = [_moved(changes, servo) for servo in servos]
    truth = _told(changes, servos[0], done[0], how)
    runs = [
        record(rng, name, reference, setpoint, motion, how)
        for name, reference, setpoint, motion in zip(
            asked.kinds, asked.reference, asked.setpoint, done, strict=True
        )
    ]
    return Case(seed, truth, {**asdict(how), "plant": "MuJoCo"}, runs[0], runs[1])
