"""Readings put right: turns counted on, repeats left out; and how coarse they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.data.repeated_readings import in_turn, new_motor_readings, new_readings
from trunk_ros.data.sensing.filtered import filtered
from trunk_ros.data.sensing.hum import Hum, hums
from trunk_ros.data.sensing.pairs import pair, seen, told
from trunk_ros.data.sensing.steps import coarse_steps
from trunk_ros.data.sensing.wraps import series_unwrapped, whole_turns
from trunk_ros.recording.observed import Observed
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.topics import TOPICS

ANGLES = ("gearbox_states", "joint_states", "setpoints", "reference")
SHOWN = TOPICS["joint_states"]


def readings_put_right(recording: Recording, model: ArmModel) -> Recording:
    """Without jumps of whole turns, within a topic and between two; before anything else is looked at."""
    return _of_one_turn(turns_counted_on(recording), model)


def turns_counted_on(recording: Recording) -> Recording:
    """Without jumps of whole turns within a topic."""
    for key in ANGLES:
        if key in recording.series:
            recording = _unwrapped(recording, key)
    return recording


def _unwrapped(recording: Recording, key: str) -> Recording:
    series, topic = recording.series[key], TOPICS[key]
    angles = np.array([recording.unit(joint) == "rad" for joint in series.joints])
    whole, found = series_unwrapped(series, angles)
    if not found:
        return recording
    times, joints = sum(found.values()), tuple(found)
    said = (
        f"{topic} of {', '.join(joints)} jumps by a whole turn {times} times, as a sensor does at the end of "
        "its range: turns were counted on"
    )
    return seen(recording, told("wrap", (topic, joints), times, None, "1", said), **{key: whole})


def _of_one_turn(recording: Recording, model: ArmModel) -> Recording:
    """Joint readings that count their turns from where the gearbox's do."""
    both = pair(recording, model, "gearbox_states", "joint_states")
    if both is None:
        return recording
    (gearbox, own), shown = both, recording.series["joint_states"]
    ratio = model.for_joints(own.joints).arm.only(own.joints).ratio
    position, turned = shown.position.copy(), []
    for j, joint in enumerate(own.joints):
        known = np.isfinite(gearbox.position[:, j])
        if recording.unit(joint) == "rad" and known.any():
            asked = np.interp(own.stamp, gearbox.stamp[known], gearbox.position[known, j]) * ratio[j]
            turns = whole_turns(own.position[:, j] - asked)
            position[:, shown.joints.index(joint)] -= turns
            turned += [joint] if turns else []
    if not turned:
        return recording
    said = f"{SHOWN} of {', '.join(turned)} is whole turns off the gearbox: they were taken off"
    observed = told("whole_turns", (SHOWN, tuple(turned)), float(len(turned)), None, "1", said)
    return seen(recording, observed, joint_states=replace(shown, position=position))


def read_when(recording: Recording, model: ArmModel) -> Recording:
    """Readings of joints, then of motors, that are repeated until the next ones come, at the times at which
    they were read.
    """
    for key in ("joint_states", "gearbox_states"):
        series = recording.series.get(key)
        if series is None or len(series.stamp) < 2:
            continue
        shown = recording.series.get("joint_states")
        new, held = new_readings(series) if series is shown else new_motor_readings(series, shown)
        if held:
            ages = {"wire": "a delay of the sensor"} if series is shown else _ages(recording)
            recording = seen(recording, _repeating(key, series, new, held, ages), **{key: new})
    return recording


def _ages(recording: Recording) -> dict[str, str]:
    """What motor readings that are old look like, by the stages that a recording shows."""
    ages = {"wire": "joints that are early", "servo": "a delay of the servos"}
    topics = {"wire": "joint_states", "servo": "setpoints"}
    return {stage: age for stage, age in ages.items() if topics[stage] in recording.series} or ages


def _repeating(
    key: str, series: JointSeries, new: JointSeries, held: float, ages: Mapping[str, str]
) -> Observed:
    """What is said of a topic that holds each of its readings, of which the ``new`` ones are kept."""
    period, topic = float(np.median(np.diff(new.stamp))), TOPICS[key]
    turns = ". Joints are read in turn: others are interpolated to the times of one" * in_turn(series, held)
    said = (
        f"{topic} repeats each reading until the next one comes, every {1e3 * period:.1f} ms: repeats are "
        "left out, and each reading has the time of its first message, less what it waited for that. How "
        f"old a reading is when it comes shows as {' and '.join(ages.values())}{turns}"
    )
    return told("repeats", (topic, new.joints), period, None, "s", said, stages=ages.keys())


def without_tones(recording: Recording, model: ArmModel) -> Recording:
    """Joint readings without the tones that all of them share."""
    both = pair(recording, model, "gearbox_states", "joint_states")
    if both is None:
        return recording
    gearbox, shown = both
    for hum in hums(gearbox, shown, model.for_joints(shown.joints).loaded_arm().only(shown.joints)):
        recording = taken_out(recording, shown.joints, hum)
    return recording


def taken_out(recording: Recording, joints: Sequence[str], hum: Hum) -> Recording:
    """Readings of some joints without a tone that all of them share."""
    series = recording.series["joint_states"]
    position = series.position.copy()
    position[:, [series.joints.index(joint) for joint in joints]] -= hum.at(series.stamp)
    said = (
        f"{SHOWN} has a tone of {hum.frequency:.4g} Hz, {1e3 * hum.size:.3g} mrad on each joint, as hum of "
        "the mains is, which shows as a slow wave where it is faster than half the rate: it was taken out"
    )
    where, advice = (SHOWN, tuple(joints)), "Shield and ground the sensors' cables"
    observed = told("hum", where, hum.size, hum.std, "rad", said, advice)
    return seen(recording, observed, joint_states=replace(series, position=position))


def as_often_as_new(recording: Recording, model: ArmModel) -> Recording:
    """Joint readings that were low-pass filtered, as often as they tell something new."""
    both = pair(recording, model, "gearbox_states", "joint_states")
    found = None if both is None else filtered(*both)
    if both is None or found is None:
        return recording
    series = recording.series["joint_states"]
    said = (
        f"{SHOWN} was low-pass filtered at about {found.frequency:.2g} Hz: from one reading to the next it "
        f"tells nothing new, noise among it, so that one of {found.alike} readings counts"
    )
    where, advice = (SHOWN, both[1].joints), "Publish what the sensor read, unfiltered"
    observed = told("filtered", where, found.frequency, None, "Hz", said, advice)
    fewer = series.rows(np.arange(len(series.stamp)) % found.alike == 0)
    return seen(recording, observed, joint_states=fewer)


def how_coarse(recording: Recording, model: ArmModel) -> Recording:
    """Says how coarse joint readings are where their steps are what one sees of the wire."""
    both = pair(recording, model, "gearbox_states", "joint_states")
    if both is None:
        return recording
    gearbox, shown = both
    found = coarse_steps(gearbox, shown, model.for_joints(shown.joints).arm.only(shown.joints))
    if not found:
        return recording
    step = max(found.values())
    said = (
        f"{SHOWN} of {', '.join(found)} comes in steps of {1e3 * step:.2f} mrad ({2 * np.pi / step:.0f} a "
        "turn) on a joint that mostly rests: a rest anywhere within a step reads the same"
    )
    where, advice = (SHOWN, tuple(found)), "What is smaller than a step cannot be told"
    return seen(recording, told("steps", where, step, None, "rad", said, advice, corrected=False))
