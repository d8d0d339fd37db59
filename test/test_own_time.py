"""Claims about curves over time without a name: a model says which recordings they were drawn from, and the
commands where one is another.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, of_the_wires, recorded
from trunk_ros.effects.curve import HIGH, KNOTS, LOW, ON, VALUES
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.own_time import doubtful_curves, drawn_from
from trunk_ros.recording.identity import digest
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.write import write_recording

SECONDS = 8.0


def curves(*over: str) -> dict[str, Any]:
    """One curve of 2 mrad on each joint, over what is asked for; none where that is nothing."""
    there = np.array([float(bool(variable)) for variable in over])
    drawn = 2e-3 * np.sin(np.linspace(0.0, 6.0, KNOTS))
    values = {p.name: there * v for p, v in zip(VALUES, drawn, strict=True)}
    return {"unknown": {LOW: -there, HIGH: SECONDS * there, ON: list(over)} | values}


@pytest.fixture(scope="module")
def first() -> Recording:
    return recorded(seconds=SECONDS, nominal=SHORT)


@pytest.fixture(scope="module")
def later(first: Recording) -> Recording:
    return replace(first, start_ns=first.start_ns + 60_000_000_000)


@pytest.fixture(scope="module")
def model(first: Recording) -> Model:
    return drawn_from(Model(SHORT.arm, curves("time", "position", "")), first)


def test_one_line_says_where_a_curve_was_drawn_from_another_recording(
    first: Recording, later: Recording, model: Model
) -> None:
    (said,) = doubtful_curves(later, model)
    assert model.arm.joints[0] in said
    assert model.arm.joints[1] not in said
    assert doubtful_curves(first, model) == []


def test_recordings_that_begin_at_the_same_time_and_last_as_long_are_told_apart(
    first: Recording, model: Model
) -> None:
    other = recorded(seconds=SECONDS, nominal=SHORT, seed=9)
    assert (other.start_ns, other.duration) == (first.start_ns, first.duration)
    assert len(doubtful_curves(other, model)) == 1


def test_a_recording_is_the_same_whatever_is_cut_or_written_anew(
    first: Recording, model: Model, tmp_path: Path
) -> None:
    write_recording(tmp_path / "a", first)
    write_recording(tmp_path / "b", replace(read_recording(tmp_path / "a"), notes=("converted",)))
    for same in (first.part(2.0, 5.0), read_recording(tmp_path / "b")):
        assert same.stamped == first.stamped
        assert doubtful_curves(same, model) == []
    cut = read_recording(tmp_path / "a", "1", "50%")
    assert len(cut.series["joint_states"].stamp) < len(first.series["joint_states"].stamp)
    assert drawn_from(model, cut).recordings == model.recordings
    shown = first.series["joint_states"]
    turned = replace(shown, joints=shown.joints[::-1], position=shown.position[:, ::-1], velocity=None)
    assert digest({"joint_states": turned}) == first.content


def test_files_of_earlier_versions_know_their_recording_by_start_and_length(
    first: Recording, later: Recording, model: Model
) -> None:
    old = replace(model, recordings=(first.stamped.partition("#")[0],))
    assert doubtful_curves(first, old) == []
    assert len(doubtful_curves(later, old)) == 1


def test_a_name_over_time_is_in_no_doubt(first: Recording, later: Recording, model: Model) -> None:
    drift = {"thermal_drift": {"form": "straight", "rate": np.full(3, 1e-5)}}
    named = drawn_from(replace(model, effects=drift, recordings=()), first)
    assert named.recordings == ()
    assert doubtful_curves(later, named) == []


def test_of_a_model_that_does_not_say_what_it_is_of_nothing_is_said(later: Recording, model: Model) -> None:
    assert doubtful_curves(later, replace(model, recordings=())) == []


def test_the_file_says_what_it_is_of(
    first: Recording, later: Recording, model: Model, tmp_path: Path
) -> None:
    save_model(model, tmp_path / "model.yaml")
    read = load_model(tmp_path / "model.yaml")
    assert read.recordings == (first.stamped,)
    assert doubtful_curves(first, read) == []
    assert len(doubtful_curves(later, read)) == 1


def test_a_diagnosis_says_what_its_curves_are_of() -> None:
    seen = recorded(curves("time", "", ""), 20.0, nominal=SHORT, noise=2e-5)
    found = diagnose([of_the_wires(seen)], SHORT)
    assert found.model.recordings == (seen.stamped,)
