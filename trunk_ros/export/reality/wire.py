"""What a transmission lacks, between a simulator's motors and its joints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.effects import lasting
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.export.reality.blocks import Block, core_of, holds_together, mixed
from trunk_ros.export.reality.past import Past
from trunk_ros.export.reality.scene import Scene
from trunk_ros.stage import Memory, Order

DELAYS = {("sensor_delay", "constant"): "delay", ("viscous_lag", "shift"): "time_constant"}


class Late:
    """An effect that is no more than a delay, with room for no more than it needs."""

    def __init__(self, delay: Array, environments: int):
        self._past = Past(np.tile(delay, environments))

    def run(self, x: Array, scene: Scene, anew: np.ndarray | None = None) -> Array:
        """Pass (environments, joints) through."""
        flat = x.reshape(-1)
        if anew is not None:
            self._past.restart(np.repeat(anew, x.shape[1]), flat)
        return self._past.step(scene.stamp, flat).reshape(x.shape)


class Wire:
    """The effects of a model's wire on (environments, joints), split at the joint: ``drive`` and ``show``."""

    def __init__(self, model: ArmModel, environments: int):
        order = Order.of(model.bound("wire"))
        self.path, self.core, self.after, self.sensor = (
            [block_of(e, model, environments) for e in some]
            for some in (order.path, order.core, order.after, order.sensor)
        )
        self.stuck: object = None
        self.memory: Memory = {}

    def drive(self, scene: Scene, clock: Scene, anew: np.ndarray | None) -> Array:
        """Joint angles (environments, joints) [rad] that the gearbox angles of a scene give."""
        u = np.ascontiguousarray(scene.gearbox * scene.arm.ratio)
        for block in self.path:
            u = block.run(u, scene, anew)
        if self.core:
            u = self._friction(u, scene, anew)
        for block in self.after:
            u = block.run(u, clock if isinstance(block, Late) else scene, anew)
        return u

    def show(self, state: Array, scene: Scene, clock: Scene, anew: np.ndarray | None) -> Array:
        """What the joints' sensors say (environments, joints) [rad] of joints at ``state``."""
        for block in self.sensor:
            state = block.run(state, clock if isinstance(block, Late) else scene, anew)
        return state

    def _adjusted(self, u: Array, scene: Scene, memory: Memory) -> Core:
        """The friction element's settings, given what the effects that change it remember."""
        core = core_of(u)
        core.old = memory
        for block in self.core + self.path:
            if isinstance(block, Block):
                block.adjust(core, scene)
        return core

    def _friction(self, u: Array, scene: Scene, anew: np.ndarray | None) -> Array:
        core = self._adjusted(u, scene, self.memory)
        if anew is not None and self.memory:
            first, which = self._adjusted(u, scene, {}), np.repeat(anew, u.shape[1])
            core.width = np.where(anew[:, None], first.width, core.width)
            core.middle = np.where(anew[:, None], first.middle, core.middle)
            core.new = {name: mixed(kept, first.new[name], which) for name, kept in core.new.items()}
        self.memory = core.new
        element, width = core.rounding or SharpPlay(), core.width.reshape(1, -1)
        flat = (u + core.middle).reshape(1, -1)
        before = self.stuck
        out, self.stuck = element.run(flat, width, before)
        if anew is not None and before is not None:
            columns = np.repeat(anew, u.shape[1])
            fresh, memory = element.run(flat, width, None)
            out, self.stuck = np.where(columns, fresh, out), mixed(self.stuck, memory, columns)
        return np.asarray(out.reshape(u.shape))


class Wires:
    """Wires of many environments, each on its own."""

    def __init__(self, model: ArmModel, environments: int):
        self.wires = [Wire(model, 1) for _ in range(environments)]

    def drive(self, scene: Scene, clock: Scene, anew: np.ndarray | None) -> Array:
        """As Wire.drive."""
        each = zip(self.wires, scene.each(), clock.each(), self._apart(anew), strict=True)
        return np.concatenate([wire.drive(one, time, fresh) for wire, one, time, fresh in each])

    def show(self, state: Array, scene: Scene, clock: Scene, anew: np.ndarray | None) -> Array:
        """As Wire.show."""
        states = self._apart(state)
        each = zip(self.wires, states, scene.each(), clock.each(), self._apart(anew), strict=True)
        return np.concatenate([wire.show(at, one, time, fresh) for wire, at, one, time, fresh in each])

    def _apart(self, values: Array | None) -> Iterable[Any]:
        return [None] * len(self.wires) if values is None else np.split(values, len(self.wires))


def wire_of(model: ArmModel, environments: int) -> Wire | Wires:
    """The wires of many environments: together where their effects let them."""
    alone = any(holds_together(e, model.arm) for e in model.bound("wire"))
    return Wires(model, environments) if alone and environments > 1 else Wire(model, environments)


def block_of(effect: Effect, model: ArmModel, environments: int) -> Block | Late:
    """An effect as a block over many environments."""
    name = DELAYS.get((effect.id, effect.form)) if lasting.lasts(effect) else None
    return Late(effect[name], environments) if name else Block(effect, model.arm, environments)
