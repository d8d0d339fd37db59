"""Data that are mixed up are reported as such, each in its own words; physics is not taken for a mix-up."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, of_the_wires, on, recorded, reshaped
from trunk_ros.commands.info import gathered
from trunk_ros.data.mix_ups import doubtful, mix_ups, without_mix_ups
from trunk_ros.data.mix_ups.clock import clock_offset
from trunk_ros.data.names import _is_alike, refuse_misnamed
from trunk_ros.data.quality import quality_of_recording
from trunk_ros.diagnosis.report import write
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.errors import RecordingError
from trunk_ros.model import Model, load_model
from trunk_ros.recording.quality import of_one_stamp
from trunk_ros.recording.recording import Counts, Recording
from trunk_ros.recording.time_range import part_of

PER_RADIAN = 180 / np.pi
TRUNK, DIRECT = load_model("trunk"), load_model("direct")


@pytest.fixture(scope="module")
def good() -> Recording:
    return recorded({"backlash": {"half_width": on(2, 8e-4)}}, 30.0)


def scaled(recording: Recording, key: str, factor: float | np.ndarray) -> Recording:
    return reshaped(recording, key, position=recording.series[key].position * factor, velocity=None)


def only(recording: Recording, model: Model = TRUNK, stage: str = "wire") -> tuple[str, tuple[str, ...], str]:
    found = [one for one in mix_ups(recording, model) if one.stage == stage]
    assert len(found) == 1
    return found[0].kind, found[0].joints, found[0].statement


@pytest.mark.parametrize("keys", [("joint_states", "gearbox_states"), ("joint_states",)])
def test_what_direct_cannot_see_is_asked(good: Recording, keys: tuple[str, ...]) -> None:
    """Both sides in degrees, or joints of unlike ratios alone: no factor tells it from a ratio."""
    mixed = replace(good, series={key: good.series[key] for key in ("gearbox_states", "joint_states")})
    for key in keys:
        mixed = scaled(mixed, key, PER_RADIAN * np.array([0.8, 1.0, 1.2, 1.4, 1.6]))
    assert mix_ups(mixed, DIRECT) == []
    (said,) = doubtful(mixed, DIRECT)
    assert {key for key in ("joint_states", "gearbox_states") if f"{key} of joint_1" in said} == set(keys)
    assert "are these rad? If they are degrees or counts, convert them" in said
    assert said in gathered(mixed, DIRECT)["note"]
    assert said in quality_of_recording(mixed, DIRECT)["notes"]
    assert doubtful(good, DIRECT) == []
    wide = replace(TRUNK.arm, lower=np.full(5, -200.0), upper=np.full(5, 200.0))
    assert doubtful(scaled(good, "joint_states", 30.0), Model(wide)) == []


def test_a_recording_of_two_seconds_is_said_to_show_little(good: Recording) -> None:
    said = "2 s show little: effects look alike, and what depends on speed, posture or time is hardly seen"
    assert any(
        note.startswith(said) for note in quality_of_recording(part_of(good, "3", "5"), DIRECT)["notes"]
    )
    assert not any("show little" in note for note in quality_of_recording(good, DIRECT)["notes"])


def test_topics_of_one_stamp_are_told_as_that(good: Recording) -> None:
    once = {key: replace(each, stamp=each.stamp[:1], position=each.position[:1], velocity=None)
            for key, each in good.series.items()}  # fmt: skip
    alike = replace(good, series=once, counts=dict.fromkeys(once, Counts(messages=3000, duplicates=2999)))
    assert of_one_stamp(alike).startswith(
        "all messages of trunk/setpoints, trunk/gearbox_states, joint_states"
    )
    assert of_one_stamp(good) == ""


def test_a_stray_reading_is_no_speed(good: Recording) -> None:
    position = good.series["joint_states"].position.copy()
    position[500] += 40.0
    assert doubtful(reshaped(good, "joint_states", position=position, velocity=None), DIRECT) == []


@pytest.mark.parametrize("model", [TRUNK, DIRECT])
def test_a_good_recording_has_none(good: Recording, model: Model) -> None:
    assert mix_ups(good, model) == []


def test_joint_readings_in_degrees_are_named(good: Recording) -> None:
    kind, joints, said = only(scaled(good, "joint_states", PER_RADIAN))
    assert (kind, joints) == ("unit", good.joints)
    assert said.startswith("joint_states looks like degrees: ")


def test_gearbox_readings_in_degrees_are_named_for_wire_and_servo(good: Recording) -> None:
    mixed = scaled(good, "gearbox_states", PER_RADIAN)
    assert only(mixed)[2].startswith("trunk/gearbox_states looks like degrees: ")
    assert only(mixed, stage="servo")[2].startswith("trunk/gearbox_states looks like degrees: ")


def test_setpoints_at_the_joint_side_are_told_by_the_ratio(good: Recording) -> None:
    kind, joints, said = only(scaled(good, "setpoints", TRUNK.arm.ratio), stage="servo")
    assert (kind, joints) == ("unit", good.joints)
    assert said.startswith("setpoints at the joint side?")
    assert "Divide it by wire.ratio" in said


def test_both_in_degrees_are_told_by_the_limits(good: Recording) -> None:
    mixed = scaled(scaled(good, "joint_states", PER_RADIAN), "gearbox_states", PER_RADIAN)
    kind, _, said = only(mixed)
    assert kind == "unit"
    assert said.startswith("trunk/gearbox_states and joint_states of")


def test_without_a_known_ratio_degrees_are_told_where_all_joints_show_them(good: Recording) -> None:
    straight = scaled(good, "gearbox_states", float(TRUNK.arm.ratio[0]))
    assert only(scaled(straight, "joint_states", PER_RADIAN), DIRECT)[0] == "unit"
    position = straight.series["joint_states"].position * np.array([PER_RADIAN, 1, 1, 1, 1])
    assert mix_ups(reshaped(straight, "joint_states", position=position), DIRECT) == []  # a gear


def test_counts_are_told_by_whole_numbers(good: Recording) -> None:
    counts = np.rint(good.series["joint_states"].position * 8192 / (2 * np.pi))
    kind, _, said = only(reshaped(good, "joint_states", position=counts))
    assert kind == "counts"
    assert "whole numbers from" in said


def test_swapped_joints_are_named_and_the_others_are_not(good: Recording) -> None:
    swapped = good.series["joint_states"].position[:, [0, 3, 2, 1, 4]]
    kind, joints, said = only(reshaped(good, "joint_states", position=swapped))
    assert (kind, joints) == ("order", ("joint_2", "joint_4"))
    assert "joint_2 follows that of joint_4" in said


def test_a_turned_sign_is_named_and_only_remarked_where_no_ratio_is_known(good: Recording) -> None:
    turned = good.series["joint_states"].position * np.array([1, 1, -1, 1, 1])
    mixed = reshaped(good, "joint_states", position=turned)
    assert only(mixed)[:2] == ("sign", ("joint_3",))
    assert [one.certain for one in mix_ups(mixed, DIRECT)] == [False]


def test_motors_for_joints_are_told_by_the_ratio() -> None:
    """Each ratio that was found was one over the model's; 0.9 on a joint may be an error of it."""
    made = recorded({"backlash": {"half_width": np.full(5, 3e-3)}}, 20.0)
    motor, joint = (made.series[key] for key in ("gearbox_states", "joint_states"))
    other = replace(made, series={"gearbox_states": joint, "joint_states": replace(motor, velocity=None)})
    kind, joints, said = only(other)
    assert (kind, joints) == ("order", made.joints)
    assert said.startswith("motor and joint side exchanged? joint_states of joint_1, joint_2, ")
    assert only(other, DIRECT)[0] == "guided"  # without a ratio a hand may have guided the joints
    turned = scaled(other, "joint_states", np.array([1.0, 1.0, -1.0, 1.0, 1.0]))
    assert only(turned)[1] == made.joints
    upright = scaled(other, "joint_states", np.array([1.0, 1.0, 1.0, 1.0, TRUNK.arm.ratio[4] ** 2]))
    assert only(upright)[0] == "guided"
    once = {key: series.position.copy() for key, series in made.series.items()}
    for key in once:
        once[key][:-20] = once[key][-20]
    brief = {key: replace(made.series[key], position=position) for key, position in once.items()}
    assert mix_ups(replace(made, series=brief), TRUNK) == []
    near = Model(replace(TRUNK.arm, ratio=np.full(5, 0.9)))
    assert mix_ups(scaled(made, "joint_states", 1.0 / 0.9 / TRUNK.arm.ratio), near) == []


