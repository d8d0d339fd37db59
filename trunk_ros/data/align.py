"""Topics of a recording on one time grid, ready to be compared with a model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.chain import REMEMBERED
from trunk_ros.compiled import Array
from trunk_ros.data.forgotten import forgotten, loop_of
from trunk_ros.data.motion_content import MOVED, STANDS, comes_back, extent, is_wide, passed, turned
from trunk_ros.data.repeated_readings import new_motor_readings, new_readings
from trunk_ros.data.span import Span, in_one_piece
from trunk_ros.errors import RecordingError
from trunk_ros.heap import give_back
from trunk_ros.levels import CERTAIN, ENOUGH, HALF, HARDLY, NEARLY, PART, ROUGH, SLIGHT, SURE
from trunk_ros.machine import CELLS
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.encoder import between_counts, counts, noises
from trunk_ros.recording.signal.fill import hold
from trunk_ros.recording.signal.gaps import in_gaps, late, longest_wait, unseen
from trunk_ros.recording.signal.resample import (
    SAME,
    SLOW,
    joint_grid,
    resample,
    stops_to_measure,
)
from trunk_ros.recording.topics import COMPARED
from trunk_ros.resistance import resistance
from trunk_ros.servo_course import all_setpoints, as_the_servo_went, felt, given
from trunk_ros.start import TURNS

UNSEEN = 1e-5  # rad that a joint may have gone on before it turned, in a gap, that do not count
SETTLING = 0.3  # s in which a servo forgets how it began
RESPONDS = SETTLING / 6  # s in which it has gone most of the way to where it was sent
BANDS = 4.0  # dead bands that a joint has to move until it is known where in its play it is


def wire_span(recording: Recording, model: ArmModel) -> Span:
    """Gearbox angles against joint angles. Raises RecordingError where a topic or all common joints are
    missing.
    """
    gearbox, measured = recording.require("gearbox_states"), recording.require("joint_states")
    joints = common_joints(recording, model, gearbox, measured)
    model = model.for_joints(joints)
    measured, held = new_readings(measured.select(joints))
    gearbox = new_motor_readings(gearbox.select(joints), measured)[0]
    steps = counts(gearbox)
    grid, rows, kept = joint_grid(gearbox.stamp, measured.stamp)
    phi, velocity = resample(between_counts(gearbox, steps), grid)
    phi = as_the_servo_went(recording, gearbox, steps, grid, phi, model)
    if len(grid) > CELLS:
        give_back(libraries=True)
    grain = np.maximum(steps, np.sqrt(12.0) * noises(gearbox))
    read = np.isfinite(measured.position[kept])
    valid = seen = read & ~in_gaps(gearbox, grid)[rows]
    target = np.asfortranarray(np.where(valid, measured.position[kept], 0.0))  # as a span has it: no copy
    arm = model.arm.only(joints)
    u = phi * arm.ratio
    far = extent(u)
    start = _start(far, rows, valid)
    least = np.maximum(MOVED * np.ptp(u, axis=0), np.maximum(BANDS * arm.dead_band, STANDS))
    least[_goes_on(u) & (arm.dead_band == 0.0)] = -1.0  # there is no play to be seen
    at = in_one_piece(rows)
    loop = loop_of(u[at], target, valid)
    past = np.minimum(least, np.maximum(BANDS * loop, STANDS))
    small = np.maximum(noises(measured) / 2, UNSEEN)
    small = np.maximum(small, np.where(np.isfinite(loop), ROUGH * loop, 0.0))  # wide ones are hardly moved
    scatters = np.abs(arm.ratio) * np.maximum(steps, SURE * np.sqrt(2.0) * noises(gearbox))
    counted = _counted(far, rows, start, least)
    del far
    counted |= ~counted.any(axis=0) & _moved_along(target, valid, start, noises(measured))
    met = valid & counted
    valid = met & ~forgotten(u, grid, gearbox.stamp, past, small, scatters)[rows]
    counting = tuple(each.mean(axis=0) for each in (read, seen, met, valid))
    early = np.zeros_like(valid)
    if len(rows) > 1 and float(np.median(np.diff(grid[rows]))) < SLOW:
        late = _beside_wide_loops(u[at], target, valid)
        valid, early = valid & late, valid & ~late
        for j in np.flatnonzero(early.any(axis=0)):
            early[:, j] &= ~passed(u[rows, j], velocity[rows, j], valid[:, j])
    del u
    known = resistance(arm, gearbox, grid, phi, measured)
    span = Span(
        recording.name, joints, grid, phi, velocity, rows, target, valid, phi, start, known, held, grain
    )
    unsure = 1e-6 * _unsure(recording, "skew"), _unsure(recording, "early")
    span = replace(span, shown=counts(measured), unsure=unsure, counting=counting)
    if not stops_to_measure(gearbox.stamp):
        span = replace(span, lost=unseen(gearbox))
    if stops_to_measure(span.stamp):
        return with_the_unseen(span, stops_to_measure(gearbox.stamp))
    return replace(with_the_unseen(span, stops=False), early=early) if early.any() else span


def _unsure(recording: Recording, kind: str) -> float:
    """Standard deviation of what was corrected, in its unit; 0 where nothing was."""
    stds = [seen.std for seen in recording.observed if seen.kind == kind and seen.corrected]
    return max((std for std in stds if std is not None), default=0.0)


def with_the_unseen(span: Span, stops: bool) -> Span:
    """The same with rows for what moved before the recording, at first nothing, and, where the motors were
    only seen at ``stops``, with one before each of them for how it was reached, at first straight.
    """
    each = np.repeat(np.arange(len(span.grid)), 2 if stops else 1)[1 if stops else 0 :]
    order = np.concatenate([np.zeros(TURNS, dtype=int), each])
    return replace(
        span,
        grid=span.grid[order],
        source=span.source[order],
        velocity=span.velocity[order],
        gearbox=span.gearbox[order],
        rows=(2 if stops else 1) * span.rows + TURNS,
        resistance=None if span.resistance is None else span.resistance.part(order),
        before=TURNS,
        arrives=np.arange(TURNS + 1, len(order), 2) if stops else span.arrives,
    )


def _beside_wide_loops(u: Array, target: Array, valid: np.ndarray) -> np.ndarray:
    """(n, joints): from the first turn on where the loop is wide: its play is not as forgetful as a narrow
    one.
    """
    out = np.ones_like(valid)
    for j, seen in enumerate(valid.T):
        if is_wide(u[seen, j], (target - u)[seen, j], target[seen, j]):
            out[:, j] = turned(u[:, j])
    return out


def _goes_on(u: Array) -> np.ndarray:
    """(joints,): where a joint moves, and one way only."""
    return np.array([not comes_back(column) and float(np.ptp(column)) > STANDS for column in u.T])


def servo_joints(recording: Recording, model: ArmModel) -> tuple[str, ...]:
    """Joints of which setpoints and gearbox angles were recorded."""
    both = recording.require("setpoints"), recording.require("gearbox_states")
    return common_joints(recording, model, *both)


def driven(recordings: Iterable[Recording], model: ArmModel, joints: tuple[str, ...]) -> list[Recording]:
    """The recordings that show what the servos of ``joints`` were asked, and where these went."""
    both = (r for r in recordings if set(COMPARED["servo"]) <= r.series.keys())
    return [r for r in both if servo_joints(r, model) == joints]


def servo_span(recording: Recording, model: ArmModel) -> Span:
    """Setpoints against gearbox angles. Lost setpoints are bridged, and what servos did while nobody recorded
    theirs for long is not known: after that they begin anew as they are read. A joint without any counts
    nowhere.
    """
    setpoints, gearbox = recording.require("setpoints"), recording.require("gearbox_states")
    joints = servo_joints(recording, model)
    setpoints, shown = setpoints.select(joints), recording.series.get("joint_states")
    told = np.isfinite(setpoints.position).any(axis=0)
    setpoints = given(setpoints, model)
    gearbox = new_motor_readings(gearbox.select(joints), shown)[0]
    asked = all_setpoints(recording, joints, model) or setpoints
    grid, rows, kept = joint_grid(asked.stamp, gearbox.stamp, fine=False)
    held = np.clip(np.searchsorted(asked.stamp, grid + SAME, side="right") - 1, 0, None)
    source = np.asfortranarray(hold(asked.position)[in_one_piece(held)])
    arm = model.for_joints(joints).arm.only(joints)
    small = np.maximum(noises(gearbox) / 2, UNSEEN)
    phi, velocity = resample(gearbox, grid)
    unsettled, anew = _after_gaps(setpoints, grid, phi, in_gaps(gearbox, grid), small)
    unsettled |= (grid < grid[0] + SETTLING)[:, None]
    valid = np.isfinite(gearbox.position[kept]) & told & ~unsettled[rows]
    target = np.asfortranarray(np.where(valid, gearbox.position[kept], 0.0))
    unknown = (np.empty(0, dtype=int),) * len(joints)
    known = felt(recording, arm, grid)
    return Span(
        recording.name, joints, grid, source, velocity, rows, target, valid, phi, unknown, known, anew=anew
    )


def common_joints(recording: Recording, model: ArmModel, *series: JointSeries) -> tuple[str, ...]:
    """Joints that all the topics and the model have, in the model's order."""
    known = model.for_joints(series[0].joints).arm.joints if model.any_joints else model.arm.joints
    joints = tuple(j for j in known if all(j in s.joints for s in series))
    if not joints:
        have = "; ".join(dict.fromkeys(", ".join(s.joints) for s in series))
        raise RecordingError(
            f"{recording.name}: no joint of the model ({', '.join(known)}) is in the recording ({have}): "
            "give the arm's own --model, or --model direct"
        )
    return joints


