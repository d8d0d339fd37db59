"""Where the servos went between what was recorded of them, as their setpoints tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from trunk_ros.arm import Arm
from trunk_ros.arm.arm import STEP
from trunk_ros.arm_model import HELD, ArmModel
from trunk_ros.chain import Chain
from trunk_ros.recording.recording import Floats, JointSeries, Recording
from trunk_ros.recording.signal.encoder import HIDDEN, ON_GRID, scatter
from trunk_ros.recording.signal.fill import between, fill, hold
from trunk_ros.recording.signal.gaps import bridged
from trunk_ros.recording.signal.resample import SAME, joint_grid, resample, stops_to_measure
from trunk_ros.resistance import Resistance, on_motors
from trunk_ros.transmission import at_joints

LOST = 3.0  # s: who falls silent for longer has stopped, and messages were not lost
DRIFT = 0.5  # standard deviations of noise: four of the mean over AGREES samples
WILD = 6.0  # standard deviations of noise
AT_ONCE = 2**17  # samples that are computed together: of long recordings more would not fit into memory
AGREES = 65  # samples around a moment whose readings must all be those of the servo's course


def servo_course(
    setpoints: JointSeries, wanted: Floats, model: ArmModel, seen: Recording | None = None
) -> JointSeries:
    """Gearbox angles of the model's servos under setpoints, at the stamps ``wanted`` (n,) s, under the
    torque or load cells that were ``seen`` beside them: other loads go by the course itself.
    """
    setpoints, model = _in_time(setpoints, model)
    grid, rows, kept = joint_grid(setpoints.stamp, wanted, fine=False, beyond=True)
    last = np.clip(np.searchsorted(setpoints.stamp, grid + SAME, side="right") - 1, 0, None)
    held, chain = hold(setpoints.position), Chain(model.only(setpoints.joints), "servo")
    arm = model.only(setpoints.joints).arm
    known = felt(seen, arm, grid) if seen is not None and arm.load_from == "effort" else None
    phi, state = np.empty((len(grid), held.shape[1])), None
    for first in range(0, len(grid), AT_ONCE):
        piece = slice(first, first + AT_ONCE)
        phi[piece], state = chain.run(
            held[last[piece]], grid[piece], state, resistance=None if known is None else known.part(piece)
        )
    everywhere = np.array_equal(rows, np.arange(len(grid)))
    return JointSeries(wanted[kept], setpoints.joints, phi if everywhere else phi[rows])


def _in_time(setpoints: JointSeries, model: ArmModel) -> tuple[JointSeries, ArmModel]:
    """Setpoints that are stamped late, by delays of the model below 0, as early as a servo got them that
    waits for none; and the model with what is left of its delays.
    """
    early = min(float(np.min(model.number("delay"))), 0.0)
    if early == 0.0:
        return setpoints, model
    arm = replace(model.arm, delay=model.arm.delay - early)
    return replace(setpoints, stamp=setpoints.stamp + early), replace(model, arm=arm)


def felt(recording: Recording, arm: Arm, grid: Floats) -> Resistance | None:
    """What a recording tells of the load on an arm's motors, at ``grid`` (m,) s; None where it does not."""
    gearbox = recording.series.get("gearbox_states")
    if arm.load_from == "weight" or gearbox is None or not set(arm.joints) <= set(gearbox.joints):
        return None
    gearbox = gearbox.select(arm.joints)
    at_wires = at_joints(gearbox, arm, measured=False)
    turned = arm.driven(resample(gearbox, grid)[0])
    return on_motors(arm.uncoupled(), at_wires, grid, turned, recording.series.get("joint_states"))


def given(setpoints: JointSeries, model: ArmModel) -> JointSeries:
    """The setpoints that a servo got: those recorded, or what these are samples of."""
    if model.setpoints == HELD:
        return setpoints
    stamp, position = between(setpoints.stamp, setpoints.position, STEP)
    return JointSeries(stamp, setpoints.joints, position)


def all_setpoints(recording: Recording, joints: tuple[str, ...], model: ArmModel) -> JointSeries | None:
    """Setpoints of the joints with those that were lost on the way to the bag, which move as the reference
    does; None where they were not recorded.
    """
    setpoints, reference = recording.series.get("setpoints"), recording.series.get("reference")
    if setpoints is None or not set(joints) <= set(setpoints.joints):
        return None
    setpoints = setpoints.select(joints)
    if reference is None or not set(joints) <= set(reference.joints):
        return given(bridged(setpoints, longest=LOST), model)
    asked = bridged(reference.select(joints), longest=LOST)
    guide = JointSeries(asked.stamp, joints, model.only(joints).arm.asked(asked.position))
    return given(bridged(setpoints, guide, LOST), model)


def as_the_servo_went(
    recording: Recording, gearbox: JointSeries, steps: Floats, grid: Floats, phi: Floats, model: ArmModel
) -> Floats:
    """Gearbox angles (m, joints) on the grid (m,) s: ``phi``, but those of the model's servo where it
    passes, led by the recorded setpoints alone, all readings near by within their rounding or their noise. Of
    what stops to measure, and of servos of which the model says nothing, the readings are all that is known.

    ``steps`` (joints,): those of the encoders, as ``counts`` has them.
    """
    stamp = gearbox.stamp
    if len(stamp) < AGREES or stops_to_measure(stamp) or not model.says_its_servos:
        return phi
    setpoints = all_setpoints(recording, gearbox.joints, model)
    if setpoints is None:
        return phi
    course = servo_course(setpoints, np.union1d(stamp, grid), model, recording)
    there, on_grid = np.searchsorted(course.stamp, stamp), np.searchsorted(course.stamp, grid)
    before = np.clip(np.searchsorted(stamp, grid + SAME, side="right") - 1, 0, len(stamp) - 1)
    after = np.clip(np.searchsorted(stamp, grid - SAME), 0, len(stamp) - 1)
    went, readings = phi.copy(), fill(gearbox.position)
    for joint, step in enumerate(steps):  # of a long recording that of all would not fit into memory
        led = course.position[:, joint]
        off = _off(led[there] - readings[:, joint], step)
        went[:, joint] = np.where(off[before] | off[after], phi[:, joint], led[on_grid])
    return went


def _off(apart: Floats, step: float) -> np.ndarray:
    """(n,) near which a course is not that of the readings, which are ``apart`` from it (n,); noise has no
    course of its own, and what goes on from sample to sample is none: a servo that stops short is not there.
    """
    rounded = (np.abs(apart) <= (0.5 + ON_GRID) * step) & (step > 0.0)
    noise = scatter(apart)
    drifts = np.abs(uniform_filter1d(apart, AGREES)) > DRIFT * noise
    noisy = ~drifts & (np.abs(apart) < WILD * noise) & (noise > HIDDEN * step)
    return np.asarray(maximum_filter1d(~(rounded | noisy), AGREES))
