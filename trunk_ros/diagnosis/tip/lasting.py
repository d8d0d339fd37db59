"""Noise of joint readings that poses of the tip inherit, and their own scatter does not show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context


class Lasting(NamedTuple):
    """Of each joint (joints,): standard deviation [rad] of noise that lasts from sample to sample, and for
    how long [s] a reading that is off by so much stays the same.
    """

    std: Array
    stays: Array

    def counted(self, stamps: Sequence[Array]) -> Array:
        """(joints,) rad: standard deviations that independent noise of poses at ``stamps`` (n,) s each would
        have, to be off as much in the mean.
        """
        apart = float(np.median(np.concatenate([np.diff(stamp) for stamp in stamps])))
        return np.asarray(self.std * np.sqrt(self.stays / apart))


def lasting_of(context: Context) -> dict[str, tuple[float, float]]:
    """By joint, of the noise that the wires left: what has a colour, else the steps of an encoder, which are
    off alike as long as the joint rests.
    """
    stage = context.stage
    steps = zip(stage.steps, [samples * context.step for samples in stage.stands], strict=True)
    each = zip(context.joints, context.noise, steps, strict=True)
    return {joint: (noise.std, 0.0) if noise.correlation > 0.0 else step for joint, noise, step in each}


def lasting_on(joints: tuple[str, ...], known: dict[str, tuple[float, float]]) -> Lasting:
    """The same of these joints; of others nothing is known."""
    return Lasting(*np.array([known.get(joint, (0.0, 0.0)) for joint in joints]).T)