def _after_gaps(
    setpoints: JointSeries, grid: Array, phi: Array, lost: np.ndarray, small: Array
) -> tuple[np.ndarray, Array]:
    """(m, joints): where setpoints may have been lost, and until each servo has forgotten them; and (k,) s
    when all begin anew after a long gap: once those before it act no more, where some gearbox angle is not
    ``lost`` (m, joints). What may have been missed in a gap and takes no servo further than ``small``
    (joints,) rad does not count. ``phi`` (m, joints) rad of the shafts.
    """
    stamp, position = setpoints.stamp, hold(setpoints.position)
    out, anew, seen = np.zeros(phi.shape, dtype=bool), [], grid[~np.all(lost, axis=1)]
    longest = longest_wait(stamp)
    gaps = np.setdiff1d(np.flatnonzero(np.diff(stamp) > longest), _harmless(setpoints, small))
    each = zip(position.T, phi.T, strict=True) if len(gaps) else ()
    forgets = [_forgets(stamp, *one, grid) for one in each]
    for k in gaps:
        begun = stamp[k + 1]
        if stamp[k + 1] - stamp[k] > SETTLING:
            after = seen[np.searchsorted(seen, stamp[k + 1] + REMEMBERED - SAME) :]
            anew.extend(after[:1])
            begun = after[0] if len(after) else np.inf
        first = np.searchsorted(grid, stamp[k] + longest / 2)
        for j, time in enumerate(forgets):
            settled = SETTLING + (np.interp(begun, grid, time) if np.isfinite(begun) else np.inf)
            out[first : np.searchsorted(time, settled), j] = True
    return out, np.unique(anew)


