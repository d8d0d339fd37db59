"""What the effects see of many environments at one moment."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Now

ACROSS = ("angles", "wires", "speeds", "arm")  # what shows other joints than an effect's own


class Scene:
    """One moment: ``gearbox``, ``angles``, ``speed`` (environments, joints), and load if it is asked for."""

    def __init__(self, arm: Arm, stamp: float, dt: float, gearbox: Array, angles: Array, speed: Array):
        """rad and rad/s; ``speed``: of the joints as the gearbox would have them."""
        self.arm, self.stamp, self.dt = arm, stamp, dt
        self.gearbox, self.angles, self.speed = gearbox, angles, speed
        self._load: Array | None = None

    def each(self) -> Iterator[Scene]:
        """Each environment alone."""
        for k in range(len(self.gearbox)):
            one = slice(k, k + 1)
            yield Scene(self.arm, self.stamp, self.dt, self.gearbox[one], self.angles[one], self.speed[one])

    @property
    def load(self) -> Array:
        """(environments, joints) N m of all weight beyond each joint."""
        if self._load is None:
            self._load = np.ascontiguousarray(self.arm.load(self.angles))
        return self._load


class View(Now):
    """A scene as an effect looks at it. ``asked``: what it has looked at.

    flat: all joints of all environments are columns of one sample. rows: environments are samples, which an
    effect without memory does not mind. single: one environment is one sample.
    """

    def __init__(self, scene: Scene, layout: str, row: int = 0):
        self._scene, self._layout, self._row = scene, layout, row
        self.asked: set[str] = set()
        self.held = True
        self.joints = scene.arm.joints
        environments, count = scene.gearbox.shape
        samples = environments if layout == "rows" else 1
        self.stamp, self.dt = np.full(samples, scene.stamp), np.full(samples, scene.dt)
        self.columns = tuple(range(count))
        self.ratio = np.tile(scene.arm.ratio, environments) if layout == "flat" else scene.arm.ratio

    def __getattribute__(self, name: str) -> Any:
        """What the scene holds, in this layout."""
        if name in ("gearbox", "speed", "load"):
            return self._cut(getattr(self._scene, name))
        if name in ACROSS:
            self.asked.add(name)
            scene = self._scene
            if name == "arm":
                return scene.arm
            return self._cut(
                {"angles": scene.angles, "wires": scene.gearbox * scene.arm.ratio, "speeds": scene.speed}[
                    name
                ]
            )
        return super().__getattribute__(name)

    def _cut(self, values: Array) -> Array:
        if self._layout == "rows":
            return values
        return values.reshape(1, -1) if self._layout == "flat" else values[self._row : self._row + 1]
