"""Effects of many environments at once, each in the layout that suits it."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.effects import lasting
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect
from trunk_ros.export.reality.scene import Scene, View

SETTINGS = ("width", "middle", "nominal_width", "pull", "dead_zone")


class Block:
    """One effect on (environments, joints)."""

    def __init__(self, effect: Effect, arm: Arm, environments: int):
        """``effect``: over the arm's joints."""
        self.effect = effect
        self.memory: Any = None
        self.layout = layout_of(effect, arm) if environments > 1 else "single"
        if self.layout == "flat":
            values = {name: np.tile(v, environments) for name, v in effect.values.items()}
            words = {name: w * environments for name, w in effect.words.items()}
            self.effect = type(effect)(values, words, effect.form)

    def run(self, x: Array, scene: Scene, anew: np.ndarray | None = None) -> Array:
        """Pass (environments, joints) through; environments ``anew`` (environments,) have no memory."""
        if self.layout == "single":
            return self._one_by_one(x, scene, anew)
        y = x.reshape(1, -1) if self.layout == "flat" else x
        view, before = View(scene, self.layout), self.memory
        out, self.memory = lasting.run(self.effect, y, view, before)
        if anew is not None and before is not None:
            fresh, memory = lasting.run(self.effect, y, view, None)
            columns = np.repeat(anew, x.shape[1])
            out, self.memory = np.where(columns, fresh, out), mixed(self.memory, memory, columns)
        return out.reshape(x.shape)

    def _one_by_one(self, x: Array, scene: Scene, anew: np.ndarray | None) -> Array:
        memory = self.memory or [None] * len(x)
        kept = [m if anew is None or not anew[k] else None for k, m in enumerate(memory)]
        done = [
            lasting.run(self.effect, x[k : k + 1], View(scene, "single", k), kept[k]) for k in range(len(x))
        ]
        self.memory = [after for _, after in done]
        return np.concatenate([out for out, _ in done])

    def adjust(self, core: Core, scene: Scene) -> None:
        """Change a core whose settings are (environments, joints)."""
        shape = core.width.shape
        if self.layout == "flat":
            for name in SETTINGS:
                setattr(core, name, getattr(core, name).reshape(1, -1))
        lasting.adjust(self.effect, core, View(scene, self.layout))
        for name in SETTINGS:
            setattr(core, name, getattr(core, name).reshape(shape))


def layout_of(effect: Effect, arm: Arm) -> str:
    """How an effect takes many environments: found by trying it on one."""
    x = np.full((1, len(arm.joints)), 0.1)
    view = View(Scene(arm, 1.0, 0.01, x, x, x), "single")
    if effect.acts_at != Effect.CORE:
        _, memory = effect.run(x, view, None)
        if memory is None:
            return "rows"
        return "single" if view.asked else "flat"
    effect.adjust(core_of(x), view)
    return "rows" if view.asked else "flat"


def holds_together(effect: Effect, arm: Arm) -> bool:
    """Whether friction holds a joint by what the others do: it sees one environment at a time."""
    x = np.full((1, len(arm.joints)), 0.1)
    core, view = core_of(x), View(Scene(arm, 1.0, 0.01, x, x, x), "single")
    effect.adjust(core, view)
    return core.rounding is not None and bool(view.asked)


def core_of(like: Array) -> Core:
    """A core without play, dead zone, pull or cogging, shaped like (environments, joints)."""
    zero, one = np.zeros_like(like), np.ones(1)
    return Core(
        nominal_width=zero, width=zero, middle=zero, pull=zero, load=zero, torque=0.0 * one,
        rub=0.0 * one, dead_zone=zero, kp=one,
        tau_v=one, v_max=one * np.inf, uneven=0.0 * one, delay=one * 0.0,
        feedforward=one * 0.0, cogging=np.zeros((3, 1, 1)), quickest=one * np.inf, ramp=one * np.inf,
        hardest=one * np.inf, dry=one * 0.0, ki=one * 0.0, windup=one * 0.0, speed_ki=one * 0.0,
    )  # fmt: skip


def mixed(running: Any, fresh: Any, which: np.ndarray) -> Any:
    """A memory with the columns ``which`` of a fresh one; columns are the last axis of its arrays."""
    if isinstance(running, tuple):
        return tuple(mixed(a, b, which) for a, b in zip(running, fresh, strict=True))
    alike = isinstance(running, np.ndarray) and np.shape(fresh) == running.shape
    return np.where(which, fresh, running) if alike and running.shape[-1:] == which.shape else running