def _forgets(stamp: Array, position: Array, phi: Array, grid: Array) -> Array:
    """(m,) s in which a servo forgets: while its shaft, at ``phi`` (m,) rad, goes at its top speed and not as
    its setpoints do, at ``position`` (n,) rad, it only follows them once it has caught up.
    """
    new = np.diff(position, prepend=np.nan) != 0.0  # those that are sent again go on as they did
    asked, went = _pace(stamp[new], position[new], grid), _pace(grid, phi, grid)
    top = np.quantile(np.abs(went), 1.0 - HARDLY)
    behind = (np.abs(went) > NEARLY * top) & (np.abs(asked - went) > PART * top)
    return np.cumsum(np.where(behind, 0.0, np.diff(grid, prepend=grid[:1])))


def _pace(stamp: Array, position: Array, grid: Array) -> Array:
    """(m,) rad/s, on the whole for as long as a servo takes to respond: of encoders' steps little is left."""
    ends = (np.interp(grid + sign * RESPONDS / 2, stamp, position) for sign in (1.0, -1.0))
    return np.asarray(np.subtract(*ends) / RESPONDS)


def hidden_by_gaps(recording: Recording) -> str:
    """What is said of a recording most of which follows lost setpoints; "" of any other."""
    setpoints, gearbox = recording.series.get("setpoints"), recording.series.get("gearbox_states")
    if setpoints is None or gearbox is None:
        return ""
    joints = tuple(joint for joint in setpoints.joints if joint in gearbox.joints)
    setpoints, small = setpoints.select(joints), np.maximum(noises(gearbox.select(joints)) / 2, UNSEEN)
    wide = np.flatnonzero(np.diff(setpoints.stamp) > longest_wait(setpoints.stamp))
    times = len(np.setdiff1d(wide, _harmless(setpoints, small)))
    if times * SETTLING <= HALF * recording.duration:
        return ""
    return (
        f"setpoints are missing {times} times, and the {SETTLING:g} s after each, in which it is unknown "
        "what the servos follow, leave too little: record all of them"
    )


