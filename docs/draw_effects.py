"""Pictures of effects: what each leaves in the residual, over time and over what it depends on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from PIL import Image

from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects import Effect
from trunk_ros.effects.bank import Bank
from trunk_ros.effects.curve import KNOTS
from trunk_ros.model import Model, load_model
from trunk_ros.motion import named_trajectory

matplotlib.use("Agg")
from matplotlib import pyplot as plt

JOINT = 1
SECONDS, RATE = 48.0, 100.0
HOLD, MOVE = 6.0, 0.7  # s
STILL = 2e-3  # rad/s
UP, DOWN, STANDS = "#2166ac", "#c8453b", "#8c8c8c"
LARGER: dict[str, dict[str, float]] = {  # where the usual size would hardly be seen
    "joint_coupling": {"gain": 0.02},
    "posture_ratio": {"gain": 0.05},
    "presliding_hysteresis": {"width": 4e-3},
    "wire_slack": {"threshold": 0.03},
    "wire_stiffening": {"moment": 0.05},
    "wire_slip": {"onset": 20.0},
    "wrap_friction": {"gain": 3e-3},
    "velocity_saturation": {"v_max": 0.6},
    "uneven_speed": {"excess": 0.6},
    "setpoint_ceiling": {"upper": 0.3},
    "setpoint_floor": {"lower": -0.3},
    "setpoint_rate": {"rate": 0.5},
    "acceleration_limit": {"acceleration": 4.0},
    "motor_friction": {"friction": 0.03},
    "setpoint_profile": {"acceleration": 2.0},
    "hard_stop": {"upper": 0.2},
    "thermal_drift": {"time_constant": 15.0},
    "viscoelastic_creep": {"time_constant": 2.0},
    "link_resonance": {"frequency": 4.0, "damping": 0.05},
    "unknown_slips": {f"moment_{k:02d}": 2.0 * k for k in range(1, KNOTS)},
    "unknown_jumps": {f"moment_{k:02d}": 2.0 * k for k in range(1, KNOTS)},
}
RANGES = {  # s
    **dict.fromkeys(("unknown_cycle", "unknown_waves"), (0.0, 0.7)),
    **dict.fromkeys(("unknown_drift", "unknown_jumps", "unknown_slips"), (0.0, SECONDS)),
}
WITH_HOLDS = ("viscoelastic_creep", "link_resonance")


@dataclass(frozen=True)
class Scene:
    """A motion of the nominal arm; arrays (n, joints) or (n,)."""

    stamp: Array
    theta: Array
    gearbox: Array
    speed: Array
    load: Array


Over = tuple[str, Callable[[Scene], Array]]
ANGLE: Over = ("joint angle [rad]", lambda s: s.theta[:, JOINT])
GEARBOX: Over = ("gearbox angle [rad]", lambda s: s.gearbox[:, JOINT])
LOAD: Over = ("load [N m]", lambda s: s.load[:, JOINT])
SPEED: Over = ("joint speed [rad/s]", lambda s: s.speed[:, JOINT])
TIME: Over = ("time [s]", lambda s: s.stamp)
STANDING: Over = ("time since the stop [s]", lambda s: standing(s))
BY_REGIME = {
    "always": ANGLE, "posture": ANGLE, "reversal": ANGLE, "hold": STANDING,
    "low_speed": SPEED, "high_speed": SPEED, "time": TIME,
}  # fmt: skip
OVER: dict[str, Over] = {
    "transmission_ripple": GEARBOX, "cogging": GEARBOX, "friction_wear": TIME, "friction_warming": TIME,
    "link_resonance": STANDING,
    "load_elasticity": LOAD, "wire_slack": LOAD, "wire_stiffening": LOAD, "load_dependent_friction": LOAD,
    "load_droop": LOAD, "link_compliance": LOAD, "unknown_cycle": TIME, "unknown_waves": TIME,
    "unknown_jumps": TIME, "unknown_slips": TIME, "unknown_drift": TIME,
    "unknown_dead_zone": GEARBOX,
    **dict.fromkeys(
        ("joint_coupling", "coupling_curve", "coupling_drag"),
        ("angle of joint 1 [rad]", lambda s: s.theta[:, 0]),
    ),
    "presliding_hysteresis": ("travel since the reversal [mrad]", lambda s: travel(s)),
    "link_length_error": ("direction of link 2 [rad]", lambda s: s.theta[:, 0] + s.theta[:, 1]),
    "base_tilt": ("height of the tip [m]", lambda s: height(s)),
}  # fmt: skip


def standing(scene: Scene) -> Array:
    """(n,) s since the joint came to rest; nan while it moves."""
    still = np.abs(scene.speed[:, JOINT]) < STILL
    since = np.where(still, np.nan, scene.stamp)
    last = np.maximum.accumulate(np.nan_to_num(since, nan=-np.inf))
    return np.where(still & np.isfinite(last), scene.stamp - last, np.nan)


def height(scene: Scene) -> Array:
    """(n,) m of the tip above the base."""
    return load_model("trunk").arm.tip(scene.theta)[:, 2]


def travel(scene: Scene) -> Array:
    """(n,) mrad gone since the joint last turned back; nan past the first 20."""
    theta, speed = scene.theta[:, JOINT], scene.speed[:, JOINT]
    way = np.sign(np.where(np.abs(speed) < STILL, 0.0, speed))
    turned = np.zeros(len(theta), dtype=int)
    last = 0.0
    for k in range(1, len(theta)):
        turned[k] = k if way[k] * last < 0.0 else turned[k - 1]
        last = way[k] or last
    gone = 1e3 * np.abs(theta - theta[turned])
    return np.where((gone < 20.0) & (turned > 0), gone, np.nan)


@cache
def scene(holds: bool) -> Scene:
    """Sweeps, fast moves, reversals of every size and slow motion; or fast moves and long holds."""
    arm = load_model("trunk").arm
    stamp = np.arange(round(SECONDS * RATE)) / RATE
    if holds:
        part = np.clip((stamp % HOLD) / MOVE, 0.0, 1.0)
        targets = np.array([0.0, 0.3, -0.1, 0.2, -0.3, 0.1, -0.25, 0.25, 0.0])
        leg = np.minimum(stamp // HOLD, len(targets) - 2).astype(int)
        smooth = part**3 * (10.0 - 15.0 * part + 6.0 * part**2)
        one = targets[leg] + (targets[leg + 1] - targets[leg]) * smooth
        theta = np.column_stack([one] * len(arm.joints))
    else:
        theta = named_trajectory("default", arm, SECONDS).sample(stamp)[0]
    return Scene(stamp, theta, theta / arm.ratio, np.gradient(theta, stamp, axis=0), arm.load(theta))


def usual(kind: type[Effect], joints: int) -> dict[str, Any]:
    """A model's values of an effect of usual size."""
    form = kind.forms[0]
    values: dict[str, Any] = {"form": form} if form else {}
    for p in kind.own_parameters(form):
        if not p.optional or p.name == "payload":
            size = LARGER.get(kind.id, {}).get(p.name, p.typical)
            values[p.name] = size if p.shared else np.full(joints, size)
            if kind.stage == "arm" and not p.shared:
                values[p.name] = np.where(np.arange(joints) == JOINT, size, 0.0)
    if kind.texts and "on" not in kind.texts:
        names = tuple(f"joint_{k + 1}" for k in range(joints))
        first = (
            [kind.choices(names, name)[0] for name in names] if issubclass(kind, Bank) and kind.own else []
        )
        values[kind.texts[0]] = first or [names[k - 1] for k in range(joints)]
    if issubclass(kind, Bank):
        bend = (0.002 if kind.by_posture else 0.01) * np.sin(0.9 * np.arange(1, kind.weights + 1))
        values |= {f"weight_1_{i}": np.full(joints, bend[i - 1]) for i in range(1, kind.weights + 1)}
        values |= {"low_1": np.full(joints, -0.4 if kind.by_posture or not kind.remembers else 0.02)}
    if "on" in kind.texts:
        bump = 1e-3 * np.sin(np.linspace(0.0, 7.0, KNOTS))
        low, high = RANGES.get(kind.id, (-0.4, 0.4))
        on = "time" if kind.id in RANGES else "position"
        values |= {"on": [on] * joints, "low": np.full(joints, low), "high": np.full(joints, high)}
        values |= {f"value_{k:02d}": np.full(joints, bump[k]) for k in range(KNOTS)}
    return values


