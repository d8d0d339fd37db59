"""Another simulator's recording beside that of the arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.data.span import Span
from trunk_ros.diagnosis.context import LEAST, Context
from trunk_ros.guards import SAME
from trunk_ros.levels import FAR_OFF
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.signal.fill import hold
from trunk_ros.recording.signal.resample import longest_gap


def on_the_clock(other: Recording, recording: Recording) -> Recording:
    """Another recording of a motion with its stamps counted from the start of ``recording``.

    Where their stamps are not of the same time, both starts are taken as one moment.
    """
    off = (other.start_ns - recording.start_ns) / 1e9
    if not off or abs(off) >= recording.duration:
        return other
    series = {key: replace(each, stamp=each.stamp + off) for key, each in other.series.items()}
    return replace(other, start_ns=recording.start_ns, series=series)


def sides_told(recording: Recording, other: Recording) -> Recording:
    """The recording, with a note where one of the two has its joints for the motor side and not the other."""
    pair = recording, other
    for one, far in (pair, pair[::-1]):
        own, geared = ratios(one), ratios(far)
        if joints := [joint for joint in own if own[joint] == 1.0 and _is_gear(geared.get(joint, 1.0))]:
            note = (
                f"{one.name} has the same angles for motor side and joint on {', '.join(joints)}, "
                f"in {far.name} {joints[0]} turns by {geared[joints[0]]:.3g} of its motor: "
                "was the motor side recorded?"
            )
            return replace(recording, notes=(*recording.notes, note))
    return recording


def _is_gear(ratio: float) -> bool:
    return not 1.0 - FAR_OFF < abs(ratio) < 1.0 / (1.0 - FAR_OFF)


def ratios(recording: Recording) -> dict[str, float]:
    """How far each joint turns per motor side, by the spread of both; 1 where their readings are the same."""
    motor, joint = (recording.series.get(key) for key in ("gearbox_states", "joint_states"))
    if motor is None or joint is None:
        return {}
    out = {}
    for name in (each for each in joint.joints if each in motor.joints):
        given, shown = (hold(each.select((name,)).position)[:, 0] for each in (motor, joint))
        there = np.interp(joint.stamp, motor.stamp, given)
        if np.ptp(there) and np.ptp(shown):
            same = bool(np.abs(shown - there).max() <= SAME * np.ptp(there))
            out[name] = 1.0 if same else float(np.polyfit(there, shown, 1)[0])
    return out


def shifted(span: Span, of_simulator: Context) -> Span:
    """Targets less what the simulator does beyond the model of it, with ``of_simulator`` the stage of its own
    recording: what is then missing in the model is missing in the simulator.
    """
    theirs = of_simulator.views[0].span
    target, valid = span.target.copy(), span.valid.copy()
    for c, joint in enumerate(span.joints):
        j = theirs.joints.index(joint)
        known, rest = theirs.valid[:, j], of_simulator.residual(0, of_simulator.known, j)
        if known.sum() < LEAST:
            valid[:, c] = False
            continue
        at = theirs.stamp[known]
        target[:, c] -= np.interp(span.stamp, at, rest[known])
        after = np.clip(np.searchsorted(at, span.stamp), 1, len(at) - 1)
        valid[:, c] &= (span.stamp >= at[0]) & (span.stamp <= at[-1])
        valid[:, c] &= at[after] - at[after - 1] <= longest_gap(theirs.stamp)
    start = (np.empty(0, dtype=int),) * len(span.joints)
    return replace(span, target=target, valid=valid, start=start, early=None)


def completed(recording: Recording, other: Recording | None) -> Recording:
    """A recording without gearbox angles takes them from the other simulator's."""
    if other is None or "gearbox_states" in recording.series or "gearbox_states" not in other.series:
        return recording
    note = f"gearbox angles were not recorded: those of {other.name} are used"
    gearbox = on_the_clock(other, recording).series["gearbox_states"]
    series = {**recording.series, "gearbox_states": gearbox}
    return replace(recording, series=series, notes=(*recording.notes, note))
