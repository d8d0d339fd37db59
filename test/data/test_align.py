"""What counts when a recording is compared with a model: gaps, lower rates, other clocks."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from test.diagnosis.arms import diagnose, of_joints, of_the_wires, on, recorded
from trunk_ros.chain import Chain
from trunk_ros.data import surroundings
from trunk_ros.data.align import servo_span, wire_span
from trunk_ros.data.counting import counting_told
from trunk_ros.data.seen import at, joined, now_of
from trunk_ros.data.sensor_faults import without_faults
from trunk_ros.data.span import Span
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.prospects import prospects
from trunk_ros.diagnosis.simulators.other_simulator import on_the_clock
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.diagnosis.stages.stage import Stage
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.diagnosis.tip.data import tip_data
from trunk_ros.diagnosis.tip.stage import ArmProblem
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.errors import RecordingError
from trunk_ros.model import load_model
from trunk_ros.recording.recording import JointSeries, PoseSeries, Recording
from trunk_ros.servo_course import servo_course
from trunk_ros.simulate import simulate

TRUNK = load_model("trunk")


def kept(recording: Recording, keep: dict[str, np.ndarray]) -> Recording:
    """A recording with some samples (masks) of some topics."""

    def of(series: JointSeries, mask: np.ndarray) -> JointSeries:
        velocity = None if series.velocity is None else series.velocity[mask]
        return replace(series, stamp=series.stamp[mask], position=series.position[mask], velocity=velocity)

    series = {k: of(s, keep[k]) if k in keep else s for k, s in recording.series.items()}
    return replace(recording, series=series)


def with_gap(recording: Recording, *keys: str) -> Recording:
    stamp = recording.series["joint_states"].stamp
    return kept(recording, dict.fromkeys(keys, (stamp < 5.0) | (stamp > 10.0)))


def worst(stage: Stage) -> float:
    context = first_look(stage)
    columns = range(len(context.joints))
    return max(float(np.abs(context.residual(0, Hypothesis(), c)).max()) for c in columns)


def wire(recording: Recording) -> Span:
    return wire_span(recording, TRUNK)


def test_what_is_seen_of_one_joint_is_no_copy() -> None:
    recording = recorded({}, 10.0)
    for span in (wire_span(recording, TRUNK), servo_span(recording, TRUNK)):
        view = Stage._view(WireStage([span], TRUNK), span)
        assert np.shares_memory(view.columns[1].target, span.target)
        assert np.shares_memory(view.columns[1].speed, view.of(1)[1])
        assert np.shares_memory(now_of(view, TRUNK.arm, 1).gearbox, span.gearbox)


def test_what_effects_see_of_other_joints_speeds_is_theirs_at_all_steps_and_at_some() -> None:
    span = wire_span(recorded({}, 10.0), TRUNK)
    view = Stage._view(WireStage([span], TRUNK), span)
    rows, speeds = np.array([3, 30, 31]), span.velocity * TRUNK.arm.ratio
    now = joined([now_of(view, TRUNK.arm, column) for column in (1, 4)])
    some = at(now, rows)
    assert np.array_equal(now.speeds, speeds)
    assert np.array_equal(some.speeds, speeds[rows])
    assert np.array_equal(now.speed_of(2), speeds[:, 2])
    assert np.array_equal(some.speed_of(2), speeds[rows, 2])
    assert np.array_equal(now.speed, speeds[:, [1, 4]])


def test_of_a_long_recording_the_wires_are_made_anew_for_who_still_asks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    span = wire_span(recorded({}, 10.0), TRUNK)
    view = Stage._view(WireStage([span], TRUNK), span)
    wires = view.wires
    assert view.turned(wires + 0.1).wires is wires
    monkeypatch.setattr(surroundings, "CELLS", len(span.grid) - 1)
    turned = view.turned(wires + 0.1)
    assert turned.wires is not wires
    assert np.array_equal(turned.wires, wires)
    assert np.array_equal(turned.angles, wires + 0.1)


def test_a_prediction_does_not_swing_out_where_gearbox_angles_are_missing() -> None:
    recording = recorded(seconds=15.0)
    whole = np.abs(simulate(recording, TRUNK).series["joint_states"].position).max()
    predicted = simulate(with_gap(recording, "gearbox_states"), TRUNK)
    assert np.abs(predicted.series["joint_states"].position).max() < 1.01 * whole


def test_after_a_long_gap_a_nominal_arm_shows_no_misfit() -> None:
    recording = with_gap(recorded(seconds=15.0), "gearbox_states", "joint_states", "setpoints")
    assert worst(WireStage([wire(recording)], TRUNK)) < 6e-4
    assert worst(ServoStage([servo_span(recording, TRUNK)], TRUNK)) < 6e-5


@pytest.mark.parametrize("late", [0.0, 0.25])
def test_after_lost_setpoints_a_servo_that_can_go_no_faster_begins_anew(late: float) -> None:
    """It had been far behind for long: the last setpoint before them had held it, so it seemed. One that is
    late goes on by that one until the next ones act.
    """
    hidden = {"velocity_saturation": {"v_max": 0.35}, "servo_delay": {"delay": late}}
    recording = recorded({name: values for name, values in hidden.items() if all(values.values())}, 20.0)
    stamp = recording.series["setpoints"].stamp
    lost = kept(recording, {"setpoints": (stamp < 8.0) | (stamp > 9.0)})
    span = servo_span(lost, TRUNK)
    assert span.anew == pytest.approx([9.6], abs=0.03)
    context = first_look(ServoStage([span], TRUNK))
    everywhere: dict[int, dict[str, float]] = {c: {} for c in range(5)}
    found = Hypothesis({name: Term(name, "alike", values, everywhere) for name, values in hidden.items()})
    assert max(float(np.abs(context.residual(0, found, c)).max()) for c in range(5)) < 2e-4
    assert max(float(np.abs(context.residual(0, Hypothesis(), c)).max()) for c in range(5)) > 1e-2


def test_one_encoder_that_is_not_read_after_lost_setpoints_takes_nothing_from_the_others() -> None:
    recording = recorded(seconds=20.0)
    stamp, gearbox = recording.series["setpoints"].stamp, recording.series["gearbox_states"]
    position = gearbox.position.copy()
    position[(gearbox.stamp > 8.5) & (gearbox.stamp < 15.0), 4] = np.nan
    unread = replace(
        recording, series={**recording.series, "gearbox_states": replace(gearbox, position=position)}
    )
    span = servo_span(kept(unread, {"setpoints": (stamp < 8.0) | (stamp > 9.0)}), TRUNK)
    assert span.valid[:, 0].mean() > 0.85


def test_a_servo_seen_rarely_is_not_blamed_for_its_unknown_start() -> None:
    recording = recorded(seconds=15.0)
    rare = np.arange(len(recording.series["gearbox_states"].stamp)) % 10 == 3
    recording = kept(recording, {"gearbox_states": rare})
    assert worst(ServoStage([servo_span(recording, TRUNK)], TRUNK)) < 6e-5


def test_another_simulator_whose_bag_starts_later_is_no_delay() -> None:
    recording = recorded(seconds=15.0)
    said = simulate(recording, TRUNK)
    joints = said.series["joint_states"]
    later = replace(joints, stamp=joints.stamp[3:] - joints.stamp[3], position=joints.position[3:])
    said = replace(said, start_ns=said.start_ns + 30_000_000, series={"joint_states": later})
    moved = on_the_clock(said, recording).series["joint_states"]
    assert moved.stamp == pytest.approx(joints.stamp[3:])


def test_another_simulator_with_a_clock_of_its_own_starts_together_with_the_recording() -> None:
    recording = recorded(seconds=5.0)
    said = replace(simulate(recording, TRUNK), start_ns=0)
    assert on_the_clock(said, recording) is said


def test_what_is_found_on_some_joints_is_a_model_of_the_whole_arm() -> None:
    recording = recorded({"backlash": {"half_width": on(2, 8e-4)}}, 15.0)
    two = recording.series["gearbox_states"].select(("joint_1", "joint_2"))
    recording = replace(recording, series={**recording.series, "gearbox_states": two})
    model = diagnose([of_the_wires(recording)]).model
    assert model.effects["backlash"]["half_width"] == pytest.approx(on(2, 8e-4), abs=5e-5)
    assert simulate(recorded(seconds=5.0), model).series["joint_states"].joints == model.arm.joints


def test_recordings_of_one_name_keep_a_quality_each() -> None:
    result = diagnose([of_two(of_the_wires(recorded(seconds=5.0, seed=seed))) for seed in (0, 4)])
    assert list(result.quality) == ["made", "made (2)"]


def test_a_recording_in_which_nothing_can_be_judged_is_refused() -> None:
    recording = recorded(seconds=0.3)
    with pytest.raises(RecordingError, match="no joint moves for 50 samples"):
        diagnose([recording])


T = np.arange(0.0, 20.0, 0.002)


def under_setpoints(stamp: np.ndarray, went: np.ndarray, kept: np.ndarray | None = None) -> Recording:
    """What servos did under setpoints (n,) or (n, 5) rad at stamps (n,) s, recorded where they were kept."""
    position = went if went.ndim == 2 else np.outer(went, np.ones(5))
    setpoints = JointSeries(stamp, TRUNK.arm.joints, position)
    gearbox = servo_course(setpoints, stamp, TRUNK)
    seen = setpoints if kept is None else setpoints.rows(kept)
    return Recording("made", 0, float(stamp[-1]), {"setpoints": seen, "gearbox_states": gearbox})


def test_a_sender_that_is_held_up_now_and_then_loses_no_setpoints() -> None:
    """It goes on where it was: its steps are as long over a gap as between all others."""
    stamp = np.cumsum(np.where(np.arange(len(T)) % 50 == 30, 0.006, 0.002))
    recording = under_setpoints(stamp, np.sin(2.0 * T))
    span = servo_span(recording, TRUNK)
    assert span.valid.mean() > 0.95
    assert worst(ServoStage([span], TRUNK)) < 6e-5
    assert next(one for one in prospects(recording, TRUNK) if one.stage == "servo").joints


def test_a_single_setpoint_that_is_lost_on_an_even_way_hides_nothing() -> None:
    recording = under_setpoints(T, 0.2 * T, np.arange(len(T)) % 50 != 30)
    span = servo_span(recording, TRUNK)
    assert span.valid.mean() > 0.95
    assert worst(ServoStage([span], TRUNK)) < 6e-5


@pytest.mark.parametrize("grain", [1e-9, 2e-3])
def test_a_servo_at_its_top_speed_does_not_forget_what_was_lost(grain: float) -> None:
    """It is far behind as 0.15 s are lost, and catches up half a second later, on coarse encoders as well."""
    recording = under_setpoints(T, np.sin(3.0 * T), np.abs(T - 9.2) > 0.075)
    read = recording.series["gearbox_states"]
    coarse = replace(read, position=np.round(read.position / grain) * grain, velocity=None)
    span = servo_span(replace(recording, series={**recording.series, "gearbox_states": coarse}), TRUNK)
    assert 0.75 < span.valid.mean() < 0.9
    assert worst(ServoStage([span], TRUNK)) < 1e-5 + grain / 2


MANY_GAPS = np.abs(T % 4.0 - 3.0) > 0.075


def test_a_servo_that_never_catches_up_hides_nothing_of_the_others() -> None:
    slow = 0.3 * np.sin(0.7 * T)
    went = np.column_stack([slow, slow, 2.0 * np.sin(3.0 * T), slow, slow])
    recording = under_setpoints(T, went, MANY_GAPS)
    share = servo_span(recording, TRUNK).valid.mean(axis=0)
    assert share[2] < 0.3
    assert share[[0, 1, 3, 4]].min() > 0.85
    setpoints = recording.series["setpoints"]
    unknown = replace(setpoints, position=np.where(np.arange(5) == 2, np.nan, setpoints.position))
    recording = replace(recording, series={**recording.series, "setpoints": unknown})
    np.testing.assert_array_equal(
        servo_span(recording, TRUNK).valid.mean(axis=0), share * (np.arange(5) != 2)
    )


def test_a_steady_way_in_stairs_is_no_top_speed() -> None:
    """Its servo follows, whatever each step looks like."""
    steady = 0.4 * np.abs(T / 4.0 % 2.0 - 1.0)
    span = servo_span(under_setpoints(T, steady[np.arange(len(T)) // 10 * 10], MANY_GAPS), TRUNK)
    assert span.valid.mean() > 0.85


def test_setpoints_that_come_as_they_like_are_held_until_the_next() -> None:
    """In bursts, as a logger writes them: none is missing between, and a pause is one all the same."""
    steps = np.where(np.arange(len(T)) % 4 == 0, 0.03, np.where(np.arange(len(T)) % 4 == 1, 0.01, 0.002))
    stamp = np.cumsum(steps)
    recording = under_setpoints(stamp, np.sin(0.3 * stamp))
    span = servo_span(recording, TRUNK)
    assert span.valid.mean() > 0.95
    assert worst(ServoStage([span], TRUNK)) < 6e-5
    paused = under_setpoints(stamp, np.sin(0.3 * stamp), np.abs(stamp - 10.0) > 2.0)
    span = servo_span(paused, TRUNK)
    assert not span.valid[(span.stamp > 8.1) & (span.stamp < 12.0)].any()


def test_setpoints_that_may_have_gone_anywhere_in_many_gaps_are_the_reason_that_is_named() -> None:
    """They jump in each of them."""
    went = 0.2 * np.cumsum(np.random.default_rng(0).normal(size=len(T) // 50 + 1))
    jumps = went[(np.arange(len(T)) + 15) // 50]
    recording = under_setpoints(T, jumps, np.abs(np.arange(len(T)) % 50 - 35) > 2)
    said = r"setpoints are missing 200 times, and the 0\.3 s after each, .* leave too little: record all"
    servo = next(one for one in prospects(recording, TRUNK) if one.stage == "servo")
    assert re.match(said, servo.missing)
    with pytest.raises(RecordingError, match=said):
        diagnose([recording])


def with_tip(recording: Recording) -> Recording:
    joints = recording.series["joint_states"]
    tip = TRUNK.arm.tip(joints.position)
    return replace(recording, tip=PoseSeries(joints.stamp, tip[:, :3], tip[:, 3:]))


def test_the_tip_is_not_compared_with_joint_angles_that_were_not_recorded() -> None:
    recording = with_gap(with_tip(recorded(seconds=15.0)), "joint_states")
    data = tip_data(recording, TRUNK)
    assert data is not None
    assert np.abs(ArmProblem([data]).residual({})[0]).max() < 1e-9
    assert not np.any((data.stamp > 5.0) & (data.stamp < 10.0))


def test_a_late_joint_sensor_is_not_blamed_on_the_arm() -> None:
    true = with_tip(recorded(seconds=15.0, noise=1e-6))
    late = recorded({"sensor_delay": {"delay": 0.02}}, 15.0)
    result = diagnose([of_the_wires(replace(late, tip=true.tip))])
    assert [(f.effect, f.stage) for f in result.findings] == [("sensor_delay", "wire")]


def test_poses_without_an_orientation_do_not_count() -> None:
    recording = with_tip(recorded(seconds=15.0))
    assert recording.tip is not None
    orientation = recording.tip.orientation.copy()
    orientation[40:60] = np.nan
    data = tip_data(replace(recording, tip=replace(recording.tip, orientation=orientation)), TRUNK)
    assert data is not None
    assert len(data.stamp) == len(orientation) - 20


def lossy(recording: Recording, share: float, most: int, seed: int) -> Recording:
    """Each topic without a share of its samples, in bursts of up to so many."""
    rng = np.random.default_rng(seed)

    def keep(number: int) -> np.ndarray:
        out = np.ones(number, dtype=bool)
        while np.mean(~out) < share:
            first = rng.integers(number)
            out[first : first + rng.integers(1, most + 1)] = False
        return out

    return kept(recording, {key: keep(len(series.stamp)) for key, series in recording.series.items()})


@pytest.mark.parametrize("most", [1, 11, 30])
def test_what_is_lost_in_bursts_is_no_misfit_where_there_is_no_noise(most: int) -> None:
    """A motion with fast turns and holds: what is guessed in a gap is off by far more than such a floor."""
    recording = stopping(recorded(seconds=30.0, noise=0.0))
    whole = worst(WireStage([wire(recording)], TRUNK, {}))
    for seed in range(2):
        thin = without_faults(lossy(recording, 0.14, most, seed))
        assert thin.notes == ()
        span = wire(thin)
        assert worst(WireStage([span], TRUNK, {})) < 6 * whole
        assert span.valid.mean() > 0.55  # of 0.84, which are outside of gaps


def test_what_is_lost_in_bursts_hides_nothing_and_adds_nothing() -> None:
    clean = diagnose([of_two(lossy(recorded(seconds=20.0, noise=0.0), 0.14, 11, 1))])
    assert clean.verdict == "no_mismatch"
    ratio = {"relative": np.full(5, 0.02)}
    worn = recorded({"backlash": {"half_width": on(2, 2e-3)}, "ratio_error": ratio}, 20.0)
    found = diagnose([of_two(lossy(worn, 0.14, 11, 1))])
    assert {(f.effect, *f.joints) for f in found.findings} == {
        ("ratio_error", "joint_1", "joint_2"),
        ("backlash", "joint_2"),
    }
    assert found.model.effects["backlash"]["half_width"] == pytest.approx(on(2, 2e-3), abs=1e-4)


def of_two(recording: Recording) -> Recording:
    """The first two joints alone."""
    return of_joints(recording, "joint_1", "joint_2")


def stopping(recording: Recording) -> Recording:
    """The nominal arm on a motion that is fast, turns sharply, and stands still in between."""
    arm = TRUNK.arm
    stamp = recording.series["gearbox_states"].stamp
    knots = np.arange(0.0, stamp[-1] + 1.0, 0.4)
    rng = np.random.default_rng(3)
    corners = np.repeat(rng.uniform(-0.3, 0.3, (len(knots) // 2 + 1, 5)), 2, axis=0)[: len(knots)]
    phi = np.column_stack([PchipInterpolator(knots, column)(stamp) for column in corners.T])
    theta, _ = Chain(TRUNK, "wire").run(phi, stamp)
    step = 2 * np.pi / arm.counts_per_rev
    read = np.round(phi / step) * step
    series = {
        "gearbox_states": JointSeries(stamp, arm.joints, read, np.gradient(phi, stamp, axis=0)),
        "joint_states": JointSeries(stamp, arm.joints, theta),
    }
    return replace(recording, series=series)


@pytest.mark.parametrize(("half_width", "counts"), [(0.4, True), (4e-3, False)])
def test_samples_lost_at_a_turn_hide_no_more_of_a_loop_than_the_way_that_was_not_seen(
    half_width: float, counts: bool
) -> None:
    stamp = np.arange(0.0, 40.0, 0.0025)
    stamp = stamp[np.abs(stamp - 6.0 * np.pi) > 0.02]  # beside its second turn at the top
    motor = np.sin(0.5 * stamp - np.pi / 2.0)[:, None]
    joint, _ = SharpPlay().run(motor, np.array([[half_width]]), None)
    series = {
        "gearbox_states": JointSeries(stamp, ("a",), motor),
        "joint_states": JointSeries(stamp, ("a",), joint),
    }
    span = wire_span(Recording("swing", 0, 40.0, series), load_model("direct"))
    soon = (span.stamp > 19.0) & (span.stamp < 19.1)
    assert span.valid[soon].all() == counts


def test_an_arm_of_which_nothing_is_known_may_have_setpoints_in_its_recording() -> None:
    recording = recorded(seconds=5.0)
    assert "setpoints" in recording.series
    assert wire_span(recording, load_model("direct")).joints == recording.joints


@pytest.mark.parametrize("scatter", [0.0, 1e-3])
def test_a_motor_that_only_seems_to_turn_in_a_gap_makes_nothing_forgotten(scatter: float) -> None:
    """Its readings scatter as it stands. One that turned out of sight is said to, with what that costs."""
    stamp, noise = np.arange(0.0, 60.0, 0.01), np.random.default_rng(0).normal(size=(2, 6000))
    motor = 10.0 * np.sin(np.minimum(stamp, 6.55 * np.pi))
    joint = SharpPlay().run(motor[:, None], np.array([[0.1]]), None)[0] + 1e-4 * noise[0][:, None]
    seen = motor + scatter * noise[1]
    lost = np.zeros(len(stamp), dtype=bool)
    lost[2100::37] = lost[2101::37] = True
    turned = lost if scatter else lost | (np.abs(stamp - 6.5 * np.pi) < 0.05)
    series = {
        "gearbox_states": JointSeries(stamp[~turned], ("a",), seen[~turned, None]),
        "joint_states": JointSeries(stamp, ("a",), joint),
    }
    span = wire_span(Recording("stair", 0, 60.0, series), load_model("direct"))
    told = " ".join(counting_told(span))
    assert ("follow gaps in which its motor may have turned" in told) == (scatter == 0.0)
    assert (span.valid.mean() > 0.9) == (scatter > 0.0)
