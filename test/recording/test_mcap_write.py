"""An MCAP file in steps: what cannot be written whole is not in it."""

import os

import pytest
from mcap.reader import make_reader

from trunk_ros.recording.mcap import COMPRESSION
from trunk_ros.recording.mcap.repair import is_whole
from trunk_ros.recording.mcap.write import ChunkWriter


def writer_of(path, chunks=3, compression="zstd"):
    writer = ChunkWriter(path, compression)
    channel = writer.add_channel("/a", "std_msgs/msg/Empty", "", {})
    for chunk in range(chunks):
        add(writer, channel, chunk)
    return writer, channel


def add(writer, channel, chunk):
    for number in range(10):
        writer.add_message(channel, 100 * chunk + number, 0, number, os.urandom(100))
    writer.flush()


def times(path):
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        found = list(reader.iter_messages())
        assert reader.get_summary().statistics.message_count == len(found)
        return [message.log_time for _, _, message in found]


@pytest.mark.parametrize("compression", COMPRESSION)
def test_what_is_written_is_read_by_the_mcap_tools(tmp_path, compression):
    path = tmp_path / "a.mcap"
    writer, _ = writer_of(path, compression=compression)
    writer.finish({"note": {"key": "value"}})
    assert is_whole(path)
    assert times(path) == [100 * chunk + number for chunk in range(3) for number in range(10)]
    assert writer.span == (0, 209)
    assert path.stat().st_size == writer.size


def test_a_chunk_that_does_not_fit_leaves_the_file_as_it_was(tmp_path, monkeypatch):
    path = tmp_path / "a.mcap"
    writer, channel = writer_of(path)
    size = writer.size
    write, room = os.write, 300

    def full(file, data):
        nonlocal room
        if room <= 0:
            raise OSError(28, "No space left on device")
        written = write(file, data[:room])
        room -= written
        return written

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(OSError, match="No space"):
        add(writer, channel, 3)
    assert path.stat().st_size == writer.size == size
    monkeypatch.undo()
    writer.give_up_chunk()
    writer.finish({})
    assert len(times(path)) == 30


def test_the_last_chunk_can_give_way_to_the_index(tmp_path):
    path = tmp_path / "a.mcap"
    writer, _ = writer_of(path)
    writer.finish({})
    writer.unfinish()
    assert writer.drop_last()
    assert writer.counts == {1: 20}
    writer.finish({})
    assert times(path) == [100 * chunk + number for chunk in range(2) for number in range(10)]
    writer.unfinish()
    assert [writer.drop_last() for _ in range(3)] == [True, True, False]
    writer.finish({})
    assert times(path) == []


def test_no_file_is_seen_before_its_head_is_in_it(tmp_path):
    path = tmp_path / "a.mcap"
    ChunkWriter(path)
    assert path.read_bytes().startswith(b"\x89MCAP0\r\n\x01")
    assert [each.name for each in tmp_path.iterdir()] == ["a.mcap"]
