"""Bags with other topics become recordings of an arm, by a mapping."""

import numpy as np
import pytest
import yaml

from test.recording.bags import NOETIC, START_NS, STORE, joint_state, motion, only_file, write_bag, write_ros1
from trunk_ros.commands.import_table import main
from trunk_ros.errors import RecordingError
from trunk_ros.recording.importing.bag import read_bag
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.importing.mapping import load_mapping
from trunk_ros.recording.quality import quality
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recover import recover
from trunk_ros.recording.staggered import brought_together

COUNT = 30
PERIOD = 10_000_000
MAPPING = {
    "joints": ["shoulder", "elbow"],
    "gearbox_states": {
        "position": {"columns": ["/motor_1.position[0]", "/motor_2.position[0]"], "unit": "rad"},
        "effort": {"columns": ["/motor_1.effort[0]", "/motor_2.effort[0]"], "unit": "N*m"},
    },
    "joint_states": {
        "position": {"columns": ["/encoder_1.data", {"expr": "'/encoder_2.data' / 2"}], "unit": "deg"}
    },
}


def number(value):
    return STORE.types["std_msgs/msg/Float64"](value)


def topic_per_joint(late_ns=2_000_000):
    """Motors with stamps of their own, 1 ms apart, and encoders without."""
    messages = []
    for i in range(COUNT):
        at = START_NS + i * PERIOD
        for motor in (1, 2):
            stamp = at + (motor - 1) * 1_000_000
            state = joint_state(stamp, ["axis"], [motor + 0.01 * i], [], [0.1 * motor])
            messages.append((f"/motor_{motor}", stamp + late_ns, state))
            messages.append((f"/encoder_{motor}", at + late_ns, number(10.0 * motor + i)))
    return messages


def write_mapping(folder, **changes):
    file = folder / "map.yaml"
    file.write_text(yaml.safe_dump({**MAPPING, **changes}))
    return file


@pytest.fixture
def bag(tmp_path):
    return write_bag(tmp_path / "foreign", topic_per_joint())


def test_a_topic_per_joint_keeps_the_stamps_of_each(bag, tmp_path):
    motors = read_bag(bag, write_mapping(tmp_path)).require("gearbox_states")
    assert motors.joints == ("shoulder", "elbow")
    assert len(motors.stamp) == 2 * COUNT
    first, second = (np.isfinite(column) for column in motors.position.T)
    assert (first ^ second).all()
    np.testing.assert_allclose(motors.position[first, 0], 1 + 0.01 * np.arange(COUNT))
    np.testing.assert_allclose(motors.stamp[second], 0.01 * np.arange(COUNT) + 0.001)
    np.testing.assert_allclose(motors.effort[second, 1], 0.2)


def test_a_clock_that_begins_anew_is_refused_with_the_message_and_what_to_do(tmp_path):
    """As when a simulation is reset while its topics are recorded."""
    messages = [
        (
            "/joint_states",
            START_NS + i * PERIOD,
            joint_state(10**9 + (i % 150) * PERIOD, ["axis"], [0.01 * i]),
        )
        for i in range(300)
    ]
    bag = write_bag(tmp_path / "reset", messages)
    said = r"time begins anew at message 151, recorded 1.5 s after the first \(1.49 s back\)"
    with pytest.raises(RecordingError, match=said):
        read_recording(bag)
    column = {"position": {"columns": ["/joint_states.position[axis]"], "unit": "rad"}}
    file = tmp_path / "one.yaml"
    file.write_text(yaml.safe_dump({"joints": ["axis"], "joint_states": column}))
    with pytest.raises(RecordingError, match=said):
        read_bag(bag, file)


def test_messages_without_a_header_take_the_time_of_recording_and_that_is_said(bag, tmp_path):
    recording = read_bag(bag, write_mapping(tmp_path))
    joints = recording.require("joint_states")
    np.testing.assert_allclose(joints.stamp, 0.01 * np.arange(COUNT) + 0.002)
    np.testing.assert_allclose(np.rad2deg(joints.position[:, 1]), (20 + np.arange(COUNT)) / 2)
    said = "no message has a stamp: the time of recording is taken instead"
    assert recording.notes == (f"/encoder_1: {said}", f"/encoder_2: {said}")


def test_losses_are_those_of_each_joint(tmp_path):
    messages = [each for each in topic_per_joint() if not (each[0] == "/motor_2" and each[1] % 10**9 < 10**8)]
    recording = read_bag(write_bag(tmp_path / "bag", messages), write_mapping(tmp_path))
    assert quality(recording)["gearbox_states"].lost == 0
    kept = [each for each in messages if not (each[0] == "/motor_1" and 10**8 < each[1] % 10**9 < 2 * 10**8)]
    recording = read_bag(write_bag(tmp_path / "gap", kept), write_mapping(tmp_path))
    seen = quality(recording)["gearbox_states"]
    assert (seen.lost, seen.gaps) == (10, 1)
    assert any("about 10 messages missing" in note for note in recording.notes)


