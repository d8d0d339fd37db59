"""Bags as they are written: every reader opens them, and what does not fit is said."""

import errno
import time
from pathlib import Path

import pytest
from mcap.reader import make_reader

from test.nodes.graph import bag_messages
from trunk_ros.errors import ArgumentError
from trunk_ros.nodes.bags import writer as bag_writer
from trunk_ros.nodes.bags.writer import BagWriter, Channel, Entry, Options
from trunk_ros.recording.bag.metadata import read_metadata
from trunk_ros.recording.mcap import COMPRESSION
from trunk_ros.recording.mcap.write import ChunkWriter
from trunk_ros.recording.messages.message_types import RELIABLE, definition

STRING = "std_msgs/msg/String"
BEGIN = 1_750_000_000 * 10**9


def channel(name="/talk"):
    text, digest = definition(STRING)
    return Channel(name, STRING, text, digest, [RELIABLE])


def entries(talk, count, size=8):
    data = b"\0\1\0\0" + size.to_bytes(4, "little") + b"x" * (size - 1) + b"\0"
    return [Entry(talk, BEGIN + step * 10**7, BEGIN, step, data) for step in range(count)]


def write(path: Path, options: Options, count=500, size=8):
    writer, talk = BagWriter(path, options), channel()
    writer.add_channel(talk)
    kept = [writer.put(entry) for entry in entries(talk, count, size)]
    writer.close(lambda: {"trunk_ros.loss": "{}"})
    return writer, kept


@pytest.mark.parametrize("compression", COMPRESSION)
def test_every_compression_is_read_back(tmp_path, compression):
    write(tmp_path / "bag", Options(compression=compression))
    assert len(bag_messages(tmp_path / "bag")["/talk"]) == 500


@pytest.mark.parametrize(
    "options",
    [Options(split_bytes=1 << 14, chunk_bytes=1 << 12, compression="none"), Options(split_seconds=1.0)],
)
def test_a_split_bag_is_one_recording(tmp_path, options):
    write(tmp_path / "bag", options, count=500, size=200)
    told = read_metadata(tmp_path / "bag")
    assert len(told.files) > 3
    assert told.files[1] == "bag_1.mcap"
    assert len(bag_messages(tmp_path / "bag")["/talk"]) == told.messages["/talk"] == 500


def test_what_has_no_room_in_the_queue_is_turned_away(tmp_path):
    _, kept = write(tmp_path / "bag", Options(buffer_bytes=10_000), count=2000, size=1000)
    assert not all(kept)
    assert len(bag_messages(tmp_path / "bag")["/talk"]) == sum(kept)


def test_a_full_disk_ends_the_recording_with_what_it_has(tmp_path, monkeypatch):
    writer, talk = BagWriter(tmp_path / "bag", Options()), channel()
    writer.add_channel(talk)
    for entry in entries(talk, 100):
        assert writer.put(entry)
    wait_until(lambda: not writer.queued_bytes)
    monkeypatch.setattr(bag_writer, "ROOM", 1 << 60)
    wait_until(lambda: writer.failure)
    assert "full" in writer.failure
    assert not writer.put(entries(talk, 1)[0])
    writer.close(dict)
    assert len(bag_messages(tmp_path / "bag")["/talk"]) >= 100


def wait_until(condition):
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_bag_without_messages_can_be_opened(tmp_path):
    BagWriter(tmp_path / "bag", Options()).close(dict)
    assert bag_messages(tmp_path / "bag") == {}


def test_a_folder_that_exists_is_refused(tmp_path):
    with pytest.raises(ArgumentError, match="exists"):
        BagWriter(tmp_path, Options())


def test_the_mcap_tools_find_every_message_by_its_index_and_check_every_chunk(tmp_path):
    write(tmp_path / "bag", Options(chunk_bytes=1 << 12), count=500, size=200)
    with (tmp_path / "bag/bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary.statistics.message_count == 500
        assert len(summary.chunk_indexes) > 20
        assert all(chunk.message_index_offsets for chunk in summary.chunk_indexes)
        (channel,) = summary.channels.values()
        assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
        assert "offered_qos_profiles" in channel.metadata
        assert summary.schemas[channel.schema_id].encoding == "ros2msg"
        first, end = BEGIN + 100 * 10**7, BEGIN + 200 * 10**7
        found = [
            message.sequence
            for _, _, message in reader.iter_messages(["/talk"], starting_at=first, ending_before=end)
        ]
        assert found == list(range(100, 200))
        noted = [each.metadata for each in reader.iter_metadata() if each.name == "trunk_ros"]
        assert noted == [{}, {"trunk_ros.loss": "{}"}]


@pytest.mark.parametrize("jump", [-3600 * 10**9, 3600 * 10**9, -BEGIN, 2**63 - 1, -(2**63)])
@pytest.mark.parametrize("split", [0.0, 0.5])
def test_a_clock_that_jumps_corrupts_nothing(tmp_path, jump, split):
    writer, talk = BagWriter(tmp_path / "bag", Options(split_seconds=split)), channel()
    writer.add_channel(talk)
    for step, entry in enumerate(entries(talk, 100)):
        moved = entry._replace(log_ns=entry.log_ns + (jump if 40 <= step < 60 else 0))
        assert writer.put(moved)
    writer.close(dict)
    assert not writer.failure
    assert len(bag_messages(tmp_path / "bag")["/talk"]) == 100
    for file in (tmp_path / "bag").glob("*.mcap"):
        with file.open("rb") as stream:
            make_reader(stream, validate_crcs=True).get_summary()


@pytest.mark.parametrize("split", [0.0, 0.5])
def test_publishers_of_another_quality_that_come_later_do_no_harm(tmp_path, split):
    writer, talk = BagWriter(tmp_path / "bag", Options(split_seconds=split)), channel()
    writer.add_channel(talk)
    for step, entry in enumerate(entries(talk, 100)):
        if step == 30:
            wait_until(lambda: not writer.queued_bytes)
            talk.qos = [RELIABLE, RELIABLE | {"reliability": "best_effort"}]
        assert writer.put(entry)
    writer.close(dict)
    assert len(bag_messages(tmp_path / "bag")["/talk"]) == 100


def test_a_fault_of_ours_is_not_hidden(tmp_path, monkeypatch):
    writer, talk = BagWriter(tmp_path / "bag", Options()), channel()
    writer.add_channel(talk)
    monkeypatch.setattr(writer, "_write", lambda entry: 1 / 0)
    assert writer.put(entries(talk, 1)[0])
    wait_until(lambda: writer.failure)
    with pytest.raises(ZeroDivisionError):
        writer.close(dict)


def test_a_disk_without_room_for_the_head_leaves_no_folder(tmp_path, monkeypatch):
    def full(self, data):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(ChunkWriter, "_append", full)
    with pytest.raises(ArgumentError, match="No space left on device"):
        BagWriter(tmp_path / "bag", Options())
    assert list(tmp_path.iterdir()) == []
