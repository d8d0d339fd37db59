"""What is read from recordings of every kind, and how their oddities are dealt with."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from test.recording.bags import (
    JOINTS,
    NOETIC,
    START_NS,
    STORE,
    header,
    joint_state,
    motion,
    only_file,
    pose,
    write_bag,
    write_ros1,
)
from trunk_ros.errors import ArgumentError, RecordingError
from trunk_ros.recording.read import read_recording

EXPECTED = np.add.outer(0.01 * np.arange(50), 0.1 * np.arange(3))
CONCEALED = Path(__file__).resolve().parents[2].parent / "shared/concealed"


@pytest.mark.parametrize("version", [8, 9])
@pytest.mark.parametrize("compression", CompressionMode)
@pytest.mark.parametrize("storage", StoragePlugin)
def test_every_storage_and_compression_of_rosbag2_gives_the_same(tmp_path, storage, compression, version):
    if storage is StoragePlugin.SQLITE3 and compression is CompressionMode.STORAGE:
        pytest.skip("sqlite3 does not compress")
    bag = write_bag(tmp_path / "bag", motion(full=True), storage, version, compression)
    series = read_recording(bag).require("joint_states")
    for values in (series.position, series.velocity, series.effort):
        np.testing.assert_array_equal(values, EXPECTED)
    np.testing.assert_allclose(series.stamp, 0.01 * np.arange(50), atol=1e-12)


@pytest.mark.parametrize("compression", [None, *Writer1.CompressionFormat])
def test_a_ros_1_bag_is_read_whatever_its_compression(tmp_path, compression):
    bag = write_ros1(tmp_path / "a.bag", motion(store=NOETIC, full=True), compression)
    recording = read_recording(bag)
    np.testing.assert_array_equal(recording.require("joint_states").effort, EXPECTED)
    assert recording.notes == ()


def test_a_bare_file_is_known_by_its_content(tmp_path):
    for storage, suffix in ((StoragePlugin.MCAP, ".mcap"), (StoragePlugin.SQLITE3, ".db3")):
        bag = write_bag(tmp_path / suffix[1:], motion(), storage)
        bare = shutil.copy(only_file(bag, suffix), tmp_path / f"{suffix[1:]}.dat")
        np.testing.assert_array_equal(read_recording(bare).require("joint_states").position, EXPECTED)


def test_split_bags_are_one_recording_and_file_10_comes_after_file_9(tmp_path):
    messages, bag = motion(count=66), tmp_path / "bag"
    bag.mkdir()
    for part in range(11):
        one = write_bag(tmp_path / f"part_{part}", messages[6 * part : 6 * part + 6])
        shutil.copy(only_file(one), bag / f"bag_{part}.mcap")
    recording = read_recording(bag)
    assert len(recording.require("joint_states").stamp) == 66
    assert not any("order" in note for note in recording.notes)


def test_a_topic_per_joint_and_permuted_names_are_matched_by_name(tmp_path):
    messages = []
    for i in range(20):
        stamp = START_NS + i * 10**7
        messages.append(("/joint_states", stamp, joint_state(stamp, ["b", "a"], [2.0, 1.0])))
        messages.append(("/joint_states", stamp, joint_state(stamp, ["c"], [3.0])))
        stamp += 5 * 10**6
        messages.append(("/joint_states", stamp, joint_state(stamp, ["a", "c", "b"], [1.0, 3.0, 2.0])))
    recording = read_recording(write_bag(tmp_path / "bag", messages))
    series = recording.require("joint_states").select(("a", "b", "c"))
    np.testing.assert_array_equal(series.position, np.tile([1.0, 2.0, 3.0], (40, 1)))
    assert recording.counts["joint_states"].duplicates == 0


def a_message_per_joint(topic, late_ns=3 * 10**6, count=100):
    """Two joints at 100 Hz, the second one later; both at sin(2t)."""
    for i in range(count):
        for joint, stamp in (("a", START_NS + i * 10**7), ("b", START_NS + i * 10**7 + late_ns)):
            angle = np.sin(2e-9 * (stamp - START_NS))
            yield topic, stamp, joint_state(stamp, [joint], [angle])


def test_joints_that_were_sampled_at_other_times_are_interpolated_and_that_is_said(tmp_path):
    recording = read_recording(write_bag(tmp_path / "bag", a_message_per_joint("/joint_states")))
    series = recording.require("joint_states")
    np.testing.assert_allclose(series.stamp, 0.01 * np.arange(100), atol=1e-9)
    np.testing.assert_allclose(series.position[:, 0], np.sin(2 * series.stamp), atol=1e-12)
    np.testing.assert_allclose(series.position[1:, 1], np.sin(2 * series.stamp[1:]), atol=1e-8)
    assert np.isnan(series.position[0, 1])  # before its first sample nothing is known
    said = "joint_states: joints were sampled at different times: b interpolated to the stamps of a"
    assert said in recording.notes
    assert recording.counts["joint_states"].not_finite == 0


def test_setpoints_of_other_times_are_held(tmp_path):
    recording = read_recording(write_bag(tmp_path / "bag", a_message_per_joint("/trunk/setpoints")))
    series = recording.require("setpoints")
    np.testing.assert_allclose(series.position[1:, 1], np.sin(2 * (series.stamp[1:] - 0.007)), atol=1e-12)


def test_nothing_is_interpolated_into_a_gap(tmp_path):
    messages = [
        each for i, each in enumerate(a_message_per_joint("/joint_states")) if not (i % 2 and 60 < i < 100)
    ]
    position = read_recording(write_bag(tmp_path / "bag", messages)).require("joint_states").position
    assert np.flatnonzero(np.isnan(position[:, 1])).tolist() == [0, *range(30, 51)]


def test_all_topics_have_the_joints_in_one_order(tmp_path):
    messages = motion("/trunk/gearbox_states", names=("c", "a", "joint_two")) + motion()
    recording = read_recording(write_bag(tmp_path / "bag", messages))
    assert recording.require("gearbox_states").joints == recording.joints == JOINTS
    np.testing.assert_array_equal(recording.series["gearbox_states"].position[0], [0.1, 0.2, 0.0])


def test_the_first_of_repeated_stamps_counts_and_the_others_are_counted(tmp_path):
    messages = motion()
    for place in (3, 7):
        stamp = START_NS + place * 10**7
        messages.append(("/joint_states", stamp + 10**9, joint_state(stamp, JOINTS, [9.0, 9.0, 9.0])))
    recording = read_recording(write_bag(tmp_path / "bag", messages))
    np.testing.assert_array_equal(recording.require("joint_states").position, EXPECTED)
    assert recording.counts["joint_states"].duplicates == 2
    assert "joint_states: 2 messages repeated a stamp: the first of each counts" in recording.notes


def test_messages_out_of_order_are_sorted_and_counted(tmp_path):
    messages = [(topic, START_NS + i, each) for i, (topic, _, each) in enumerate(motion()[::-1])]
    recording = read_recording(write_bag(tmp_path / "bag", messages))
    np.testing.assert_array_equal(recording.require("joint_states").position, EXPECTED)
    assert recording.counts["joint_states"].out_of_order == 49


def test_empty_velocity_and_effort_are_none_and_later_ones_are_kept(tmp_path):
    recording = read_recording(write_bag(tmp_path / "bag", motion()))
    assert recording.require("joint_states").velocity is None
    later = START_NS + 10**9
    mixed = [*motion(count=2), ("/joint_states", later, joint_state(later, JOINTS, [1, 2, 3], [4, 5, 6]))]
    velocity = read_recording(write_bag(tmp_path / "mixed", mixed)).require("joint_states").velocity
    np.testing.assert_array_equal(velocity, [[np.nan] * 3, [np.nan] * 3, [4, 5, 6]])


def test_isolated_nan_are_masked_and_counted(tmp_path):
    messages = motion()
    messages[4][2].position[1] = np.nan
    messages[5][2].position[0] = np.inf
    recording = read_recording(write_bag(tmp_path / "bag", messages))
    position = recording.require("joint_states").position
    assert np.argwhere(np.isnan(position)).tolist() == [[4, 1], [5, 0]]
    assert "joint_states: 2 values not finite, masked" in recording.notes


def test_a_joint_without_a_finite_value_is_an_error_that_names_it(tmp_path):
    messages = motion()
    for _, _, message in messages:
        message.position[1] = np.nan
    with pytest.raises(RecordingError, match="no finite position of joint_two"):
        read_recording(write_bag(tmp_path / "bag", messages))


def test_effort_that_is_never_finite_is_no_effort(tmp_path):
    messages = motion(full=True)
    for _, _, message in messages:
        message.effort[:] = np.nan
    assert read_recording(write_bag(tmp_path / "bag", messages)).require("joint_states").effort is None


def test_the_stamp_is_the_time_of_a_sample_unless_no_message_has_one(tmp_path):
    messages = motion()
    for _, _, message in messages:
        message.header.stamp.sec = message.header.stamp.nanosec = 0
    recording = read_recording(write_bag(tmp_path / "bag", messages))
    assert recording.start_ns == START_NS + 3_000_000
    assert any("time of recording" in note for note in recording.notes)
    assert read_recording(write_bag(tmp_path / "stamped", motion())).start_ns == START_NS


def test_a_single_stamp_that_was_never_set_does_not_stretch_the_recording(tmp_path):
    messages = motion()
    messages[0][2].header.stamp.sec = messages[0][2].header.stamp.nanosec = 0
    assert read_recording(write_bag(tmp_path / "bag", messages)).duration < 1


def test_the_tip_is_read_with_its_frame(tmp_path):
    numbers = [0.1, 0.2, 0.3, 0.0, 0.0, 0.6, 0.8]
    poses = [("/trunk/tip_pose", START_NS, pose(START_NS + 10**9 * i, numbers, "world")) for i in range(3)]
    tip = read_recording(write_bag(tmp_path / "bag", motion() + poses)).tip
    np.testing.assert_array_equal(np.hstack([tip.position, tip.orientation]), [numbers] * 3)
    assert (tip.frame, tip.stamp.tolist()) == ("world", [0.0, 1.0, 2.0])


def test_topics_are_found_below_a_namespace(tmp_path):
    messages = motion("/lab/arm1/joint_states") + motion("/lab/arm1/trunk/setpoints")
    assert set(read_recording(write_bag(tmp_path / "bag", messages)).series) == {"joint_states", "setpoints"}


def test_two_arms_are_refused_unless_one_is_asked_for(tmp_path):
    messages = [
        each
        for arm in ("/one", "/two")
        for topic in ("trunk/setpoints", "joint_states")
        for each in motion(f"{arm}/{topic}")
    ]
    bag = write_bag(tmp_path / "bag", messages)
    with pytest.raises(RecordingError, match="several arms \\(/one, /two\\)"):
        read_recording(bag)
    assert len(read_recording(bag, namespace="two").series) == 2


def test_the_joint_states_of_another_machine_are_left_out_and_said(tmp_path):
    messages = motion("/arm/trunk/setpoints") + motion("/arm/joint_states") + motion(names=("wheel",))
    recording = read_recording(write_bag(tmp_path / "bag", messages))
    assert recording.joints == JOINTS
    assert any("/joint_states is left out" in note for note in recording.notes)


def test_a_needed_topic_of_another_type_is_an_error(tmp_path):
    text = STORE.types["std_msgs/msg/Header"]
    messages = [("/joint_states", START_NS, text(header(START_NS).stamp, ""))]
    with pytest.raises(RecordingError, match=r"/joint_states is std_msgs/msg/Header, not sensor_msgs"):
        read_recording(write_bag(tmp_path / "bag", messages))


def test_a_needed_topic_in_another_encoding_is_an_error(tmp_path):
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile="ros2")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "jsonschema", b"{}")
        writer.add_message(writer.register_channel("/joint_states", "json", schema), 1, b"{}", 1)
        writer.finish()
    with pytest.raises(RecordingError, match="/joint_states encoded as 'json': only cdr"):
        read_recording(tmp_path / "a.mcap")


def test_names_without_end_are_refused(tmp_path):
    messages = [
        ("/joint_states", START_NS + i, joint_state(START_NS + i, [f"j{i}"], [0])) for i in range(1500)
    ]
    with pytest.raises(RecordingError, match="names 1500 different joints"):
        read_recording(write_bag(tmp_path / "bag", messages))


def test_a_bag_without_the_topics_says_which_there_are(tmp_path):
    with pytest.raises(RecordingError, match="topics there: /imu, /odom"):
        read_recording(write_bag(tmp_path / "bag", motion("/odom") + motion("/imu")))
    recording = read_recording(write_bag(tmp_path / "other", motion("/trunk/setpoints")))
    with pytest.raises(RecordingError, match="no topic joint_states; topics there: trunk/setpoints"):
        recording.require("joint_states")


def test_gaps_are_counted_and_said(tmp_path):
    messages = motion(count=100)
    del messages[40:60], messages[20:25]
    recording = read_recording(write_bag(tmp_path / "bag", messages))
    assert (
        "joint_states: 2 gaps, the longest of 0.21 s at 0.39 s; about 25 messages missing" in recording.notes
    )


def test_topics_of_two_clocks_are_pointed_out(tmp_path):
    other = [
        (topic, log, joint_state(i * 10**7, JOINTS, [0, 0, i]))
        for i, (topic, log, _) in enumerate(motion("/trunk/gearbox_states"))
    ]
    recording = read_recording(write_bag(tmp_path / "bag", motion() + other))
    assert any("are they of one clock?" in note for note in recording.notes)


def test_a_part_keeps_the_stamps_of_the_whole(tmp_path):
    bag = write_bag(tmp_path / "bag", motion(count=101))
    first, rest = read_recording(bag, until="70%"), read_recording(bag, from_time="70%")
    stamps = np.concatenate([each.require("joint_states").stamp for each in (first, rest)])
    np.testing.assert_allclose(stamps, 0.01 * np.arange(101), atol=1e-12)
    assert first.duration == rest.duration == pytest.approx(1.0)
    assert read_recording(bag, "0.5", "0.6").require("joint_states").stamp[0] == pytest.approx(0.5)


def test_a_limit_beyond_the_end_is_noted_and_a_part_knows_what_was_asked(tmp_path):
    bag = write_bag(tmp_path / "bag", motion())
    beyond, part = read_recording(bag, until="500"), read_recording(bag, "0.1", "0.2s")
    assert beyond.notes[-1] == "--until 500 is beyond the end of the recording, which is at 0.49 s"
    assert (beyond.asked, part.asked) == (None, (0.1, 0.2))
    assert not any("--until" in note for note in part.notes + read_recording(bag, until="100%").notes)


@pytest.mark.parametrize(
    ("first", "until"),
    [("soon", None), ("-1", None), ("nan", None), ("101%", None), ("7", None), ("60%", "0.2")],
)
def test_a_part_that_cannot_be_is_refused_in_one_line(tmp_path, first, until):
    bag = write_bag(tmp_path / "bag", motion(count=101))
    with pytest.raises(ArgumentError, match="--from-time") as caught:
        read_recording(bag, first, until)
    assert "\n" not in str(caught.value)


def test_progress_rises_to_one(tmp_path):
    seen = []
    read_recording(write_bag(tmp_path / "bag", motion()), progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


@pytest.mark.skipif(not CONCEALED.is_dir(), reason="no shared recordings here")
def test_a_shared_recording_is_read_without_a_remark():
    recording = read_recording(CONCEALED / "dev_01/train")
    assert recording.joints == tuple(f"joint_{i}" for i in range(1, 6))
    assert recording.notes == ()
    assert recording.tip is not None
