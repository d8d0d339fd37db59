"""Joint angles between the moments at which they were measured, as a model has them."""

from __future__ import annotations

import numpy as np

from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.signal.resample import joint_grid, resample
from trunk_ros.resistance import resistance


def angles_between(recording: Recording, model: Model, stamp: Array) -> Array | None:
    """(n, joints) rad that the model's wires show at ``stamp`` (n,), readings not being late; None where the
    gearbox was not recorded.
    """
    gearbox = recording.series.get("gearbox_states")
    if gearbox is None or not set(model.arm.joints) <= set(gearbox.joints):
        return None
    gearbox = gearbox.select(model.arm.joints)
    grid, rows, _ = joint_grid(gearbox.stamp, stamp, beyond=True)
    phi, velocity = resample(gearbox, grid)
    known = resistance(model.arm, gearbox, grid, phi, recording.series.get("joint_states"))
    theta, _ = Chain(model.prompt(), "wire").run(phi, grid, velocity=velocity, resistance=known)
    return np.asarray(theta[rows])
