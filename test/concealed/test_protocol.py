"""Claims about concealing and revealing."""

from __future__ import annotations

from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader

from test.concealed.bag import NAMES
from test.concealed.case import Case, draw_case
from test.concealed.protocol import BrokenSealError, Concealed, conceal, reveal, seal, unsealed
from test.concealed.removed import read_angles


@pytest.fixture(scope="module")
def case() -> Case:
    """A short case with one effect."""
    return draw_case(1, effects=["ratio_error"], seconds=15.0)


@pytest.fixture
def where(case: Case, tmp_path: Path) -> Concealed:
    """The case, concealed."""
    return conceal(case, tmp_path / "open", tmp_path / "sealed")


def test_what_was_concealed_is_revealed(case: Case, where: Concealed) -> None:
    answer = reveal(where)
    assert answer.told["truth"][0]["effect"] == "ratio_error"
    assert (answer.clean == case.test.theta_clean).all()


def test_an_edited_answer_is_refused(where: Concealed) -> None:
    salt, answer = unsealed(where.sealed, where.key)
    answer["told"]["truth"][0]["effect"] = "backlash"
    seal(where.sealed, where.key, salt, answer)
    with pytest.raises(BrokenSealError, match="not the answer that was promised"):
        reveal(where)


def test_an_answer_under_another_salt_is_refused(where: Concealed) -> None:
    _, answer = unsealed(where.sealed, where.key)
    seal(where.sealed, where.key, "0" * 64, answer)
    with pytest.raises(BrokenSealError, match="hash differs"):
        reveal(where)


def test_a_damaged_seal_is_refused(where: Concealed) -> None:
    where.sealed.write_bytes(where.sealed.read_bytes()[:-40])
    with pytest.raises(BrokenSealError, match="damaged"):
        reveal(where)


def test_an_exchanged_recording_is_refused(where: Concealed) -> None:
    file = next((where.folder / "run_1").glob("*.mcap"))
    file.write_bytes(file.read_bytes() + b"\0")
    with pytest.raises(BrokenSealError, match="recordings"):
        reveal(where)


def test_the_open_folder_does_not_hold_the_truth(case: Case, where: Concealed) -> None:
    files = [f for f in where.folder.rglob("*") if f.is_file()]
    assert {f.suffix for f in files} == {".mcap", ".yaml", ".json"}
    for file in files:
        assert not any(word in file.read_bytes() for word in (b"ratio_error", b"truth", b"singles")), (
            file.name
        )
    with AnyReader([where.folder / "run_2"]) as reader:  # messages are compressed: no word would be found
        told = {c.topic for c in reader.connections}
    assert told <= {*NAMES.values()}
    shown = read_angles(where.folder / "run_2", "joint_states").angle
    assert (shown != case.test.theta_clean).all()
    assert not where.sealed.is_relative_to(where.folder)
    assert str(case.seed) != where.folder.name


def test_the_sealed_file_shows_no_word_of_the_answer(where: Concealed) -> None:
    assert b"ratio_error" not in where.sealed.read_bytes()


def test_two_seals_of_one_case_share_no_hash(case: Case, where: Concealed, tmp_path: Path) -> None:
    again = conceal(case, tmp_path / "again", tmp_path / "sealed")
    hashes = {(w.folder / "commitment.json").read_text() for w in (where, again)}
    assert len(hashes) == 2


def test_the_answer_cannot_be_read_without_the_key(where: Concealed) -> None:
    with pytest.raises(BrokenSealError, match="not its key"):
        unsealed(where.sealed, b"0" * 32)
    names = {f.name for f in where.sealed.parent.iterdir()} | {f.name for f in where.folder.rglob("*")}
    assert where.key.hex() not in str(names)
    for file in [where.sealed, *(f for f in where.folder.rglob("*") if f.is_file())]:
        assert where.key not in file.read_bytes()


def test_an_answer_and_a_hash_that_were_both_exchanged_are_refused(where: Concealed, tmp_path: Path) -> None:
    other = conceal(draw_case(2, effects=["backlash"], seconds=15.0), tmp_path / "open", tmp_path / "sealed")
    salt, answer = unsealed(other.sealed, other.key)
    seal(where.sealed, where.key, salt, answer)
    (where.folder / "commitment.json").write_text((other.folder / "commitment.json").read_text())
    with pytest.raises(BrokenSealError, match="its hash differs"):
        reveal(where)
