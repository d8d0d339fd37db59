"""A bag whose recorder was killed becomes one that all readers open."""

import errno
import fcntl
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.highlevel import AnyReader

from test.recording.bags import KIND, STORE, motion, only_file
from trunk_ros.commands.recover import main
from trunk_ros.errors import RecordingError
from trunk_ros.recording.mcap.verify import is_intact
from trunk_ros.recording.mcap.write import ChunkWriter
from trunk_ros.recording.messages.message_types import RELIABLE, definition, qos_text
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recover import recover, unfinished

COUNT = 2000


def write_mcap(file: Path, first: int = 0, compression: CompressionType = CompressionType.ZSTD) -> Path:
    """An MCAP file of many small chunks, as a recorder that flushes often leaves it."""
    random = np.random.default_rng(2)
    with file.open("wb") as stream:
        writer = McapWriter(stream, chunk_size=20_000, compression=compression)
        writer.start(profile="ros2", library="test")
        text, hash_ = definition(KIND)
        schema = writer.register_schema(KIND, "ros2msg", text.encode())
        noted = {"offered_qos_profiles": qos_text([RELIABLE]), "topic_type_hash": hash_}
        channel = writer.register_channel("/joint_states", "cdr", schema, noted)
        for number, (_, log_ns, message) in enumerate(motion(count=first + COUNT)[first:]):
            message.position[:] = random.normal(size=3)
            data = bytes(STORE.serialize_cdr(message, KIND))
            writer.add_message(channel, log_ns, data, log_ns - 5, first + number)
        writer.add_metadata("trunk_ros", {"seed": "7"})
        writer.finish()
    return file


