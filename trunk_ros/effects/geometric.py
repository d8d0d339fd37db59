"""What changes of an arm's geometry have in common: shifts and turns of frames, and pairs across a link."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


def sideways(name: str, unit: str, most: float, meaning: str, typical: float) -> tuple[Parameter, ...]:
    """``name_1`` and ``name_2``, in -most … most, along two directions across a joint or link."""
    return tuple(
        Parameter(f"{name}_{k}", unit, (-most, most), meaning.format(k), typical=typical) for k in (1, 2)
    )


class Sideways(Effect):
    """A change of each joint's place or axis in two directions."""

    def sideways(self, directions: Array) -> Array:
        """(joints, 3) sum of the two, along ``directions`` (joints, 2, 3)."""
        sizes = np.stack([self[parameter.name] for parameter in self.parameters], axis=1)
        return np.asarray(np.einsum("jk,jkx->jx", sizes, directions))


class FrameError(Effect):
    """A frame that is shifted [m] and turned [rad] by the same in every posture."""

    everywhere = True
    rows: ClassVar[dict[str, int]]
    """Row of each parameter in x, y, z, roll, pitch, yaw."""

    @abstractmethod
    def frame(self, core: Core) -> Array:
        """(6,) that it changes."""

    def adjust(self, core: Core, now: Now) -> None:
        frame = self.frame(core)
        for name, row in self.rows.items():
            frame[row] += float(np.ravel(self.values.get(name, 0.0))[0])
