"""How much of a damaged bag is said to be lost."""

import re
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.records import ChunkIndex

from test.recording.test_recover import COUNT, flipped, write_mcap
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recover import recover

LOST = re.compile(r"(\d+) messages kept; lost: about (\d+) messages, ([\d.]+) s")


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A bag with all that belongs to one."""
    folder = tmp_path / "bag"
    folder.mkdir()
    write_mcap(folder / "bag_0.mcap")
    recover(folder)
    return folder


def chunks(file: Path) -> list[ChunkIndex]:
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    return summary.chunk_indexes


def lost(bag: Path) -> tuple[str, int, int, float]:
    """What is said, messages kept and lost, and the seconds lost."""
    said = recover(bag)[0]
    found = LOST.search(said)
    assert found
    return said, int(found[1]), int(found[2]), float(found[3])


def test_the_summary_says_what_a_file_held_of_which_the_first_chunk_is_damaged(bag: Path) -> None:
    file = bag / "bag_0.mcap"
    (bag / "metadata.yaml").unlink()
    chunk = chunks(file)[0]
    flipped(file, chunk.chunk_start_offset + chunk.chunk_length // 2)
    _, kept, gone, seconds = lost(bag)
    assert kept + gone == COUNT
    assert gone > 50
    assert seconds == pytest.approx(0.01 * gone, abs=0.02)


@pytest.mark.parametrize("promised", [True, False])
def test_what_followed_where_a_file_is_cut_is_lost_as_metadata_says(bag: Path, promised: bool) -> None:
    file = bag / "bag_0.mcap"
    chunk = chunks(file)[1]
    flipped(file, chunk.chunk_start_offset + chunk.chunk_length // 2)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    if not promised:
        (bag / "metadata.yaml").unlink()
    said, kept, gone, seconds = lost(bag)
    assert ("and what followed" in said) is not promised
    if promised:
        assert kept + gone == COUNT
        assert seconds == pytest.approx(0.01 * gone, abs=0.05)
    else:
        assert kept + gone < 0.7 * COUNT


def test_of_a_file_that_ends_with_a_whole_record_the_end_is_missing(bag: Path) -> None:
    file = bag / "bag_0.mcap"
    file.write_bytes(file.read_bytes()[: chunks(file)[5].chunk_start_offset])
    assert "it breaks off: its end is missing" in read_recording(bag).notes