def residual(kind: type[Effect], seen: Scene) -> tuple[Array, str]:
    """(n,) what the effect changes, and its unit in words."""
    arm = load_model("trunk").arm
    model = Model(arm, {kind.id: usual(kind, len(arm.joints))})
    x = seen.theta if kind.stage == "arm" else seen.gearbox
    out, plain = (Chain(each, kind.stage).run(x, seen.stamp)[0] for each in (model, Model(arm)))
    if kind.stage == "arm":
        moved = 1e3 * (out - plain)[:, [1, 2, 0]]
        most = int(np.argmax((moved**2).sum(axis=0)))
        return moved[:, most], f"{'yzx'[most]} of the tip [mm]"
    return 1e3 * (out - plain)[:, JOINT], "residual [mrad]"


def draw(kind: type[Effect], path: Path) -> None:
    """Write the picture of one effect."""
    seen = scene(kind.id in WITH_HOLDS)
    left, unit = residual(kind, seen)
    label, over = OVER.get(kind.id) or BY_REGIME[kind.regime]
    figure, (time, plot) = plt.subplots(
        1, 2, figsize=(7.6, 2.3), width_ratios=(1.5, 1.0), layout="constrained"
    )
    time.fill_between(
        seen.stamp, scaled(seen.theta[:, JOINT], left), scaled(0.0, left), color="#e9e9e9", lw=0
    )
    time.plot(seen.stamp, left, color="#222222", lw=0.7)
    time.set(xlabel="time [s]", ylabel=unit, xlim=(0, SECONDS))
    speed = seen.speed[:, JOINT]
    colors = np.where(np.abs(speed) < STILL, STANDS, np.where(speed > 0, UP, DOWN))
    plot.scatter(over(seen), left, c=colors, s=1.5, linewidths=0)
    plot.set(xlabel=label)
    for axes in (time, plot):
        tidy(axes, left)
    figure.savefig(path, dpi=100)
    plt.close(figure)
    with Image.open(path) as picture:
        small = picture.convert("RGB").quantize(32)
    small.save(path, optimize=True)


def tidy(axes: Any, values: Array) -> None:
    """Small type, no frame, few ticks; a constant is drawn with its zero in sight."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=7)
    axes.xaxis.label.set_size(8)
    axes.yaxis.label.set_size(8)
    axes.locator_params(axis="x", nbins=5)
    if np.ptp(values) < 1e-6:
        axes.set_ylim(*sorted((-0.2 * float(values[0]), 1.6 * float(values[0]))))
        axes.axhline(0.0, color=STANDS, lw=0.4)


def scaled(theta: Any, beside: Array) -> Any:
    """The joint angle in the range of what is drawn beside it."""
    low, high = float(beside.min()), float(beside.max())
    span = high - low if high - low > 1e-6 else abs(high)
    return (low + high) / 2 + theta * span