@pytest.fixture
def killed(tmp_path: Path) -> Path:
    """A bag of which the last quarter was not written."""
    bag = tmp_path / "bag"
    bag.mkdir()
    file = write_mcap(bag / "bag_0.mcap")
    file.write_bytes(file.read_bytes()[: file.stat().st_size * 3 // 4])
    return bag


def messages(bag: Path) -> int:
    """How many messages rosbags and the mcap tools find, which must be the same."""
    with AnyReader([bag]) as reader:
        count = sum(1 for _ in reader.messages())
        assert count == reader.message_count
    found = 0
    for file in bag.glob("*.mcap"):
        with file.open("rb") as stream:
            found += sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages())
    assert found == count
    return count


def test_what_is_whole_is_kept_and_what_is_lost_is_said(killed):
    readable = len(read_recording(killed).require("joint_states").stamp)
    said = recover(killed)
    assert messages(killed) == readable
    assert f"{readable} messages kept; lost: about " in said[0]
    assert recover(killed) == [f"{killed}: is whole, nothing to repair"]
    assert read_recording(killed).notes == ()
    assert sorted(each.name for each in killed.iterdir()) == ["bag_0.mcap", "metadata.yaml"]


def test_the_estimate_of_what_the_cut_chunk_lost_is_about_right(tmp_path):
    file = write_mcap(tmp_path / "a.mcap")
    with file.open("rb") as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[-1]
    file.write_bytes(file.read_bytes()[: chunk.chunk_start_offset + chunk.chunk_length // 2])
    (said,) = recover(file)
    kept = len(read_recording(file).require("joint_states").stamp)
    lost = int(said.split("about ")[1].split()[0])
    assert abs(lost - (COUNT - kept)) <= 2
    assert f"{(COUNT - kept) * 0.01:.2f}"[:3] in said


def test_times_sequences_types_and_qualities_are_those_of_the_old_file(killed):
    recover(killed)
    with only_file(killed).open("rb") as stream:
        reader = make_reader(stream)
        rows = [(each.sequence, each.log_time - each.publish_time) for _, _, each in reader.iter_messages()]
    assert rows == [(number, 5) for number in range(len(rows))]
    topic = yaml.safe_load((killed / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    (entry,) = topic["topics_with_message_count"]
    assert entry["topic_metadata"]["type_description_hash"] == definition(KIND)[1]
    assert entry["topic_metadata"]["offered_qos_profiles"] == [RELIABLE]


@pytest.mark.parametrize("compression", CompressionType)
def test_every_compression_is_repaired_wherever_it_broke_off(tmp_path, compression):
    whole = write_mcap(tmp_path / "whole.mcap", compression=compression).read_bytes()
    for share in (0.3, 0.62, 0.9, 0.999):
        bag = tmp_path / f"bag_{share}"
        bag.mkdir()
        (bag / "bag_0.mcap").write_bytes(whole[: int(share * len(whole))])
        recover(bag)
        assert messages(bag) > COUNT * share * 0.7


def test_a_split_bag_gets_metadata_of_all_its_files(killed):
    write_mcap(killed / "bag_1.mcap", first=COUNT)
    recover(killed)
    total = messages(killed)
    content = yaml.safe_load((killed / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert content["message_count"] == total == sum(each["message_count"] for each in content["files"])
    assert content["relative_file_paths"] == ["bag_0.mcap", "bag_1.mcap"]
    assert total > COUNT


def test_a_file_of_a_split_bag_with_nothing_in_it_is_left_out_and_kept(killed):
    (killed / "bag_1.mcap").write_bytes(b"")
    said = recover(killed)
    assert "bag_1.mcap: is not an MCAP file; left out of the bag, kept as bag_1.mcap.damaged" in said[1]
    assert messages(killed) > 0
    assert sorted(each.name for each in killed.iterdir()) == [
        "bag_0.mcap",
        "bag_1.mcap.damaged",
        "metadata.yaml",
    ]
    assert recover(killed) == [f"{killed}: is whole, nothing to repair"]


def test_only_metadata_that_is_missing_or_damaged_is_written_anew(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    before = write_mcap(bag / "bag_0.mcap").read_bytes()
    for text in (None, "rosbag2_bagfile_information: {version: [", "x: 1"):
        if text is not None:
            (bag / "metadata.yaml").write_text(text)
        assert recover(bag) == [f"{bag}/metadata.yaml: written anew"]
        assert messages(bag) == COUNT
    assert only_file(bag).read_bytes() == before


def test_a_damaged_chunk_is_left_out_and_the_old_file_kept(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    file = write_mcap(bag / "bag_0.mcap")
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 0xFF
    file.write_bytes(data[:-100])
    said = recover(bag)
    assert "1 damaged chunks left out" in said[0]
    assert (bag / "bag_0.mcap.damaged").read_bytes() == data[:-100]
    assert COUNT * 0.8 < messages(bag) < COUNT


def test_a_bag_that_is_being_recorded_is_left_alone(killed):
    before = only_file(killed).read_bytes()
    with only_file(killed).open("rb+") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        with pytest.raises(RecordingError, match="is being recorded"):
            recover(killed)
    assert only_file(killed).read_bytes() == before


def test_a_file_system_without_locks_is_no_reason_not_to_repair(killed, monkeypatch):
    def none(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", none)
    assert unfinished(killed)
    assert "repaired" in recover(killed)[0]


@pytest.mark.parametrize("content", [b"", b"hello", b"\x89MCAP0\r\n"])
def test_what_cannot_be_repaired_is_left_as_it_is(tmp_path, content):
    (tmp_path / "bag").mkdir()
    file = tmp_path / "bag/bag_0.mcap"
    file.write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        recover(tmp_path / "bag")
    assert "\n" not in str(caught.value)
    assert file.read_bytes() == content
    assert [each.name for each in file.parent.iterdir()] == ["bag_0.mcap"]


def test_what_is_no_bag_is_refused(tmp_path):
    for target, said in ((tmp_path / "nothing", "does not exist"), (tmp_path, "holds no .mcap file")):
        with pytest.raises(RecordingError, match=said):
            recover(target)


def test_the_command_says_what_it_did(killed, capsys):
    copy = shutil.copytree(killed, killed.with_name("copy"))
    assert main([str(copy)]) == 0
    assert "messages kept" in capsys.readouterr().out


def test_a_file_that_was_just_begun_becomes_an_empty_bag(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    ChunkWriter(bag / "bag_0.mcap").close()
    assert "0 messages kept" in recover(bag)[0]
    assert messages(bag) == 0


def test_whether_a_bag_needs_repair_is_known(killed):
    assert unfinished(killed)
    recover(killed)
    assert not unfinished(killed)
    (killed / "metadata.yaml").unlink()
    assert unfinished(killed)
    with only_file(killed).open("rb+") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        with pytest.raises(RecordingError, match="is being recorded"):
            unfinished(killed)


def counted(file: Path) -> int:
    """Messages of a file, the same for rosbags and the mcap tools."""
    with AnyReader([file]) as reader, file.open("rb") as stream:
        count = sum(1 for _ in reader.messages())
        assert count == sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages())
    return count


def flipped(file: Path, at: int) -> None:
    data = bytearray(file.read_bytes())
    data[at] ^= 0x10
    file.write_bytes(bytes(data))


def test_a_flipped_byte_in_a_chunk_is_found_and_left_out(tmp_path):
    file = write_mcap(tmp_path / "bag.mcap")
    with file.open("rb") as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[0]
    flipped(file, chunk.chunk_start_offset + chunk.chunk_length // 2)
    (said,) = recover(file)
    assert "1 damaged chunks left out" in said
    assert "kept as bag.mcap.damaged" in said
    assert recover(file) == [f"{file}: is whole, nothing to repair"]


def test_a_flipped_byte_anywhere_is_found_or_harms_nobody(tmp_path):
    """Where it is not found, all readers agree on what the file holds. A header says nothing of messages."""
    file = write_mcap(tmp_path / "bag.mcap")
    whole, count = file.read_bytes(), counted(file)
    places = range(40, len(whole), len(whole) // 60)
    found = 0
    for at in places:
        file.write_bytes(whole)
        flipped(file, at)
        intact = is_intact(file)
        found += not intact
        assert not intact or counted(file) == count, at
    assert found > len(places) / 2


def test_an_index_that_leads_astray_is_made_anew_and_nothing_lost(tmp_path):
    file = write_mcap(tmp_path / "bag.mcap")
    count = counted(file)
    with file.open("rb") as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[0]
    flipped(file, max(chunk.message_index_offsets.values()) + 9 + 6 + 8)  # the offset of its first message
    (said,) = recover(file)
    assert f"{count} messages kept, all that the file held; its index is made anew" in said
    assert counted(file) == count
