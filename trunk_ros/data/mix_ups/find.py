"""All mix-ups of a recording, and the recording without what they concern."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.data.align import common_joints
from trunk_ros.data.mix_ups.clock import clock_offset
from trunk_ros.data.mix_ups.copied import copied
from trunk_ros.data.mix_ups.guided import guided
from trunk_ros.data.mix_ups.no_torque import no_torque, without_torque
from trunk_ros.data.mix_ups.order import swapped, turned_signs
from trunk_ros.data.mix_ups.pair import MixUp, pair_of
from trunk_ros.data.mix_ups.servo_numbers import servo_numbers
from trunk_ros.data.mix_ups.stuck import stuck
from trunk_ros.data.mix_ups.tip import tip_mixed
from trunk_ros.data.mix_ups.units import counts, degrees, exchanged, joint_sided
from trunk_ros.data.mix_ups.unled import unled
from trunk_ros.data.span import Span
from trunk_ros.errors import RecordingError
from trunk_ros.levels import FEWEST
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.topics import COMPARED, TOPICS
from trunk_ros.resistance import load_cells, tells


def mix_ups(recording: Recording, model: ArmModel) -> list[MixUp]:
    """What is mixed up between the topics of each stage; nothing where the joints are not the model's, or
    follow several motors each.
    """
    if model.arm.coupling is not None:
        return []
    out: list[MixUp] = []
    for stage in ("wire", "servo"):
        if all(key in recording.series for key in COMPARED[stage]):
            known = {joint for one in out if one.kind == "stuck" for joint in one.joints}
            out += _of_stage(recording, model, stage, known)
    if not any(one.certain for one in out):
        out += servo_numbers(recording, model)
        out += tip_mixed(recording, model)
    return out + no_torque(recording, model)


def without_mix_ups(recording: Recording, found: list[MixUp]) -> Recording:
    """The recording without effort that is a magnitude, and without what is mixed up for certain: setpoints
    that do not fit the motors are left out, and become NaN where motors do not follow them, or where there
    is nothing else to diagnose; joint readings that do not fit become NaN, and the tip is left out with them,
    and the setpoints where a hand guides joints: their motors follow the hand.
    """
    recording = without_torque(recording, found)
    series, tip = dict(recording.series), recording.tip
    for one in (one for one in found if one.certain):
        if one.stage == "servo":
            asked = series.pop("setpoints", None)
            if asked is not None and (one.kind in ("unled", "stuck") or "joint_states" not in series):
                series["setpoints"] = _unread(asked, one.joints)
            continue
        if one.stage == "arm":
            tip = None
            continue
        if one.kind == "guided":
            series.pop("setpoints", None)
        series["joint_states"], tip = _unread(series["joint_states"], one.joints), None
    return replace(recording, series=series, tip=tip)


def _unread(series: JointSeries, joints: tuple[str, ...]) -> JointSeries:
    """With NaN for some joints."""
    position = series.position.copy()
    position[:, [series.joints.index(joint) for joint in joints]] = np.nan
    return replace(series, position=position)


def as_if_standing(span: Span, found: Sequence[MixUp]) -> Span:
    """The wires with motors that stand where it is certain that which way, or which joint, they turn is mixed
    up: nobody knows where such a joint is, and what others have is no matter of it. Readings in another unit
    leave the motors as they are.
    """
    told = {joint for one in found if is_astray(one) for joint in one.joints}
    mixed = [c for c, joint in enumerate(span.joints) if joint in told]
    if not mixed:
        return span
    path, velocity = span.gearbox.copy(), span.velocity.copy()
    path[:, mixed], velocity[:, mixed] = np.median(path[:, mixed], axis=0), 0.0
    return replace(span, source=path, gearbox=path, velocity=velocity)


def is_astray(one: MixUp) -> bool:
    """Whether it is not known where joints are whose motors were recorded."""
    return one.certain and one.stage == "wire" and one.kind in ("sign", "order")


def _of_stage(recording: Recording, model: ArmModel, stage: str, known: set[str]) -> list[MixUp]:
    """What is mixed up in a stage. Servos may stand, unless their readings are ``known`` to be stuck."""
    source, target = (recording.series[key] for key in COMPARED[stage])
    try:
        joints = common_joints(recording, model, source, target)
    except RecordingError:  # is said where it matters
        return []
    joints = tuple(j for j in joints if all(_is_read(series, j) for series in (source, target)))
    if not joints:
        return []
    source, target = source.select(joints), target.select(joints)
    looked = joints if stage == "wire" else tuple(joint for joint in joints if joint in known)
    pair = pair_of(recording, model, stage, source.select(looked), target.select(looked)) if looked else None
    still = [] if pair is None else stuck(pair, tells(load_cells(looked, target)))
    joints = tuple(j for j in joints if all(j not in one.joints for one in still))
    if not joints:
        return still
    return still + _of_moving(recording, model, stage, source.select(joints), target.select(joints))


def _of_moving(
    recording: Recording, model: ArmModel, stage: str, source: JointSeries, target: JointSeries
) -> list[MixUp]:
    """What is mixed up between two topics of the same joints, none of which is stuck."""
    off = clock_offset(source.stamp, source.position, target.stamp, target.position)
    if off:
        return [_clock(stage, source.joints, off)]
    pair = pair_of(recording, model, stage, source, target)
    found: list[MixUp] = []
    if pair is None:
        return found
    for look in (copied, counts, swapped, degrees, exchanged, joint_sided, turned_signs):
        known = {joint for one in found for joint in one.joints}
        found += [one for one in look(pair) if not known & set(one.joints)]
    if found:
        return found
    course = pair_of(recording, model, stage, source, target, in_a_row=True)
    return [] if course is None else [*guided(course), *unled(course)]


def _is_read(series: JointSeries, joint: str) -> bool:
    """Whether a joint has readings at all: one without would hide the others."""
    readings = series.position[:, series.joints.index(joint)]
    return bool(np.isfinite(readings).sum() >= FEWEST)


def _clock(stage: str, joints: tuple[str, ...], off: float) -> MixUp:
    source, target = (TOPICS[key] for key in COMPARED[stage])
    way = "late" if off > 0 else "early"
    said = (
        f"the clocks of {source} and {target} are {abs(off):.3g} s apart: {target} is {way} by "
        "that, and fits when it is moved. Synchronise the clocks (chrony, PTP) or correct the stamps, and "
        "diagnose again."
    )
    return MixUp("clock", stage, joints, said)
