"""What the motors' torque says of the load that a model computes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.data.align import common_joints
from trunk_ros.data.noise import rms
from trunk_ros.effort import MeasuredLoad, measured_load
from trunk_ros.levels import MOST, PART
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.fill import fill
from trunk_ros.resistance import load_cells, swung, tells
from trunk_ros.transmission import uncoupled


def torque_remarks(recording: Recording, model: ArmModel, found: ArmModel | None = None) -> list[str]:
    """What is to be said of recorded effort: how it was used, and whether the weight agrees with it, by the
    ratio that was ``found``. Where no joint was measured, a ratio of 1 may stand for one that nobody knows.
    """
    if "gearbox_states" not in recording.series:
        return []
    _, found = uncoupled(recording, found or model)
    recording, model = uncoupled(recording, model)
    gearbox = recording.series["gearbox_states"]
    joints = common_joints(recording, model, gearbox)
    arm, gearbox = model.for_joints(joints).loaded_arm().only(joints), gearbox.select(joints)
    if gearbox.effort is None:
        shown = recording.series.get("joint_states")
        cells = shown is not None and tells(load_cells(joints, shown)).any()
        unmet = arm.load_from == "effort" and arm.has_load and not cells
        return ["no effort in gearbox_states: the load is the computed weight"] if unmet else []
    arm = replace(arm, ratio=found.for_joints(joints).only(joints).number("ratio"))
    known = "joint_states" in recording.series or bool(np.any(arm.ratio != 1.0))
    measured = measured_load(gearbox, arm.ratio, arm)
    used = [_use(arm, measured)] if arm.load_from == "effort" else []
    return used + (_against_weight(arm, gearbox, measured) if arm.has_load and known else [])


def _use(arm: Arm, measured: MeasuredLoad) -> str:
    joints, told = arm.joints, np.isfinite(measured.friction)
    friction = [f"{j} {f:.3g}" for j, f in zip(joints, measured.friction, strict=True) if f > 0.0]
    silent = [j for j, known in zip(joints, told, strict=True) if not known]
    said = f"load from the motors' torque, less friction [N m at the shaft]: {', '.join(friction) or 'none'}"
    instead = "computed weight" if arm.has_load else "all of the torque"
    return said + (f"; {instead} on {', '.join(silent)}: no motion both ways, or no torque" if silent else "")


def _against_weight(arm: Arm, gearbox: JointSeries, measured: MeasuredLoad) -> list[str]:
    """A remark where the computed weight is not the measured one, whatever part of the inertia it shows."""
    phi, seen = fill(gearbox.position), measured.moving
    if not seen.any():
        return []
    theta, inertia = phi * arm.ratio, swung(arm, gearbox.stamp, phi).load(replace(arm, gravity=0.0), phi)
    computed, lever = arm.load(theta), arm.lever(theta)[seen]
    if not computed[seen].any():  # without gravity
        return []
    both = np.column_stack([lever, inertia[seen]])
    (payload, swings), *_ = np.linalg.lstsq(both, (measured.moment - computed)[seen], rcond=1e-9)
    measured = replace(measured, moment=measured.moment - swings * inertia)
    off = (measured.moment - computed)[seen]
    if rms(off) < PART * rms(computed[seen]):
        return []
    share = f"{100 * rms(off) / rms(computed[seen]):.0f} %"
    said = f"the motors' torque and the computed weight on the joints differ by {share}"
    if rms(off - payload * lever) < (1.0 - MOST) * rms(off):
        way = "more" if payload > 0.0 else "less"
        return [f"{said}: {abs(1e3 * payload):.0f} g {way} at the tip would explain it"]
    return [f"{said}, on {_worst(arm, measured, computed)}: check masses, lengths and the torque's unit"]


def _worst(arm: Arm, measured: MeasuredLoad, computed: Array) -> str:
    """The joint on which they differ most, with how much."""
    off = np.where(measured.moving, measured.moment - computed, 0.0)
    joint = int(np.argmax((off**2).sum(axis=0)))
    seen = measured.moving[:, joint]
    own = computed[seen, joint]
    if not own.any():
        return f"{arm.joints[joint]} most, where none was computed"
    times = float(own @ measured.moment[seen, joint] / (own @ own))
    return f"{arm.joints[joint]} most, {times:.2f} times the computed one"
