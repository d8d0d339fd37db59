"""Draws of how an arm in MuJoCo differs from the nominal one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from test.concealed.draws import ALL, Joints, Rng, logarithmic, sign, signed, sizes
from test.concealed.hidden import Hidden
from test.concealed.mujoco_arm import Build
from test.concealed.nominal import COMPLIANCE, COUNT, HALF_WIDTH, LINK, MASS, STEP, Array, load

TIP_NOISE = (3e-5, 2e-4)  # m, rad
SWING = 4  # joints from this one on never swing alone: too light


@dataclass(frozen=True)
class Wish:
    """Joints to hide something on, how much it shall show, rad rms, and what the nominal joints do (n, 5)."""

    joints: Joints
    size: float
    noise: float
    theta: Array

    @property
    def speed(self) -> Array:
        """rad/s, (n, 5)."""
        out: Array = np.gradient(self.theta, STEP, axis=0)
        return out

    def per(self, x: Array) -> Array:
        """Sizes, (len(joints),), with which x (n, 5) shows as wished."""
        out: Array = self.size / np.maximum(np.sqrt((x[:, list(self.joints)] ** 2).mean(axis=0)), 1e-9)
        return out


@dataclass(frozen=True)
class Change:
    """What is built otherwise, and what that is called. late: s by which the joint sensors lag."""

    apply: Callable[[Build], Build]
    hidden: Hidden
    late: float = 0.0


Draw: TypeAlias = Callable[[Rng, Wish], Change]
BUILD: dict[str, Draw] = {}


def _build(draw: Draw) -> Draw:
    BUILD[draw.__name__] = draw
    return draw


def _with(x: Array, joints: Joints, values: Array | float) -> Array:
    out = x.copy()
    out[list(joints)] = values
    return out


@_build
def backlash(rng: Rng, wish: Wish) -> Change:
    """The wire to the pulley has play; friction holds the joint within it."""
    gap = wish.size * sizes(rng, len(wish.joints))
    told = Hidden("backlash", wish.joints, "gap", {"half_width": gap}, ("half_width",))
    return Change(lambda b: replace(b, gap=_with(b.gap, wish.joints, gap)), told)


@_build
def tension_error(rng: Rng, wish: Wish) -> Change:
    """Every pulley is pressed harder: its friction grows in proportion."""
    factor = 1 + wish.size / float(HALF_WIDTH.mean())
    told = Hidden("tension_error", ALL, "pressed", {"factor": factor}, ("factor",))
    return Change(lambda b: replace(b, friction=b.friction * factor), told)


@_build
def ratio_error(rng: Rng, wish: Wish) -> Change:
    """A wheel of another radius."""
    relative = wish.per(wish.theta) * signed(rng, len(wish.joints))
    told = Hidden("ratio_error", wish.joints, "wheel", {"relative": relative}, ("relative",))
    return Change(lambda b: replace(b, wheel=_with(b.wheel, wish.joints, 1 + relative)), told)


@_build
def joint_coupling(rng: Rng, wish: Wish) -> Change:
    """The wire to an outer joint is led around a joint on its way."""
    source = int(rng.integers(COUNT - 1))
    joints = tuple(j for j in wish.joints if j > source) or (int(rng.integers(source + 1, COUNT)),)
    gain = replace(wish, joints=(source,)).per(wish.theta) * signed(rng, len(joints))
    told = Hidden("joint_coupling", joints, "route", {"gain": gain, "source": source}, ("gain", "source"))

    def apply(b: Build) -> Build:
        route = b.route.copy()
        route[list(joints), source] = gain
        return replace(b, route=route)

    return Change(apply, told)


@_build
def zero_offset(rng: Rng, wish: Wish) -> Change:
    """A wire that was cut too long."""
    offset = wish.size * signed(rng, len(wish.joints))
    told = Hidden("zero_offset", wish.joints, "rest_length", {"offset": offset}, ("offset",))
    return Change(lambda b: replace(b, zero=_with(b.zero, wish.joints, offset)), told)


@_build
def load_elasticity(rng: Rng, wish: Wish) -> Change:
    """Wires with the stiffness of their section, on all joints and with a payload or on some without."""
    whole = rng.uniform() < 0.4
    joints, payload = (ALL, float(logarithmic(rng, 0.01, 0.1))) if whole else (wish.joints, 0.0)
    soft = COMPLIANCE[list(joints)]
    if not whole:
        soft = np.clip(wish.per(load(wish.theta)) * sizes(rng, len(joints)), 0.02 * soft, 3 * soft)
    same = ("compliance", "payload") if whole else ("compliance",)
    values = {"compliance": soft, "payload": payload}
    told = Hidden("load_elasticity", joints, "tendon", values, same)
    return Change(lambda b: _soft(b, joints, soft, payload), told)


def _soft(b: Build, joints: Joints, soft: Array, payload: float = 0.0, light: float = 100.0) -> Build:
    """Soft wires; with light links their swinging does not show."""
    compliance = _with(b.compliance, joints, soft)
    return replace(b, compliance=compliance, payload=max(payload, b.payload), light=light)


@_build
def wire_slack(rng: Rng, wish: Wish) -> Change:
    """Pairs of wires that can only pull, barely tightened: under load one of them hangs."""
    payload = float(logarithmic(rng, 0.01, 0.1))
    top = np.abs(load(wish.theta, payload)).max(axis=0)
    joints = ALL if rng.uniform() < 0.5 else tuple(sorted({0, *wish.joints}))
    soft, threshold = COMPLIANCE[list(joints)], rng.uniform(0.2, 0.6, len(joints)) * top[list(joints)]
    values = {"compliance": soft, "threshold": threshold, "payload": payload}
    told = Hidden("wire_slack", joints, "two_tendons", values, ("threshold", "payload"))

    def apply(b: Build) -> Build:
        return replace(_soft(b, joints, soft, payload), slack=_with(b.slack, joints, threshold))

    return Change(apply, told)


@_build
def link_resonance(rng: Rng, wish: Wish) -> Change:
    """A soft wire on one joint; the links beyond it swing, their weight carried by something else."""
    j = min(wish.joints[0], SWING - 1)
    fast = np.sqrt((np.gradient(wish.speed[:, j], STEP) ** 2).mean())
    turn = float(np.clip(np.sqrt(fast / wish.size), 2 * np.pi * 3.0, 2 * np.pi * 15.0))
    damping = float(logarithmic(rng, 0.05, 0.2))
    arms = LINK * (np.arange(COUNT) - j + 0.5)
    inertia = float((MASS[j:] * arms[j:] ** 2).sum())
    soft = 1 / (inertia * turn**2)
    values = {"frequency": np.array([turn / (2 * np.pi)]), "damping": damping}
    told = Hidden("link_resonance", (j,), "swinging_links", values)

    def apply(b: Build) -> Build:
        compliance, settle = _with(b.compliance, (j,), soft), _with(b.settle, (j,), 2 * damping / turn)
        return replace(b, compliance=compliance, settle=settle, balanced=True)

    return Change(apply, told)


@_build
def viscous_lag(rng: Rng, wish: Wish) -> Change:
    """Joints in grease, on wires that give way to the drag alone: the weight is carried."""
    late = np.clip(wish.per(wish.speed) * sizes(rng, len(wish.joints)), 1e-4, 0.08)
    soft = COMPLIANCE[list(wish.joints)]
    told = Hidden("viscous_lag", wish.joints, "grease", {"time_constant": late}, ("time_constant",))

    def apply(b: Build) -> Build:
        drag = _with(b.drag, wish.joints, late / soft)
        return replace(_soft(b, wish.joints, soft), drag=drag, balanced=True)

    return Change(apply, told)


@_build
def hard_stop(rng: Rng, wish: Wish) -> Change:
    """A joint that meets a stop; its wire gives way, as it has to."""
    j, side = wish.joints[0], int(rng.integers(2))
    way = (1.0 if side else -1.0) * wish.theta[:, j]
    limits = np.linspace(way.max(), np.median(way), 200)
    shown = [float(np.sqrt((np.maximum(way - x, 0.0) ** 2).mean())) for x in limits]
    limit = float(limits[np.argmax(np.array(shown) > wish.size)]) * (1.0 if side else -1.0)
    name = ("lower", "upper")[side]
    told = Hidden("hard_stop", (j,), "limit", {name: np.array([limit])}, (name,))

    def apply(b: Build) -> Build:
        stops = b.stops.copy()
        stops[j, side] = limit
        settled = _with(b.settle, (j,), 8e-3)
        return replace(_soft(b, (j,), COMPLIANCE[[j]]), stops=stops, settle=settled, balanced=True)

    return Change(apply, told)


@_build
def base_tilt(rng: Rng, wish: Wish) -> Change:
    """The base stands askew; the strength is that at the tip."""
    angle = sign(rng) * wish.size / wish.noise * TIP_NOISE[0] / 0.2
    told = Hidden("base_tilt", ALL, "stands_askew", {"angle": angle}, ("angle",))
    return Change(lambda b: replace(b, tilt=angle), told)


@_build
def link_length_error(rng: Rng, wish: Wish) -> Change:
    """Links of another length."""
    joints = wish.joints[:2]
    error = signed(rng, len(joints)) * wish.size / wish.noise * TIP_NOISE[0]
    told = Hidden("link_length_error", joints, "longer_body", {"length_error": error}, ("length_error",))
    return Change(lambda b: replace(b, length=_with(b.length, joints, LINK + error)), told)


@_build
def sensor_delay(rng: Rng, wish: Wish) -> Change:
    """The arm is nominal, what its sensors say comes late."""
    late = float(np.clip(replace(wish, joints=ALL).per(wish.speed).mean(), 2e-4, 0.06))
    return Change(lambda b: b, Hidden("sensor_delay", ALL, "late", {"delay": late}, ("delay",)), late)
