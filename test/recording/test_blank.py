"""What says nothing of where any joint is, is no sample: rows of tables, messages of bags, rows of arrays."""

import numpy as np
import pytest

from test.recording.bags import JOINTS, START_NS, joint_state, motion, write_bag
from test.recording.test_import_csv import mapping, position, table
from trunk_ros.commands.import_table import main
from trunk_ros.recording.importing.bag import read_bag
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.importing.mapping import parse_mapping
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.words import many

TWO = {"joints": ["a", "b"], "gearbox_states": position("p", "q"), "joint_states": position("x", "y")}
NAN = [np.nan] * len(JOINTS)


def alternating(step: str) -> str:
    """Rows of motors every 10 ms, each with one of joints `step` later."""
    rows = [f"{k}0,{k},{k},,\n{k}{step},,,{-k},{-k}\n" for k in range(1, 400)]
    return "t,p,q,x,y\n" + "".join(rows)


@pytest.mark.parametrize("step", ["3", "0"])
def test_of_rows_that_alternate_each_topic_has_its_own(tmp_path, step):
    ms = mapping(**TWO, time={"column": "t", "unit": "ms"})
    recording = read_csv(table(tmp_path, alternating(step)), ms)
    gearbox, joints = recording.require("gearbox_states"), recording.require("joint_states")
    np.testing.assert_array_equal(gearbox.position[:, 0], np.arange(1, 400))
    np.testing.assert_array_equal(joints.position[:, 1], -np.arange(1, 400))
    np.testing.assert_allclose(joints.stamp - gearbox.stamp, int(step) / 1e3, atol=1e-9)
    assert (recording.start_ns, recording.duration) == (10_000_000, joints.stamp[-1])
    assert not [note for note in recording.notes if "without a value" in note], "the other topic's rows"


def rows_of(every: float, lost: tuple[int, ...] = ()) -> str:
    """Rows of motors every 10 ms, with joints read ``every`` so many of them, but for some."""
    joints = {round(k * every): k for k in range(200) if k not in lost}
    return "t,p,x\n" + "".join(f"{k}0,{k},{joints.get(k, '')}\n" for k in range(600))


@pytest.mark.parametrize(
    ("every", "lost"), [(3.0, ()), (1.43, ()), (2.5, ()), (3.0, (70,)), (1.0, (70, 90, 91))]
)
def test_rows_without_a_value_are_told_of_where_one_was_due(tmp_path, every, lost):
    ms = mapping(
        joints=["a"],
        gearbox_states=position("p"),
        joint_states=position("x"),
        time={"column": "t", "unit": "ms"},
    )
    text = "\n".join(rows_of(every, lost).split("\n")[: int(199 * every) + 2])
    recording = read_csv(table(tmp_path, text), ms)
    told = [note for note in recording.notes if "without a value" in note]
    between = {3.0: 5, 1.0: 3}.get(every)
    assert told == ([f"joint_states: {many(between, 'row')} without a value left out"] if lost else [])


def test_the_bag_of_such_a_table_has_a_message_only_where_there_is_a_reading(tmp_path, capsys):
    (tmp_path / "map.yaml").write_text(
        "time: {column: t, unit: s}\njoints: [a, b]\n"
        "gearbox_states: {position: {columns: [p, q], unit: rad}}\n"
        "joint_states: {position: {columns: [x, y], unit: rad}}\n"
    )
    rows = [f"{k},{k},{k},,\n{k}.5,,,{k},{'' if k == 3 else k}\n" for k in range(9)]
    csv = table(tmp_path, "t,p,q,x,y\n" + "".join(rows))
    assert main([str(csv), "--mapping", str(tmp_path / "map.yaml"), "--output", str(tmp_path / "bag")]) == 0
    assert "gearbox_states (9), /joint_states (9)" in capsys.readouterr().out
    joints = read_recording(tmp_path / "bag").require("joint_states")
    np.testing.assert_array_equal(joints.stamp, np.arange(9) + 0.5)
    assert np.argwhere(np.isnan(joints.position)).tolist() == [[3, 1]]


