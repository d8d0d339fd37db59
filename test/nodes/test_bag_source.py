"""Bags of every kind as the bytes that replay publishes."""

import shutil

import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from test.nodes.graph import needs_ros
from test.recording.bags import KIND, NOETIC, STORE, motion, only_file, write_bag, write_ros1
from trunk_ros.errors import RecordingError

pytestmark = needs_ros

COUNT = 40


def replayed(path):
    from trunk_ros.nodes.bags.source import BagSource

    with BagSource(path) as bag:
        return list(bag.messages({"/joint_states"})), bag


def expected():
    return [
        (log_ns, topic, bytes(STORE.serialize_cdr(message, KIND)))
        for topic, log_ns, message in motion(count=COUNT)
    ]


@pytest.mark.parametrize("storage", list(StoragePlugin))
@pytest.mark.parametrize("compression", [CompressionMode.NONE, CompressionMode.MESSAGE, CompressionMode.FILE])
def test_every_kind_of_rosbag2_folder_is_replayed(tmp_path, storage, compression):
    bag = write_bag(tmp_path / "bag", motion(count=COUNT), storage, 8, compression)
    assert replayed(bag)[0] == expected()


@pytest.mark.parametrize("suffix", [".mcap", ".db3"])
def test_a_bare_file_is_replayed(tmp_path, suffix):
    storage = StoragePlugin.MCAP if suffix == ".mcap" else StoragePlugin.SQLITE3
    file = only_file(write_bag(tmp_path / "bag", motion(count=COUNT), storage), suffix)
    shutil.move(file, tmp_path / f"bare{suffix}")
    assert replayed(tmp_path / f"bare{suffix}")[0] == expected()


def test_a_bag_of_ros_1_becomes_messages_of_ros_2(tmp_path):
    bag = write_ros1(tmp_path / "old.bag", motion(count=COUNT, store=NOETIC))
    messages, source = replayed(bag)
    assert messages == expected()
    assert source.notes == []


def test_a_cut_file_is_replayed_as_far_as_it_is_whole_and_that_is_said(tmp_path):
    file = only_file(write_bag(tmp_path / "bag", motion(count=COUNT)))
    (tmp_path / "cut.mcap").write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    messages, source = replayed(tmp_path / "cut.mcap")
    assert 0 < len(messages) < COUNT
    assert messages == expected()[: len(messages)]
    assert f"{len(messages)} messages kept" in source.notes[0]


@pytest.mark.parametrize(
    "content", [b"", b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n\0\0", b"SQLite format 3\0", b"hello"]
)
def test_what_is_no_bag_is_refused_in_one_line(tmp_path, content):
    file = tmp_path / "file.mcap"
    file.write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        replayed(file)
    assert "\n" not in str(caught.value)
