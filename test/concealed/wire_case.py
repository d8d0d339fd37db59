"""Concealed arms whose wires are finite elements: what is hidden is a pretension or a soft coating."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import cache

import numpy as np

from test.concealed.case import Case, Knobs, draw_motions, told_with
from test.concealed.draws import ALL, logarithmic
from test.concealed.hidden import Hidden
from test.concealed.nominal import COUNT, HALF_WIDTH, RATIO, STEP, Array, load, tip
from test.concealed.plant import Motion
from test.concealed.sensing import draw_sensing, record
from test.concealed.servo import run_servo
from test.concealed.wire_fe import Pair, joint_angle, pair_of

KINDS = ("clean", "backlash", "tension_error", "presliding_hysteresis")
SOFT = 3e7 / 20  # shear stiffness of a coating per N of pretension: its slip begins within the dead band
_THERE = np.concatenate([np.linspace(0, 0.1, 200), np.linspace(0.1, 0.0, 1000)])


def _reversal(pair: Pair) -> tuple[float, float]:
    """Half the dead band in full slip, and half the travel after a reversal until the joint follows, rad."""
    u = _THERE * (0.02 + 0.002 * pair.tension)
    angle = joint_angle(pair, u / RATIO)
    follows = np.argmax(np.diff(angle[200:]) < 0.98 * np.diff(u[200:]))
    return float(angle[-1] - u[-1]), float((u[199] - u[200 + follows]) / 2)


@cache
def nominal_pair(joint: int) -> Pair:
    """Wires of joint 0 ... 4 with the pretension whose dead band is the nominal one; it is proportional."""
    once, _ = _reversal(pair_of(joint, 10.0))
    return pair_of(joint, 10.0 * float(HALF_WIDTH[joint]) / once)


def _wires(kind: str, joints: tuple[int, ...], size: Array) -> tuple[list[Pair], Hidden | None]:
    """Wires of all joints, ``size`` times the nominal pretension on those named, and what that is called."""
    pairs = [nominal_pair(j) for j in ALL]
    if kind == "clean":
        return pairs, None
    for j in joints:
        pairs[j] = replace(pairs[j], tension=pairs[j].tension * size[j])
        if kind == "presliding_hysteresis":
            pairs[j] = replace(pairs[j], shear=SOFT * pairs[j].tension)
    if kind == "tension_error":
        return pairs, Hidden(kind, ALL, "finite_elements", {"factor": float(size[0])}, ("factor",))
    some = list(joints)
    if kind == "backlash":
        more = ((size - 1) * HALF_WIDTH)[some]
        return pairs, Hidden(kind, joints, "finite_elements", {"half_width": more}, ("half_width",))
    slid = np.array([_reversal(pairs[j])[1] for j in joints]) - HALF_WIDTH[some]
    return pairs, Hidden(kind, joints, "finite_elements", {"width": slid})


def _angles(pairs: list[Pair], phi: Array) -> Array:
    """Joint angles (n, 5); each wire first goes from 0 to where the run begins, which sets its friction."""
    out = np.empty_like(phi)
    for j, pair in enumerate(pairs):
        to = np.linspace(0.0, phi[0, j], 50)
        out[:, j] = joint_angle(pair, np.concatenate([to, phi[:, j]]))[50:]
    return out


def _motion(pairs: list[Pair], setpoint: Array) -> Motion:
    phi, v = run_servo((), setpoint, 0.0)
    theta, t = _angles(pairs, phi), np.arange(len(phi), dtype=np.float64) * STEP
    return Motion(t, phi, v, theta, theta, load(theta), tip(theta))


def _sizes(rng: np.random.Generator, kind: str, wanted: float) -> tuple[tuple[int, ...], Array]:
    """Joints, and the pretension (5,) over nominal that widens their dead band by about ``wanted`` rad."""
    if kind == "tension_error":
        return ALL, np.full(COUNT, 1 + wanted / float(HALF_WIDTH.mean()))
    joints = rng.choice(COUNT, int(rng.integers(1, 4)), replace=False)
    return tuple(sorted(int(j) for j in joints)), 1 + wanted * rng.uniform(0.8, 1.25, COUNT) / HALF_WIDTH


def draw_wire_case(seed: int, kind: str | None = None, level: tuple[float, float] = (1.0, 30.0)) -> Case:
    """A concealed arm of finite-element wires; kind: one of KINDS, in turn where None."""
    rng = np.random.default_rng([seed, 2])
    kind = kind or KINDS[seed % len(KINDS)]
    asked, how = draw_motions(rng, Knobs()), draw_sensing(rng, False, bool(rng.uniform() < 0.3))
    pairs, hidden = _wires(kind, *_sizes(rng, kind, float(logarithmic(rng, *level)) * how.noise / 0.9))
    done = [_motion(pairs, setpoint) for setpoint in asked.setpoint]
    runs = [
        record(rng, name, reference, setpoint, motion, how)
        for name, reference, setpoint, motion in zip(
            asked.kinds, asked.reference, asked.setpoint, done, strict=True
        )
    ]
    truth = []
    if hidden is not None:
        apart = done[0].theta - _angles([nominal_pair(j) for j in ALL], done[0].phi)
        truth = [told_with(hidden, np.sqrt((apart**2).mean(axis=0)) / how.noise)]
    return Case(seed, truth, {**asdict(how), "plant": "finite elements"}, runs[0], runs[1])
