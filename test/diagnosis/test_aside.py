"""What nobody looks at is out of memory meanwhile, and back afterwards."""

from __future__ import annotations

import tempfile
from typing import Any

import numpy as np
import pytest

from trunk_ros.diagnosis.resources import aside as module
from trunk_ros.diagnosis.resources.aside import aside, size_of
from trunk_ros.recording.recording import JointSeries, Recording


def of(samples: int) -> list[Recording]:
    position = np.random.default_rng(1).normal(size=(samples, 2))
    series = JointSeries(np.arange(samples) / 100.0, ("a", "b"), position)
    return [Recording("run", 0, samples / 100.0, {"joint_states": series})]


def position(recordings: list[Recording]) -> Any:
    return recordings[0].series["joint_states"].position


@pytest.fixture
def long(monkeypatch: pytest.MonkeyPatch) -> list[Recording]:
    monkeypatch.setattr(module, "RETURNED", 1000)
    return of(1000)


def test_long_recordings_are_away_within_and_as_they_were_afterwards(long: list[Recording]) -> None:
    wires, before = [long[0]], position(long).copy()
    with aside(size_of(long), long, wires):
        assert [*long, *wires] == []
    assert np.array_equal(position(long), before)
    assert wires[0] is long[0]  # what was one thing is not there twice


def test_they_come_back_after_an_error(long: list[Recording]) -> None:
    with pytest.raises(ValueError, match="wrong"), aside(size_of(long), long):
        raise ValueError("wrong")
    assert len(long) == 1


def test_what_is_made_meanwhile_is_there_beside_what_was_away(long: list[Recording]) -> None:
    drawn = {"wire": position(long)}
    with aside(size_of(long), drawn):
        assert drawn == {}
        drawn["servo"] = np.zeros(3)
    assert drawn.keys() == {"wire", "servo"}
    assert np.array_equal(drawn["wire"], position(long))


def test_short_recordings_stay() -> None:
    short = of(1000)
    with aside(size_of(short), short):
        assert len(short) == 1


def test_recordings_stay_where_no_disk_has_room(
    long: list[Recording], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(module.pickle, "dump", full)
    with aside(size_of(long), long):
        assert len(long) == 1
    monkeypatch.setattr(tempfile, "TemporaryFile", full)
    with aside(size_of(long), long):
        assert len(long) == 1
