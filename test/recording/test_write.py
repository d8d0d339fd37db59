"""What is written is read back the same, by this package and by others."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosReliability

from test.recording.bags import only_file
from trunk_ros.errors import ArgumentError
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, PoseSeries, Recording
from trunk_ros.recording.write import write_recording


def example(count: int = 400) -> Recording:
    """Topics of different rate, phase and fields."""
    random = np.random.default_rng(3)
    joints = ("q1", "slide", "longer_name")
    stamp = np.round(np.cumsum(random.uniform(0.001, 0.01, count)), 9)
    stamp -= stamp[0]
    full = JointSeries(stamp, joints, *random.normal(size=(3, count, 3)))
    bare = JointSeries(stamp[::2] + 0.0005, joints, random.normal(size=(count, 3))[::2])
    tip = PoseSeries(
        stamp[::4], random.normal(size=(count, 3))[::4], random.normal(size=(count, 4))[::4], "base"
    )
    series = {"gearbox_states": full, "joint_states": bare}
    return Recording(
        "example", 1_750_000_000_123_456_789, float(stamp[-1]), series, tip, units={"slide": "m"}
    )


def same(one: Recording, other: Recording) -> None:
    assert one.series.keys() == other.series.keys()
    for key, series in one.series.items():
        assert series.joints == other.series[key].joints
        for name in ("position", "velocity", "effort"):
            values, read = getattr(series, name), getattr(other.series[key], name)
            assert (values is None) == (read is None)
            np.testing.assert_array_equal(values, read)
        np.testing.assert_allclose(series.stamp, other.series[key].stamp, atol=1e-9)
    np.testing.assert_array_equal(one.tip.orientation, other.tip.orientation)
    assert one.tip.frame == other.tip.frame


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    write_recording(tmp_path / "bag", example(), custom={"seed": "7"})
    return tmp_path / "bag"


def test_what_is_written_is_read_back(bag):
    recording = read_recording(bag)
    same(example(), recording)
    assert recording.start_ns == example().start_ns
    assert (recording.units, recording.custom) == ({"slide": "m"}, {"seed": "7"})


def test_units_and_custom_entries_are_also_in_the_bare_file(bag):
    recording = read_recording(only_file(bag))
    assert (recording.units, recording.custom) == ({"slide": "m"}, {"seed": "7"})


def test_notes_of_the_writer_are_read_back(tmp_path):
    write_recording(tmp_path / "bag", replace(example(), notes=("12 rows repeated a stamp",)))
    assert "12 rows repeated a stamp" in read_recording(tmp_path / "bag").notes


def test_what_the_recorder_noted_about_its_losses_is_said(tmp_path):
    noted = {"expected": 50, "received": 47, "lost": 2, "dropped": 1}
    write_recording(
        tmp_path / "bag", example(), custom={"trunk_ros.loss": json.dumps({"/joint_states": noted})}
    )
    said = read_recording(tmp_path / "bag").notes
    assert said == ("/joint_states: the recorder missed 3 of 50 messages",)


@pytest.mark.parametrize(
    "noted", ["", "[]", "3", '{"/a": 1}', '{"/a": {"lost": 1e999, "dropped": 0}}', "{" * 9999]
)
def test_losses_that_cannot_be_read_do_no_harm(tmp_path, noted):
    write_recording(tmp_path / "bag", example(), custom={"trunk_ros.loss": noted})
    (said,) = read_recording(tmp_path / "bag").notes
    assert "cannot be read" in said


def test_rosbags_reads_it_with_its_custom_data_and_verifies_the_type_hashes(bag):
    with AnyReader([bag]) as reader:
        messages = [
            (each.topic, log, reader.deserialize(raw, each.msgtype)) for each, log, raw in reader.messages()
        ]
        assert reader.readers[0].storage.metadata.custom["seed"] == "7"
        assert all(each.digest.startswith("RIHS01_") for each in reader.connections)
        qos = reader.connections[0].ext.offered_qos_profiles[0]
        assert (qos.reliability, qos.depth, qos.lifespan.sec) == (QosReliability.RELIABLE, 10, 9223372036)
    assert len(messages) == 400 + 200 + 100
    assert [log for _, log, _ in messages] == sorted(log for _, log, _ in messages)
    stamp = messages[0][2].header.stamp
    assert stamp.sec * 10**9 + stamp.nanosec == messages[0][1]


def test_the_mcap_tools_read_it_with_checksums_indexes_and_schemas(bag):
    with only_file(bag).open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert sum(1 for _ in reader.iter_messages()) == summary.statistics.message_count == 700
        assert reader.get_header().profile == "ros2"
        assert {each.encoding for each in summary.schemas.values()} == {"ros2msg"}
        assert all(
            each.compression == "zstd" and each.message_index_offsets for each in summary.chunk_indexes
        )
        channel = next(iter(summary.channels.values()))
        assert isinstance(yaml.safe_load(channel.metadata["offered_qos_profiles"]), list)
        assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
        described = {each.name: each.metadata for each in reader.iter_metadata()}
    assert yaml.safe_load(described["rosbag2"]["serialized_metadata"])["message_count"] == 700


def test_chunks_carry_checksums(bag):
    from trunk_ros.recording.mcap import records as mcap

    data = only_file(bag).read_bytes()
    chunks = [each for each in mcap.records(data, 8, len(data)) if each.kind == mcap.CHUNK]
    assert chunks
    assert all(int.from_bytes(data[each.start + 24 : each.start + 28], "little") for each in chunks)


def test_the_metadata_has_every_key_of_version_9_and_no_reference(bag):
    text = (bag / "metadata.yaml").read_text()
    content = yaml.safe_load(text)["rosbag2_bagfile_information"]
    assert "&" not in text
    assert set(content) == {
        "version",
        "storage_identifier",
        "duration",
        "starting_time",
        "message_count",
        "compression_format",
        "topics_with_message_count",
        "compression_mode",
        "relative_file_paths",
        "files",
        "custom_data",
        "ros_distro",
    }
    assert content["version"] == 9
    assert content["relative_file_paths"] == ["bag_0.mcap"]
    assert isinstance(content["topics_with_message_count"][0]["topic_metadata"]["offered_qos_profiles"], list)


def test_an_output_that_exists_is_refused_unless_overwritten(bag):
    with pytest.raises(ArgumentError, match="exists"):
        write_recording(bag, example())
    write_recording(bag, example(count=8), overwrite=True)
    assert len(read_recording(bag).require("gearbox_states").stamp) == 8
    assert [each.name for each in bag.parent.iterdir()] == ["bag"]


def test_a_folder_with_other_things_is_never_overwritten(tmp_path):
    (tmp_path / "home").mkdir()
    (tmp_path / "home/thesis.tex").write_text("precious")
    with pytest.raises(ArgumentError, match=r"thesis\.tex"):
        write_recording(tmp_path / "home", example(), overwrite=True)
    assert (tmp_path / "home/thesis.tex").read_text() == "precious"


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_disk_that_is_full_gives_one_line_and_leaves_what_was_there(bag, overwrite):
    """A limit on the size of files stands for the disk."""
    before = {each.name: each.read_bytes() for each in bag.iterdir()}
    target = bag if overwrite else bag.with_name("other")
    script = f"""