def test_a_table_begins_with_its_first_reading_and_an_effort_is_one(tmp_path):
    effort = {**position("x"), "effort": {"columns": ["e"], "unit": "N*m"}}
    recording = read_csv(table(tmp_path, "t,x,e\n1,,\n2,,5\n3,1,\n"), mapping(joint_states=effort))
    series = recording.require("joint_states")
    assert recording.start_ns == 2 * 10**9
    np.testing.assert_array_equal(series.position, [[np.nan], [1]])
    np.testing.assert_array_equal(series.effort, [[5], [np.nan]])


def test_the_pace_of_a_table_is_that_of_a_topic_and_not_of_rows_that_others_have_between(tmp_path):
    rows = "".join(f"{k / 100},{np.sin(k / 60)},\n{k / 100 + 1e-5},,{np.sin(k / 60)}\n" for k in range(500))
    one = mapping(gearbox_states=position("p"))
    notes = read_csv(table(tmp_path, "t,p,x\n" + rows), one).notes
    assert not [note for note in notes if "is the unit" in note]


@pytest.mark.parametrize("late", [0, 4_000_000])
def test_messages_without_any_position_are_left_out_of_a_bag_and_counted(tmp_path, late):
    whole, blanks = motion(), []
    for _, log_ns, _ in whole:  # before each at its stamp, where the first would count, or between
        stamp = log_ns - 3_000_000 + late
        blanks.append(("/joint_states", log_ns - 1 if not late else log_ns + late, stamp))
    mixed = [(topic, at, joint_state(stamp, JOINTS, NAN)) for topic, at, stamp in blanks]
    expected = read_recording(write_bag(tmp_path / "whole", whole))
    found = read_recording(write_bag(tmp_path / "mixed", sorted([*whole, *mixed], key=lambda each: each[1])))
    series, same = found.require("joint_states"), expected.require("joint_states")
    np.testing.assert_array_equal(series.position, same.position)
    np.testing.assert_array_equal(series.stamp, same.stamp)
    assert found.notes == ("joint_states: 50 messages without any position, left out",)
    assert (found.counts["joint_states"].messages, found.counts["joint_states"].blank) == (100, 50)
    assert found.duration == expected.duration


def test_a_message_with_one_position_of_several_is_kept(tmp_path):
    messages = motion(count=5)
    messages[2][2].position[:2] = np.nan
    assert len(read_recording(write_bag(tmp_path / "bag", messages)).require("joint_states").stamp) == 5


def test_a_wire_that_says_its_tension_alone_is_kept(tmp_path):
    wires = [
        ("/trunk/wire_states", START_NS, joint_state(START_NS + k, JOINTS, NAN, (), [1, 2, 3]))
        for k in range(4)
    ]
    wires[3][2].position[:] = 0.0
    read = read_recording(write_bag(tmp_path / "bag", [*motion(), *wires]))
    assert len(read.require("wire_states").stamp) == 4


def test_of_a_bag_with_other_topics_too(tmp_path):
    messages = motion("/encoder", count=6)
    for _, _, message in messages[1::2]:
        message.position[:] = np.nan
    one = {"columns": ["/encoder.position[0]"], "unit": "rad"}
    other = parse_mapping({"joints": ["a"], "joint_states": {"position": one}})
    read = read_bag(write_bag(tmp_path / "bag", messages), other)
    np.testing.assert_allclose(read.require("joint_states").stamp, [0, 0.02, 0.04])
    assert "joint_states: 3 messages without any position, left out" in read.notes


def test_of_arrays_each_series_has_the_stamps_at_which_it_was_read():
    motor = np.array([0.0, np.nan, 1.0, np.nan])
    read = Recording.from_arrays([0, 1, 2, 3], motor=motor, joint=motor[::-1])
    assert read.require("gearbox_states").stamp.tolist() == [0, 2]
    assert read.require("joint_states").stamp.tolist() == [1, 3]