def test_the_command_writes_a_bag_that_reads_the_same(bag, tmp_path, capsys):
    mapping = write_mapping(tmp_path)
    assert main([str(bag), "--mapping", str(mapping), "--output", str(tmp_path / "own")]) == 0
    assert "/trunk/gearbox_states (60)" in capsys.readouterr().out
    given, back = read_bag(bag, mapping), read_recording(tmp_path / "own")
    for key in ("gearbox_states", "joint_states"):
        one, other = brought_together(given.require(key), held=False)[0], back.require(key)
        np.testing.assert_allclose(other.stamp, one.stamp)
        np.testing.assert_allclose(other.position, one.position)
    assert back.counts["gearbox_states"].not_finite == 0  # a message names the joints that it is of


def test_joints_of_one_topic_are_taken_by_name_or_by_number(tmp_path):
    bag = write_bag(tmp_path / "bag", motion("/states", COUNT, names=("x", "q.2", "z")))
    columns = ["/states.position[q.2]", "/states.position[2]"]
    mapping = write_mapping(tmp_path, gearbox_states={"position": {"columns": columns, "unit": "rad"}})
    content = yaml.safe_load(mapping.read_text())
    del content["joint_states"]
    mapping.write_text(yaml.safe_dump(content))
    series = read_bag(bag, mapping).require("gearbox_states")
    np.testing.assert_allclose(series.position[0], [0.1, 0.2])
    assert len(series.stamp) == COUNT


def test_a_bag_of_ros_1_is_mapped_too(tmp_path):
    bag = write_ros1(tmp_path / "old.bag", motion("/states", COUNT, store=NOETIC))
    columns = ["/states.position[a]", "/states.position[c]"]
    (tmp_path / "map.yaml").write_text(
        yaml.safe_dump(
            {"joints": ["p", "q"], "joint_states": {"position": {"columns": columns, "unit": "rad"}}}
        )
    )
    assert read_bag(bag, tmp_path / "map.yaml").require("joint_states").position.shape == (COUNT, 2)


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        (["/motor_3.position[0]", "/motor_2.position[0]"], "no topic /motor_3; there are /encoder_1, "),
        (["/motor_1.angle", "/motor_2.position[0]"], "/motor_1 has no field angle: there are header, name"),
        (
            ["/motor_1.position[m9]", "/motor_2.position[0]"],
            "position[m9] is in no message: they name axis",
        ),
        (["/motor_1.position", "/motor_2.position[0]"], "is no number: give a field of it, or an index"),
        (["/encoder_1.data[0]", "/encoder_2.data"], "there is no list to take [0] of"),
        (["/encoder_1", "/encoder_2.data"], "a column of a bag is /topic.field"),
        ([{"expr": "'/encoder_1.data' + '/encoder_2.data'"}, "/encoder_2.data"], "mixes /encoder_1 and"),
        (
            ["/motor_1.position[wrist]", "/motor_2.position[0]"],
            "/motor_1.position[wrist] is in no message: they name axis",
        ),
    ],
)
def test_what_cannot_be_mapped_is_named_in_one_line(bag, tmp_path, columns, said):
    mapping = write_mapping(tmp_path, joint_states={"position": {"columns": columns, "unit": "rad"}})
    with pytest.raises(RecordingError) as caught:
        read_bag(bag, mapping)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_of_a_cut_bag_it_is_said_how_to_repair_it(bag, tmp_path):
    file = only_file(bag)
    file.write_bytes(file.read_bytes()[:-200])
    with pytest.raises(RecordingError, match="`recover` may repair it"):
        read_bag(bag, write_mapping(tmp_path))
    recover(bag)
    assert read_bag(bag, write_mapping(tmp_path)).joints == ("shoulder", "elbow")


def test_mappings_of_bags_and_of_tables_are_told_apart(bag, tmp_path):
    with pytest.raises(RecordingError, match="has its own times"):
        read_bag(bag, write_mapping(tmp_path, rate_hz=100))
    assert load_mapping(write_mapping(tmp_path)).of_bag
    (tmp_path / "table.csv").write_text("t,x\n0,1\n")
    with pytest.raises(RecordingError, match="is a table: give `time"):
        read_csv(tmp_path / "table.csv", write_mapping(tmp_path))