def test_a_dead_sensor_blinds_nothing_for_the_others(good: Recording) -> None:
    position = good.series["joint_states"].position * np.array([1.0, 1.0, -1.0, 1.0, 1.0])
    position[:, 0] = np.nan
    mixed = reshaped(good, "joint_states", position=position)
    assert only(mixed)[:2] == ("sign", ("joint_3",))
    late = reshaped(mixed, "joint_states", stamp=good.series["joint_states"].stamp + 3.0)
    assert only(late)[:2] == ("clock", TRUNK.arm.joints[1:])


@pytest.mark.parametrize("off", [3.0, -4.5, 3600.0])
def test_clocks_that_are_apart_are_told_with_their_distance(good: Recording, off: float) -> None:
    stamp = good.series["joint_states"].stamp + off
    kind, joints, said = only(reshaped(good, "joint_states", stamp=stamp))
    assert (kind, joints) == ("clock", good.joints)
    told = float(said.split(" s apart")[0].split()[-1])
    assert told == pytest.approx(abs(off), abs=0.1)
    assert ("late" if off > 0 else "early") in said


@pytest.mark.parametrize(
    "effects",
    [
        {"sensor_delay": {"delay": 0.45}},
        {"ratio_error": {"relative": np.full(5, 0.3)}},
        {"backlash": {"half_width": np.full(5, 0.05)}},
        {"joint_coupling": {"gain": on(3, 0.4), "source": ["", "", "joint_2", "", ""]}},
        {"viscous_lag": {"time_constant": np.full(5, 0.3)}},
    ],
    ids=lambda effects: next(iter(effects)),
)
def test_strong_physics_is_no_mix_up(effects: dict[str, dict[str, object]]) -> None:
    assert mix_ups(recorded(effects, 30.0), TRUNK) == []


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_one_swing_of_a_wide_dead_band_is_no_other_clock_at_whichever_side_it_began(side: float) -> None:
    stamp, half_width = np.arange(0.0, 20.0, 0.01), np.array([[0.5]])
    motor = np.sin(0.35 * stamp[:, None] - 1.4 * side)
    joint, _ = SharpPlay().run(motor, half_width, motor[0] + side * half_width[0])
    assert clock_offset(stamp, motor, stamp, joint) == 0.0
    assert clock_offset(stamp, motor, stamp + 3.0, motor) == pytest.approx(3.0, abs=0.1)


