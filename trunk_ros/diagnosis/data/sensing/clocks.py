"""Clocks put right: when readings were taken, when setpoints acted, and all setpoints that there were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.diagnosis.data.sensing.pairs import pair, seen
from trunk_ros.diagnosis.data.sensing.readings import how_coarse, read_when, without_tones
from trunk_ros.diagnosis.data.sensing.skew import Skew, skew, without_skew
from trunk_ros.diagnosis.data.sensing.sliding import sliding, waited
from trunk_ros.diagnosis.data.sensing.thinned import thinned
from trunk_ros.diagnosis.levels import TURNS
from trunk_ros.model import Model
from trunk_ros.recording.observed import Observed
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.topics import TOPICS

SHOWN, DRIVEN, ASKED = TOPICS["joint_states"], TOPICS["gearbox_states"], TOPICS["setpoints"]


def clocks_put_right(recording: Recording, model: Model) -> Recording:
    """Readings and setpoints with the times at which they were taken and acted, and all setpoints there were;
    of coarse readings it is said how coarse they are. Units and names of joints have to be right.
    """
    for look in (read_when, _at_one_pace, _all_setpoints, _acted_when, without_tones, how_coarse):
        recording = look(recording, model)
    return recording


def _at_one_pace(recording: Recording, model: Model) -> Recording:
    """Joint stamps of the gearbox's clock."""
    both = pair(recording, model, "gearbox_states", "joint_states")
    found = None if both is None else _whole_skew(*both, model)
    if both is None or found is None:
        return recording
    runs = "fast" if found.rate > 0.0 else "slow"
    said = (
        f"the clock of {SHOWN} runs {1e6 * abs(found.rate):.0f} ± {1e6 * found.std:.1f} ppm {runs} beside "
        f"that of {DRIVEN}: its stamps were corrected from the beginning on. It would have looked like "
        "friction_wear, thermal_drift or a sensor_delay that changes. Synchronise the clocks (chrony, PTP)"
    )
    looks, value = ("friction_wear", "thermal_drift", "sensor_delay"), 1e6 * found.rate
    observed = Observed("skew", SHOWN, both[1].joints, value, 1e6 * found.std, "ppm", True, looks, said)
    return seen(recording, observed, joint_states=without_skew(recording.series["joint_states"], found))


def _whole_skew(gearbox: JointSeries, shown: JointSeries, model: Model) -> Skew | None:
    arm, whole = model.for_joints(shown.joints).loaded_arm().only(shown.joints), None
    for _ in range(TURNS):  # what is left of a large one shows when most of it is gone
        found = skew(gearbox, shown if whole is None else without_skew(shown, whole), arm)
        if found is None:
            return whole
        whole = found if whole is None else Skew(whole.rate + found.rate, found.std)
    return whole


def _all_setpoints(recording: Recording, model: Model) -> Recording:
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
        f"{found.times * rate:.0f} Hz): those between were filled in{led}. It would have looked like "
        "servo_bandwidth, servo_delay or unknown over speed. Record all setpoints"
    )
    looks = ("servo_bandwidth", "servo_delay", "unknown")
    observed = Observed("thinned", ASKED, setpoints.joints, found.times, None, "1", True, looks, said)
    return seen(recording, observed, setpoints=found.setpoints)


def _guide(recording: Recording, setpoints: JointSeries, model: Model) -> JointSeries | None:
    """The reference on the gearbox's side, where it has all joints of the setpoints."""
    reference, joints = recording.series.get("reference"), setpoints.joints
    if reference is None or not set(joints) <= set(reference.joints):
        return None
    arm = model.for_joints(joints).arm.only(joints)
    asked = reference.select(joints)
    return replace(asked, position=asked.position / arm.ratio)


def _acted_when(recording: Recording, model: Model) -> Recording:
    """Setpoints at the times at which a servo looked at them whose loop slides past theirs."""
    both = pair(recording, model, "setpoints", "gearbox_states")
    found = None if both is None else sliding(*both, model.for_joints(both[0].joints))
    if both is None or found is None:
        return recording
    said = (
        f"{ASKED} acts after a latency that wanders from 0 to {1e3 * found.longest:.1f} ms, once every "
        f"{abs(found.takes):.2f} s: the servo's own loop slides past that of the setpoints. The wandering "
        "was taken out; its mean shows as servo_delay. It would have looked like unknown over speed. Drive "
        "both from one clock"
    )
    looks = ("unknown", "servo_delay", "servo_bandwidth")
    observed = Observed(
        "wandering_latency", ASKED, both[0].joints, found.longest, None, "s", True, looks, said
    )
    return seen(recording, observed, setpoints=waited(both[0], found))
