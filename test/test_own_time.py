"""A curve over time without a name says nothing of another recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, of_the_wires, recorded
from trunk_ros.effects.curve import HIGH, KNOTS, LOW, ON, VALUES
from trunk_ros.evaluate import of_model
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.own_time import drawn_from, held_to, left_out, over_own_time
from trunk_ros.recording.recording import Recording
from trunk_ros.simulate import simulate

SECONDS = 8.0


def curves(*over: str) -> dict:
    """One curve of 2 mrad on each joint, over what is asked for; none where that is nothing."""
    there = np.array([float(bool(variable)) for variable in over])
    drawn = 2e-3 * np.sin(np.linspace(0.0, 6.0, KNOTS))
    values = {p.name: there * v for p, v in zip(VALUES, drawn, strict=True)}
    return {"unknown": {LOW: -there, HIGH: SECONDS * there, ON: list(over)} | values}


@pytest.fixture(scope="module")
def first() -> Recording:
    return recorded(seconds=SECONDS, nominal=SHORT)


@pytest.fixture(scope="module")
def later(first) -> Recording:
    return replace(first, start_ns=first.start_ns + 60_000_000_000)


@pytest.fixture(scope="module")
def model(first) -> Model:
    return drawn_from(Model(SHORT.arm, curves("time", "position", "")), first)


def angles(recording: Recording, model: Model) -> np.ndarray:
    return simulate(recording, model, settle=0.0).series["joint_states"].position


def test_it_is_used_for_its_own_recording_and_left_out_of_another(first, later, model):
    alone = replace(model, effects=curves("", "position", ""))
    assert np.abs(angles(first, model) - angles(first, alone))[:, 0].max() > 1e-3
    assert held_to(model, first) is model
    assert angles(later, model) == pytest.approx(angles(later, alone), abs=1e-12)
    assert held_to(model, first, later).effects["unknown"][ON] == ["", "position", ""]


def test_one_line_says_so(first, later, model):
    (said,) = left_out(later, model)
    assert model.arm.joints[0] in said
    assert model.arm.joints[1] not in said
    assert left_out(first, model) == []


def test_what_nothing_is_left_of_is_gone(first, later):
    timed = drawn_from(Model(SHORT.arm, curves("time", "", "")), first)
    assert held_to(timed, later).effects == {}
    assert of_model(later, "m", timed).after[-1].error == pytest.approx(
        of_model(later, "m", SHORT).after[-1].error
    )


def test_a_name_over_time_and_a_model_that_does_not_say_what_it_is_of_stay(first, later, model):
    drift = {"thermal_drift": {"form": "linear", "rate": np.full(3, 1e-5)}}
    named = replace(model, effects=drift)
    assert held_to(named, later).effects == drift
    assert drawn_from(named, first).recordings == ()
    unsaid = replace(model, recordings=())
    assert held_to(unsaid, later) is unsaid


def test_the_file_says_what_it_is_of(first, later, model, tmp_path: Path):
    save_model(model, tmp_path / "model.yaml")
    read = load_model(tmp_path / "model.yaml")
    assert read.recordings == (first.stamped,)
    assert held_to(read, first) is read
    assert held_to(read, later) is not read


def test_a_diagnosis_says_what_its_curves_are_of():
    seen = recorded(curves("time", "", ""), 20.0, nominal=SHORT, noise=2e-5)
    found = diagnose([of_the_wires(seen)], SHORT)
    assert over_own_time(found.model)
    assert found.model.recordings == (seen.stamped,)