def test_a_joint_that_goes_one_way_only_tells_no_other_clock() -> None:
    """A wire that is slack at first does the same."""
    stamp = np.arange(400.0)
    motor = -np.expm1(-stamp[:, None] / 400.0)
    slack = -np.expm1(-np.clip(stamp[:, None] - 150.0, 0.0, None) / 400.0)
    assert clock_offset(stamp, motor, stamp, slack) == 0.0
    stands = np.random.default_rng(1).normal(0.0, 1e-4, motor.shape)
    assert clock_offset(stamp, np.hstack([motor, stands]), stamp, np.hstack([slack, stands])) == 0.0
    there_and_back, later = np.vstack([motor, motor[::-1]]), np.arange(800.0)
    late = np.vstack([np.zeros((150, 1)), there_and_back[:-150]])
    assert clock_offset(later, there_and_back, later, late) == pytest.approx(150.0, abs=1.0)


def test_all_joints_moving_alike_are_not_swapped(good: Recording) -> None:
    alike = replace(
        good, series={k: replace(s, position=s.position[:, [0] * 5]) for k, s in good.series.items()}
    )
    assert mix_ups(alike, TRUNK) == []


def test_what_is_mixed_up_is_left_out_and_the_rest_stays(good: Recording) -> None:
    swapped = good.series["joint_states"].position[:, [0, 3, 2, 1, 4]]
    mixed = reshaped(good, "joint_states", position=swapped)
    left = without_mix_ups(mixed, mix_ups(mixed, TRUNK)).series["joint_states"].position
    assert np.isnan(left[:, [1, 3]]).all()
    np.testing.assert_array_equal(left[:, [0, 2, 4]], swapped[:, [0, 2, 4]])


def test_mixed_up_joints_are_not_diagnosed_and_the_verdict_says_why(good: Recording) -> None:
    swapped = good.series["joint_states"].position[:, [0, 3, 2, 1, 4]]
    told = diagnose([reshaped(of_the_wires(good), "joint_states", position=swapped)])
    assert told.verdict != "explained"
    assert not any({"joint_2", "joint_4"} & set(finding.joints) for finding in told.findings)
    assert "look swapped" in told.unexplained[0].statement
    assert [one["kind"] for one in told.quality["made"]["mix_ups"]] == ["order"]
    assert told.stages["wire"]["silent"] == []


