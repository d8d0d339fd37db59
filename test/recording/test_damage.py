"""Damaged recordings: read as far as they are whole, or refused in one line; never a traceback."""

import shutil
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from test.recording.bags import NOETIC, STORE, Message, motion, only_file, write_bag, write_ros1
from trunk_ros.errors import RecordingError
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.write import write_recording

COUNT = 12000  # more than one chunk


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag of several chunks."""
    folder = tmp_path_factory.mktemp("bags")
    return write_bag(folder / "bag", noisy(), compression=CompressionMode.STORAGE)


def noisy(store: Any = STORE) -> list[Message]:
    """Messages that compress badly, so that half of a file is half of them."""
    random, messages = np.random.default_rng(1), motion(count=COUNT, store=store)
    for _, _, message in messages:
        message.position[:] = random.normal(size=len(message.position))
    return messages


def refused(path: Path) -> str:
    """The one line with which a recording is refused."""
    with pytest.raises(RecordingError) as caught:
        read_recording(path)
    text = str(caught.value)
    assert "\n" not in text
    assert str(path) in text
    return text


def copied(whole: Path, target: Path) -> Path:
    shutil.copytree(whole, target)
    return target


def cut(file: Path, size: int) -> Path:
    file.write_bytes(file.read_bytes()[:size])
    return file


def messages_of(recording: Recording) -> int:
    return len(recording.require("joint_states").stamp)


def test_a_cut_mcap_is_read_as_far_as_it_is_whole_and_the_loss_is_said(whole, tmp_path):
    bag = copied(whole, tmp_path / "bag")
    file = cut(only_file(bag), only_file(bag).stat().st_size // 2)
    recording = read_recording(bag)
    assert COUNT // 4 < messages_of(recording) < COUNT * 3 // 4
    assert any("breaks off" in note for note in recording.notes)
    assert f"{messages_of(recording)} of {COUNT} messages could be read" in recording.notes
    assert messages_of(read_recording(file)) == messages_of(recording)


def test_messages_of_a_chunk_that_is_cut_are_not_thrown_away(whole, tmp_path):
    file = only_file(copied(whole, tmp_path / "bag"))
    size = file.stat().st_size
    kept = [messages_of(read_recording(cut(file, size * part // 100))) for part in (80, 60, 40, 20)]
    assert kept == sorted(kept, reverse=True)
    assert kept[-1] > COUNT // 10


def test_only_an_index_that_is_missing_loses_no_message(whole, tmp_path):
    file = only_file(copied(whole, tmp_path / "bag"))
    recording = read_recording(cut(file, file.stat().st_size - 20))
    assert messages_of(recording) == COUNT


def test_zeros_that_a_power_cut_leaves_behind_end_the_file(whole, tmp_path):
    file = only_file(copied(whole, tmp_path / "bag"))
    size = file.stat().st_size
    cut(file, size // 2)
    with file.open("ab") as stream:
        stream.write(bytes(size))
    assert 0 < messages_of(read_recording(file)) < COUNT


def test_a_chunk_with_a_wrong_checksum_is_left_out_and_said(whole, tmp_path):
    source = read_recording(whole)
    write_recording(tmp_path / "bag", source)
    file = only_file(tmp_path / "bag")
    data = bytearray(file.read_bytes())
    data[len(data) // 3] ^= 0xFF
    file.write_bytes(data)
    recording = read_recording(tmp_path / "bag")
    assert 0 < messages_of(recording) < COUNT
    assert any("left out" in note for note in recording.notes)


@pytest.mark.parametrize("compression", [None, *Writer1.CompressionFormat])
def test_a_cut_ros_1_bag_is_read_as_far_as_it_is_whole(tmp_path, compression):
    bag = write_ros1(tmp_path / "a.bag", noisy(NOETIC), compression)
    recording = read_recording(cut(bag, bag.stat().st_size * 2 // 3))
    assert 0 < messages_of(recording) < COUNT
    assert any("breaks off" in note for note in recording.notes)


def test_a_cut_sqlite_bag_is_read_as_far_as_it_is_whole(tmp_path):
    bag = write_bag(tmp_path / "bag", motion(count=2000), StoragePlugin.SQLITE3)
    cut(only_file(bag, ".db3"), only_file(bag, ".db3").stat().st_size * 2 // 3)
    recording = read_recording(bag)
    assert 500 < messages_of(recording) < 2000
    assert any("breaks off" in note for note in recording.notes)


def test_what_sqlite_left_in_its_log_when_it_was_killed_is_read_and_the_bag_not_touched(tmp_path):
    bag = write_bag(tmp_path / "bag", motion(count=100), StoragePlugin.SQLITE3)
    file = only_file(bag, ".db3")
    database = sqlite3.connect(file)
    database.execute("PRAGMA journal_mode=WAL")
    database.execute("INSERT INTO messages SELECT id + 1000, 1, timestamp, data FROM messages WHERE id = 7")
    database.commit()
    killed = shutil.copytree(bag, tmp_path / "killed")
    database.close()
    before = {each.name: each.read_bytes() for each in killed.iterdir()}
    recording = read_recording(killed)
    assert recording.counts["joint_states"].messages == 101
    assert {each.name: each.read_bytes() for each in killed.iterdir()} == before


def test_one_cut_file_of_a_split_bag_does_not_lose_the_others(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    messages = motion(count=300)
    for part in range(3):
        one = write_bag(tmp_path / str(part), messages[100 * part : 100 * part + 100])
        shutil.copy(only_file(one), bag / f"bag_{part}.mcap")
    (bag / "bag_1.mcap").write_bytes(b"")
    recording = read_recording(bag)
    assert messages_of(recording) == 200
    assert any("bag_1.mcap is empty" in note for note in recording.notes)


def test_a_folder_without_metadata_is_read_and_recover_is_recommended(whole, tmp_path):
    bag = copied(whole, tmp_path / "bag")
    (bag / "metadata.yaml").unlink()
    recording = read_recording(bag)
    assert messages_of(recording) == COUNT
    assert any("recover" in note for note in recording.notes)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9])
def test_metadata_that_is_cut_is_refused_and_recover_is_recommended(whole, tmp_path, share):
    bag = copied(whole, tmp_path / "bag")
    cut(bag / "metadata.yaml", int(share * (bag / "metadata.yaml").stat().st_size))
    assert "damaged metadata.yaml" in refused(bag)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("version: 9", "version: 10", "version 10: 1 to 9 can be read"),
        ("version: 9", "version: soon", "damaged metadata.yaml"),
        ("storage_identifier: mcap", "storage_identifier: leveldb", "'leveldb': mcap and sqlite3"),
        ("compression_mode: ''", "compression_mode: file", "zstd can be read"),
        ("- bag.mcap", "- gone.mcap", "lacks its file gone.mcap"),
        ("rosbag2_bagfile_information", "something_else", "no 'rosbag2_bagfile_information'"),
    ],
)
def test_metadata_that_does_not_fit_is_refused(whole, tmp_path, old, new, said):
    bag = copied(whole, tmp_path / "bag")
    file = bag / "metadata.yaml"
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new))
    assert said in refused(bag)


def test_metadata_cannot_lead_out_of_the_folder(whole, tmp_path):
    bag = copied(whole, tmp_path / "bag")
    file = bag / "metadata.yaml"
    file.write_text(file.read_text().replace("- bag.mcap", f"- ../{whole.name}/../secret.mcap"))
    assert "lacks its file secret.mcap" in refused(bag)


def test_a_missing_file_is_named(whole, tmp_path):
    bag = copied(whole, tmp_path / "bag")
    only_file(bag).unlink()
    assert "lacks its file bag.mcap" in refused(bag)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty"),
        (b"hello", "is no recording"),
        (b"\x89MCAP0\r\n", "no topic"),
        (b"\0" * 99, "no recording"),
    ],
)
def test_a_file_that_is_no_recording_is_refused(tmp_path, content, said):
    file = tmp_path / "file.mcap"
    file.write_bytes(content)
    assert said in refused(file)


def test_what_is_not_there_or_empty_is_refused(tmp_path):
    assert "does not exist" in refused(tmp_path / "nothing")
    (tmp_path / "empty").mkdir()
    assert "is no recording" in refused(tmp_path / "empty")
    assert "neither a file nor a folder" in refused(Path("/dev/null"))


def test_a_bag_without_messages_is_refused(tmp_path):
    messages = motion(count=1)
    bag = write_bag(tmp_path / "bag", messages)
    file = only_file(bag)
    content = file.read_bytes()
    at = content.index(b"joint_two")
    file.write_bytes(content[:at])
    assert "no readable message" in refused(file)


@pytest.mark.parametrize("number", ["9e999", "-9e999", "'x'", "NULL", "1.5e300"])
def test_a_topic_whose_number_is_none_is_refused_or_left_out(number, tmp_path):
    file = only_file(write_bag(tmp_path / "bag", motion(count=4), StoragePlugin.SQLITE3), ".db3")
    with sqlite3.connect(file) as database:
        database.execute("CREATE TABLE other AS SELECT * FROM topics")
        database.execute("DROP TABLE topics")
        database.execute("ALTER TABLE other RENAME TO topics")
        database.execute(f"UPDATE topics SET id = {number}")
    with pytest.raises(RecordingError) as refused:
        read_recording(file)
    assert str(refused.value).startswith(str(file))
