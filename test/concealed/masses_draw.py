"""Draws of how an integrated arm is made otherwise, and what that is called."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from test.concealed.draws import ALL, Joints, Rng, logarithmic, signed, sizes
from test.concealed.hidden import Hidden
from test.concealed.masses_arm import Arm, having, soft
from test.concealed.mujoco_draw import SWING, Wish
from test.concealed.nominal import (
    COMPLIANCE,
    COUNT,
    HALF_WIDTH,
    KP,
    LINK,
    MASS,
    RATIO,
    STEP,
    TAU_V,
    Array,
    load,
)


@dataclass(frozen=True)
class Change:
    """What is made otherwise, and what that is called."""

    apply: Callable[[Arm], Arm]
    hidden: Hidden


Draw: TypeAlias = Callable[[Rng, Wish], list[Change]]
MAKE: dict[str, Draw] = {}  # what can be hidden in an arm; each begins from the nominal one
SIMPLE: dict[str, Draw] = {}  # those that go with any of the others


def _make(draw: Draw) -> Draw:
    MAKE[draw.__name__] = draw
    return draw


def _simple(draw: Draw) -> Draw:
    SIMPLE[draw.__name__] = draw
    return _make(draw)


def place(rng: Rng) -> float:
    """Share of the compliance before the friction: none, some, or all (the joint's own friction)."""
    return float(rng.choice([0.0, rng.uniform(0.3, 0.7), 1.0, 1.0]))


def carried(arm: Arm) -> Arm:
    """The weight is carried by something else."""
    return replace(arm, balanced=True)


def _form(upstream: float) -> str:
    return (
        "behind_the_friction" if upstream == 0 else "before_the_friction" if upstream == 1 else "both_sides"
    )


def _sag(rng: Rng, wish: Wish) -> tuple[Joints, Array, float]:
    """Joints on soft wires, their compliance, and the payload at the tip."""
    if rng.uniform() < 0.5:
        return ALL, COMPLIANCE * rng.uniform(0.7, 1.4), float(logarithmic(rng, 0.01, 0.1))
    base = COMPLIANCE[list(wish.joints)]
    compliance = np.clip(wish.per(load(wish.theta)) * sizes(rng, len(base)), 0.02 * base, 3 * base)
    return wish.joints, compliance, 0.0


def _loaded(joints: Joints, compliance: Array, payload: float, upstream: float) -> Change:
    same = ("compliance", "payload") if payload else ("compliance",)
    told = Hidden(
        "load_elasticity", joints, _form(upstream), {"compliance": compliance, "payload": payload}, same
    )
    return Change(lambda b: replace(soft(b, joints, compliance, upstream), payload=payload), told)


@_make
def load_elasticity(rng: Rng, wish: Wish) -> list[Change]:
    """Wires that stretch, before the friction, behind it, or both."""
    return [_loaded(*_sag(rng, wish), place(rng))]


@_make
def wire_stiffening(rng: Rng, wish: Wish) -> list[Change]:
    """Wires whose strands settle: stiffer under load, which changes the joint's dead band as well."""
    payload, upstream = float(logarithmic(rng, 0.01, 0.1)), float(rng.integers(2))
    soft_ = COMPLIANCE * rng.uniform(1.0, 2.0)
    hard = rng.uniform(0.25, 0.6, COUNT) * np.abs(load(wish.theta, payload)).max(axis=0)
    values = {"compliance": soft_, "moment": np.sqrt(3) * hard, "payload": payload}
    told = Hidden("wire_stiffening", ALL, _form(upstream), values)

    def apply(b: Arm) -> Arm:
        return replace(_behind_capstan(b, ALL, soft_, upstream), hard=hard, payload=payload)

    return [Change(apply, told)]


def _behind_capstan(b: Arm, joints: Joints, compliance: Array, upstream: float) -> Arm:
    """All the compliance in the wire behind the capstan; upstream 1: the friction is the joint's own."""
    behind = soft(b, joints, compliance, 0.0)
    if upstream < 1:
        return behind
    width = HALF_WIDTH[list(joints)]
    return having(behind, joints, capstan=0.0, joint=width / (behind.before + behind.after)[list(joints)])


@_make
def wire_slack(rng: Rng, wish: Wish) -> list[Change]:
    """Pairs of wires that can only pull, barely tightened."""
    payload, upstream = float(logarithmic(rng, 0.01, 0.1)), float(rng.integers(2))
    threshold = rng.uniform(0.25, 0.6, COUNT) * np.abs(load(wish.theta, payload)).max(axis=0)
    values = {"compliance": COMPLIANCE.copy(), "threshold": threshold, "payload": payload}
    told = Hidden("wire_slack", ALL, _form(upstream), values)

    def apply(b: Arm) -> Arm:
        return replace(_behind_capstan(b, ALL, COMPLIANCE, upstream), slack=threshold, payload=payload)

    return [Change(apply, told)]


@_make
def viscoelastic_creep(rng: Rng, wish: Wish) -> list[Change]:
    """A sheath pulls the joint to its middle, the wire goes on giving way; the wheel makes good the rest.

    The gain is told as the effect has it: before the friction per joint angle, behind it as a share of what
    the joint would be at without, which both springs take their part of.
    """
    joints, late, upstream = wish.joints, float(logarithmic(rng, 1.5, 15.0)), float(rng.integers(2))
    gain = np.clip(wish.per(wish.theta) * sizes(rng, len(joints)), 1e-3, 0.06)
    some = COMPLIANCE[list(joints)] / 4
    skin = np.full(len(joints), 4.0)
    shows = gain if upstream else gain / (1 + skin * some + gain)
    values = {"gain": shows, "time_constant": late}
    told = Hidden("viscoelastic_creep", joints, _form(upstream), values, ("gain",))

    def apply(b: Arm) -> Arm:
        made = _behind_capstan(carried(b), joints, some, upstream)
        gives = (made.before + made.after)[list(joints)]
        return having(made, joints, skin=skin, creep=gain / skin, late=late, wheel=1 + skin * gives)

    return [Change(apply, told)]


def _rubs(arm: Arm, joints: Joints) -> Arm:
    """Real wires, weight carried, the friction in the joints."""
    return soft(carried(arm), joints, COMPLIANCE[list(joints)], 1.0)


@_make
def stribeck_friction(rng: Rng, wish: Wish) -> list[Change]:
    """Joints whose friction falls with speed, after the time that a film of oil takes."""
    joints, extra = wish.joints, wish.size * 2.0 * sizes(rng, len(wish.joints))
    speed = float(logarithmic(rng, 0.02, 0.12))
    lag = np.maximum(0.05, 2 * extra / speed)
    told = Hidden("stribeck_friction", joints, "film", {"amplitude": extra, "velocity": speed})

    def apply(b: Arm) -> Arm:
        return having(_rubs(b, joints), joints, static=extra / COMPLIANCE[list(joints)], speed=speed, lag=lag)

    return [Change(apply, told)]


@_make
def presliding_hysteresis(rng: Rng, wish: Wish) -> list[Change]:
    """Joints whose friction bends bristles before it slides."""
    joints, base = wish.joints, COMPLIANCE[list(wish.joints)]
    wide = HALF_WIDTH[list(joints)] + wish.size * rng.uniform(1.0, 2.0, len(joints))
    bristle = rng.uniform(0.7, 3.0, len(joints)) / base
    told = Hidden("presliding_hysteresis", joints, "bristles", {"reaches": wide})

    def apply(b: Arm) -> Arm:
        return having(_rubs(b, joints), joints, joint=wide / base, bristle=bristle)

    return [Change(apply, told)]


@_make
def load_dependent_friction(rng: Rng, wish: Wish) -> list[Change]:
    """A wire round a post: friction in proportion to what it carries; it stretches as it has to."""
    joints, upstream = ALL, float(rng.uniform(0.4, 0.7))
    before = upstream * COMPLIANCE
    gain = np.clip(
        replace(wish, joints=ALL).per(load(wish.theta)) * rng.uniform(0.7, 1.4, COUNT), 0, 0.6 * before
    )
    told = Hidden("load_dependent_friction", joints, "capstan", {"gain": gain}, ("gain",))
    return [
        _loaded(ALL, COMPLIANCE.copy(), 0.0, upstream),
        Change(lambda b: replace(b, grip=gain / b.before), told),
    ]


@_make
def backlash(rng: Rng, wish: Wish) -> list[Change]:
    """Play at the wheel, in a stiff wire or in a real one whose weight is carried."""
    joints, gap, real = wish.joints, wish.size * sizes(rng, len(wish.joints)), bool(rng.uniform() < 0.5)
    told = Hidden("backlash", joints, "gap", {"half_width": gap}, ("half_width",))
    return [Change(lambda b: having(_rubs(b, joints) if real else b, joints, gap=gap), told)]


@_simple
def tension_error(rng: Rng, wish: Wish) -> list[Change]:
    """Everything is pressed harder."""
    factor = 1 + wish.size / float(HALF_WIDTH.mean())
    told = Hidden("tension_error", ALL, "pressed", {"factor": factor}, ("factor",))
    return [Change(lambda b: replace(b, capstan=b.capstan * factor, joint=b.joint * factor), told)]


@_simple
def ratio_error(rng: Rng, wish: Wish) -> list[Change]:
    """A wheel of another radius."""
    relative = wish.per(wish.theta) * signed(rng, len(wish.joints))
    told = Hidden("ratio_error", wish.joints, "wheel", {"relative": relative}, ("relative",))
    return [Change(lambda b: having(b, wish.joints, wheel=b.wheel[list(wish.joints)] * (1 + relative)), told)]


@_simple
def joint_coupling(rng: Rng, wish: Wish) -> list[Change]:
    """A wire that is led round another joint."""
    source = int(rng.integers(COUNT - 1))
    joints = tuple(j for j in wish.joints if j > source) or (int(rng.integers(source + 1, COUNT)),)
    gain = np.clip(replace(wish, joints=(source,)).per(wish.theta), 0, 0.2) * signed(rng, len(joints))
    told = Hidden("joint_coupling", joints, "route", {"gain": gain, "source": source}, ("gain", "source"))

    def apply(b: Arm) -> Arm:
        route = b.route.copy()
        route[list(joints), source] = gain
        return replace(b, route=route)

    return [Change(apply, told)]


@_simple
def zero_offset(rng: Rng, wish: Wish) -> list[Change]:
    """A wire that was cut too long."""
    offset = wish.size * signed(rng, len(wish.joints))
    told = Hidden("zero_offset", wish.joints, "rest_length", {"offset": offset}, ("offset",))
    return [Change(lambda b: having(b, wish.joints, zero=offset), told)]


@_make
def link_resonance(rng: Rng, wish: Wish) -> list[Change]:
    """A soft wire behind the friction; the links beyond it swing, their weight carried by something else."""
    j = min(wish.joints[0], SWING - 1)
    fast = np.sqrt((np.gradient(wish.speed[:, j], STEP) ** 2).mean())
    turn = float(np.clip(np.sqrt(fast / wish.size), 2 * np.pi * 3.0, 2 * np.pi * 15.0))
    damping = float(logarithmic(rng, 0.05, 0.2))
    inertia = float((MASS[j:] * (LINK * (np.arange(COUNT) - j + 0.5)[j:]) ** 2).sum())
    gives = np.array([1 / (inertia * turn**2)])
    values = {"frequency": np.array([turn / (2 * np.pi)]), "damping": damping}

    def apply(b: Arm) -> Arm:
        swings = soft(replace(b, balanced=True, light=1.0), (j,), gives, 0.0)
        return having(swings, (j,), damped=2 * damping / turn)

    return [Change(apply, Hidden("link_resonance", (j,), "swinging_links", values))]


@_make
def viscous_lag(rng: Rng, wish: Wish) -> list[Change]:
    """Joints in grease, on wires that give way to the drag alone."""
    joints, base = wish.joints, COMPLIANCE[list(wish.joints)]
    late = np.clip(wish.per(wish.speed) * sizes(rng, len(joints)), 1e-4, 0.08)
    told = Hidden("viscous_lag", joints, "grease", {"time_constant": late}, ("time_constant",))
    return [Change(lambda b: having(soft(carried(b), joints, base, 0.0), joints, drag=late / base), told)]


@_make
def load_droop(rng: Rng, wish: Wish) -> list[Change]:
    """Motors of finite inertia whose loops have no integral part; the friction is the joints' own."""
    gain = float(np.clip(wish.size / RATIO / np.sqrt((load(wish.theta) ** 2).mean()), 1e-3, 0.05))
    told = Hidden("load_droop", ALL, "motor", {"gain": gain}, ("gain",))
    return [
        _loaded(ALL, COMPLIANCE.copy(), 0.0, 1.0),
        Change(lambda b: replace(b, gives=gain * KP / (TAU_V * RATIO)), told),
    ]


@_make
def servo_bandwidth(rng: Rng, wish: Wish) -> list[Change]:
    """Position loops with another gain."""
    shows = wish.size * KP / float(np.sqrt((wish.speed**2).mean()))
    relative = float(np.clip(shows, 0.02, 0.4) * rng.choice([-1.0, 1.0]))
    told = Hidden("servo_bandwidth", ALL, "gain", {"relative": relative}, ("relative",))
    return [Change(lambda b: replace(b, gain=b.gain * (1 + relative)), told)]


@_make
def whole(rng: Rng, wish: Wish) -> list[Change]:
    """Real wires under links of real mass: they stretch, and the links swing."""
    told = Hidden("link_resonance", ALL, "whole_arm", {})
    return [
        _loaded(ALL, COMPLIANCE.copy(), float(logarithmic(rng, 0.01, 0.05)), place(rng)),
        Change(
            lambda b: replace(b, light=1.0, damped=np.full(COUNT, float(logarithmic(rng, 2e-3, 6e-3)))), told
        ),
    ]