@pytest.mark.long
def test_what_a_mixed_up_joint_does_to_others_is_not_named() -> None:
    """The gain of the other joint had come out with the wrong sign, and was in model.yaml."""
    turned = np.array([1.0, -1.0, 1.0])
    gains = {"gain": [0.0, 0.0, 0.02], "source": ["", "", "joint_2"]}
    made = of_the_wires(recorded({"joint_coupling": gains}, 12.0, nominal=SHORT))
    told = diagnose([scaled(made, "joint_states", turned)], SHORT)
    assert "turn" in told.unexplained[0].statement
    assert [finding.named for finding in told.findings] == [False]
    assert told.model.reach[1] > 0.0


def test_degrees_end_in_no_finding_and_in_a_report_that_says_so(good: Recording, tmp_path: Path) -> None:
    told = diagnose([scaled(of_the_wires(good), "joint_states", PER_RADIAN)])
    assert told.verdict == "unexplained"
    assert [f for f in told.findings if f.stage == "wire"] == []
    write(told, tmp_path / "report.html")
    assert "looks like degrees" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize(
    ("times", "said"), [(1.0, "look like degrees"), (1e3, "are neither rad nor degrees")]
)
def test_what_goes_further_than_degrees_is_not_said_to_be_degrees(
    good: Recording, times: float, said: str
) -> None:
    """As thousandths of a degree under ``unit: deg`` do."""
    both = scaled(scaled(good, "joint_states", times * PER_RADIAN), "gearbox_states", times * PER_RADIAN)
    assert said in mix_ups(both, TRUNK)[0].statement


def test_a_joint_under_two_names_is_refused_by_both(good: Recording) -> None:
    """It had been left out, and what it does to the others was physics that the library lacks."""
    model = Model(replace(TRUNK.arm, joints=("base", "sholder", "left_hand", "wrist_1", "tool")))
    named = ("base", "shoulder", "left_hand", "wrist_1", "tool")
    mistyped = replace(good, series={k: replace(s, joints=named) for k, s in good.series.items()})
    with pytest.raises(RecordingError, match="the model's joint 'sholder' is not in trunk/gearbox_states, "
                       "which has 'shoulder': rename one of them"):  # fmt: skip
        diagnose([mistyped], model)
    mixed = reshaped(good, "joint_states", joints=("Joint-1", *TRUNK.arm.joints[1:]))
    with pytest.raises(RecordingError, match="gearbox_states' joint 'joint_1' is not in joint_states"):
        refuse_misnamed(mixed, DIRECT)


def test_a_joint_that_no_topic_has_is_told_before_the_search(good: Recording) -> None:
    """It had been told at the end, when the search had taken minutes."""
    model = Model(replace(TRUNK.arm, joints=("luff", *TRUNK.arm.joints[1:])))
    told: list[str] = []

    def begins(_: str) -> None:
        raise StopIteration

    with pytest.raises(StopIteration):
        diagnose([good, good], model, progress=begins, doubts=told.append)
    (line,) = told
    assert line.startswith("joint_1 left out: the model has no such joint, and no topic has its luff")


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        ("shoulder", "sholder", True), ("joint_01", "Joint1", True), ("leftElbow", "left_elbow", True),
        ("LShoulderPitch", "RShoulderPitch", False), ("LHand", "RHand", False), ("waist", "wrist", False),
        ("jointA", "jointB", False), ("lwrist", "rwrist", False), ("bendx", "bendy", False),
        ("shoulder_left", "shoulder_lift", False), ("joint_1_1", "joint_11", False),
        ("luff", "lufff", True), ("luf", "luff", True), ("slew_1", "sleew_1", True), ("elbow", "elbw", True),
        ("shuolder", "shoulder", True), ("wrist", "wirst", True), ("q4", "q5", False), ("A1", "A2", False),
        ("joint_1", "joint_2", False), ("roll", "rail", False), ("HR", "HPR", False), ("LHP", "LHY", False),
    ],
)  # fmt: skip
def test_what_is_a_slip_of_the_pen_and_what_another_joint(one: str, other: str, alike: bool) -> None:
    assert _is_alike(one, other) == _is_alike(other, one) == alike


@pytest.mark.parametrize("other", ["right_hand", "wrist_2", "gripper", "hand"])
def test_another_joint_is_no_other_name(good: Recording, other: str) -> None:
    model = Model(replace(TRUNK.arm, joints=("base", "shoulder", "left_hand", "wrist_1", "tool")))
    for absent in (2, 3):
        named = tuple(other if j == absent else joint for j, joint in enumerate(model.arm.joints))
        refuse_misnamed(
            replace(good, series={k: replace(s, joints=named) for k, s in good.series.items()}), model
        )