def _harmless(setpoints: JointSeries, small: Array) -> np.ndarray:
    """(k,) samples after which the next comes late, yet too soon for a servo to go further than ``small``
    (joints,) rad by anything that was missed.
    """
    seen = late(setpoints)
    share = np.diff(setpoints.stamp)[seen.after] / RESPONDS
    return np.asarray(seen.after[(share <= 1.0) & np.all(share[:, None] * seen.off <= small, axis=1)])


def _counted(far: Array, rows: np.ndarray, start: tuple[np.ndarray, ...], least: Array) -> np.ndarray:
    """(n, joints): where the state of the play is known: from where a joint has moved ``far`` (m, joints)
    enough for that at the start to be forgotten, and before where it was seen to stand as it began. A joint
    that hardly moves counts nowhere.
    """
    engaged = far > least
    standing = (far < STANDS) & engaged.any(axis=0) & np.array([len(s) > 0 for s in start])
    return np.asarray((engaged | standing)[rows])


def _moved_along(target: Array, valid: np.ndarray, start: tuple[np.ndarray, ...], noise: Array) -> np.ndarray:
    """(joints,): where others or the load move a joint by more than its noise, whatever its own motor does,
    and what it reads at first tells where it lies in its play.
    """
    out = np.array([len(seen) > 0 for seen in start])
    for j in np.flatnonzero(out):
        low, high = np.quantile(target[valid[:, j], j], [SLIGHT, 1.0 - SLIGHT])
        out[j] = high - low > CERTAIN * noise[j]
    return out


def _start(far: Array, rows: np.ndarray, valid: np.ndarray) -> tuple[np.ndarray, ...]:
    """The first rows of the target at which each joint stands, if it stands long before it goes ``far``."""
    still = (far < STANDS)[rows]
    seen = [np.flatnonzero(still[:, j] & valid[:, j]) for j in range(valid.shape[1])]
    return tuple(s if len(s) >= ENOUGH else s[:0] for s in seen)
