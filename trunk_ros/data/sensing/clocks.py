"""Clocks put right: when readings were taken, when setpoints acted, and all setpoints that there were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm_model import ArmModel
from trunk_ros.data.sensing.offset import Offset, early, in_stamps, step
from trunk_ros.data.sensing.pairs import pair, seen, told
from trunk_ros.data.sensing.readings import as_often_as_new, how_coarse, read_when, without_tones
from trunk_ros.data.sensing.skew import Skew, skew, without_skew
from trunk_ros.data.sensing.sliding import sliding, waited
from trunk_ros.data.sensing.thinned import KIND, thinned
from trunk_ros.heap import give_back
from trunk_ros.levels import TURNS
from trunk_ros.machine import CELLS
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.topics import TOPICS

SHOWN, DRIVEN, ASKED = TOPICS["joint_states"], TOPICS["gearbox_states"], TOPICS["setpoints"]


def clocks_put_right(recording: Recording, model: ArmModel) -> Recording:
    """Readings and setpoints with the times at which they were taken and acted, and all setpoints there were;
    of coarse readings it is said how coarse they are, and of filtered ones those are kept that tell something
    new. Units and names of joints have to be right.
    """
    long = any(len(series.stamp) > CELLS for series in recording.series.values())
    for look in (
        read_when,
        _not_set,
        _at_one_pace,
        _not_early,
        _all_setpoints,
        _acted_when,
        without_tones,
        how_coarse,
        as_often_as_new,
    ):
        recording = look(recording, model)
        give_back(libraries=long)
    return recording


def _at_one_pace(recording: Recording, model: ArmModel) -> Recording:
    """Joint stamps of the gearbox's clock."""
    both = pair(recording, model, "gearbox_states", "joint_states")
    found = None if both is None else _whole_skew(*both, _arm(both[1], model))
    if both is None or found is None:
        return recording
    runs = "fast" if found.rate > 0.0 else "slow"
    said = (
        f"the clock of {SHOWN} runs {1e6 * abs(found.rate):.0f} ± {1e6 * found.std:.1f} ppm {runs} beside "
        f"that of {DRIVEN}: its stamps were corrected from the beginning on"
    )
    where, advice = (SHOWN, both[1].joints), "Synchronise the clocks (chrony, PTP)"
    observed = told("skew", where, 1e6 * found.rate, 1e6 * found.std, "ppm", said, advice)
    return seen(recording, observed, joint_states=without_skew(recording.series["joint_states"], found))


def _not_set(recording: Recording, model: ArmModel) -> Recording:
    """Stamps as they had gone on if nobody had set a clock in mid-run."""
    for _ in range(TURNS):
        both = pair(recording, model, "gearbox_states", "joint_states")
        found = None if both is None else step(*both, _arm(both[1], model))
        if both is None or found is None:
            break
        key, jump = ("gearbox_states", "joint_states")[found[0]], found[1]
        back = _set_back(recording, jump)
        if key not in back:  # its stamps are too uneven to tell
            break
        said = (
            f"the clock of {TOPICS[key]} was set by {1e3 * jump.size:+.2f} ± {1e3 * jump.std:.2f} ms at "
            f"{jump.since:.2f} s: its stamps were corrected from then on"
        )
        where, advice = (TOPICS[key], both[1].joints), "Let chrony slew clocks while the arm runs"
        observed = told("clock_step", where, jump.size, jump.std, "s", said, advice)
        recording = seen(recording, observed, **back)
    return recording


def _set_back(recording: Recording, jump: Offset) -> dict[str, JointSeries]:
    """All topics of the clock that was set: those whose stamps jump with it."""
    near = np.array([jump.since, jump.since]) if jump.since is not None else np.empty(0)
    jumps = {key: in_stamps(series.stamp, jump, near) for key, series in recording.series.items()}
    return {key: one.off(recording.series[key]) for key, one in jumps.items() if one is not None}


def _not_early(recording: Recording, model: ArmModel) -> Recording:
    """Joint readings that do not come before the motion that they show."""
    both = pair(recording, model, "gearbox_states", "joint_states")
    found = None if both is None else early(*both, _arm(both[1], model))
    if both is None or found is None:
        return recording
    said = (
        f"{SHOWN} shows motion {-1e3 * found.size:.2f} ± {1e3 * found.std:.2f} ms before {DRIVEN} does, on "
        f"all joints, as no physics can: its clock is early, or {DRIVEN} is late. Its stamps were corrected "
        "by that"
    )
    advice = "Synchronise the clocks, or stamp readings where they are taken"
    observed = told("early", (SHOWN, both[1].joints), -found.size, found.std, "s", said, advice)
    return seen(recording, observed, joint_states=found.off(recording.series["joint_states"]))


def _arm(shown: JointSeries, model: ArmModel) -> Arm:
    return model.for_joints(shown.joints).loaded_arm().only(shown.joints)


def _whole_skew(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> Skew | None:
    whole = None
    for _ in range(TURNS):  # what is left of a large one shows when most of it is gone
        found = skew(gearbox, shown if whole is None else without_skew(shown, whole), arm)
        if found is None:
            return whole
        whole = found if whole is None else Skew(whole.rate + found.rate, found.std)
    return whole


def _all_setpoints(recording: Recording, model: ArmModel) -> Recording:
    """Setpoints with those that were not recorded between them."""
    both = pair(recording, model, "setpoints", "gearbox_states")
    if both is None:
        return recording
    setpoints, gearbox = both
    guide = _guide(recording, setpoints, model)
    found = thinned(setpoints, gearbox, model.for_joints(setpoints.joints), guide)
    if found is None:
        return recording
    rate, led = (
        1.0 / float(np.median(np.diff(setpoints.stamp))),
        "" if guide is None else " as the reference moves",
    )
    said = (
        f"{ASKED} holds one of {found.times} setpoints that the servo got ({rate:.0f} Hz of "
        f"{found.times * rate:.0f} Hz): those between were filled in{led}"
    )
    where = ASKED, setpoints.joints
    observed = told(KIND, where, found.times, None, "1", said, "Record all setpoints")
    return seen(recording, observed, setpoints=found.setpoints)


def _guide(recording: Recording, setpoints: JointSeries, model: ArmModel) -> JointSeries | None:
    """The reference on the gearbox's side, where it has all joints of the setpoints."""
    reference, joints = recording.series.get("reference"), setpoints.joints
    if reference is None or not set(joints) <= set(reference.joints):
        return None
    arm = model.for_joints(joints).arm.only(joints)
    asked = reference.select(joints)
    return replace(asked, position=asked.position / arm.ratio)


def _acted_when(recording: Recording, model: ArmModel) -> Recording:
    """Setpoints at the times at which a servo looked at them whose loop slides past theirs."""
    both = pair(recording, model, "setpoints", "gearbox_states")
    found = None if both is None else sliding(*both, model.for_joints(both[0].joints))
    if both is None or found is None:
        return recording
    said = (
        f"{ASKED} acts after a latency that wanders from 0 to {1e3 * found.longest:.1f} ms, once every "
        f"{abs(found.takes):.2f} s: the servo's own loop slides past that of the setpoints. The wandering "
        "was taken out; its mean shows as a delay of the servo"
    )
    where = ASKED, both[0].joints
    observed = told("wandering_latency", where, found.longest, None, "s", said, "Drive both from one clock")
    return seen(recording, observed, setpoints=waited(both[0], found))