import resource, signal
from test.recording.test_write import example
from trunk_ros.errors import ArgumentError
from trunk_ros.recording.write import write_recording
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
recording = example(4000)
resource.setrlimit(resource.RLIMIT_FSIZE, (50000, 50000))
try:
    write_recording({str(target)!r}, recording, overwrite={overwrite})
except ArgumentError as error:
    print(error)
"""
    root = Path(__file__).resolve().parents[2]
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=root, capture_output=True, text=True, check=True
    )
    assert "cannot be written" in done.stdout
    assert done.stdout.count("\n") == 1
    assert [each.name for each in bag.parent.iterdir()] == ["bag"]
    assert {each.name: each.read_bytes() for each in bag.iterdir()} == before


def test_a_parent_that_is_a_file_is_refused_in_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    for target in (tmp_path / "file/bag", tmp_path / "file/deeper/bag"):
        with pytest.raises(ArgumentError, match="bag cannot be") as caught:
            write_recording(target, example(count=4))
        assert "\n" not in str(caught.value)


def test_an_interrupted_write_leaves_nothing(tmp_path, monkeypatch):
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("trunk_ros.recording.write.write_metadata", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_recording(tmp_path / "bag", example(count=4))
    assert list(tmp_path.iterdir()) == []


def test_stamps_that_ros_cannot_hold_are_refused(tmp_path):
    with pytest.raises(ArgumentError, match="1970 to 2038"):
        write_recording(tmp_path / "bag", replace(example(count=4), start_ns=-(10**12)))
    assert list(tmp_path.iterdir()) == []


def test_swapped_arguments_are_named_in_one_line(tmp_path):
    with pytest.raises(ArgumentError, match=r"got \(Recording, str\): the folder comes first"):
        write_recording(example(count=4), str(tmp_path / "bag"))
