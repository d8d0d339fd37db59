"""From Python: recordings from arrays and tables, results as rows and figures, models that predict."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import on, recorded
from trunk_ros.diagnosis import Diagnosis, diagnose
from trunk_ros.errors import RecordingError
from trunk_ros.recording.recording import Recording

HALF_WIDTH = 8e-4


@pytest.fixture(scope="module")
def made() -> Recording:
    return recorded({"backlash": {"half_width": on(2, HALF_WIDTH)}}, 30.0)


@pytest.fixture(scope="module")
def result(made: Recording) -> Diagnosis:
    joint, motor = made.series["joint_states"], made.series["gearbox_states"]
    return diagnose(Recording.from_arrays(joint.stamp, motor.position, joint.position))


def test_one_recording_from_arrays_is_diagnosed(result: Diagnosis) -> None:
    assert [finding.effect for finding in result.findings] == ["backlash"]
    assert result.findings[0].joints == ["joint_2"]


def test_a_result_shows_itself_as_a_table(result: Diagnosis) -> None:
    lines = repr(result).splitlines()
    assert lines[0] == "verdict: explained"
    assert lines[1].split() == ["stage", "effect", "joint", "parameter", "value", "sure", "or"]
    assert lines[2].split()[:4] == ["wire", "backlash", "joint_2", "half_width"]
    assert "±" in lines[2]


@pytest.mark.parametrize("kind", [str, Path])
def test_it_is_saved_into_a_folder_that_is_made(kind: type, result: Diagnosis, tmp_path: Path) -> None:
    folder = tmp_path / "not" / "there"
    for _ in range(2):
        result.save(kind(folder))
    assert {"diagnosis.json", "model.yaml"} <= {file.name for file in folder.iterdir()}


def test_its_rows_are_a_table_of_pandas(result: Diagnosis) -> None:
    pytest.importorskip("pandas")
    table = result.to_dataframe()
    row = table[table.effect == "backlash"].iloc[0]
    assert row.value == pytest.approx(HALF_WIDTH, abs=5 * row["std"])
    assert row.unit == "rad"


def test_its_figures_are_those_of_the_report(result: Diagnosis) -> None:
    assert result.plot.before_after().axes
    assert result.plot.over_time().axes
    assert result.plot.signature("backlash") is not None
    with pytest.raises(ValueError, match="there are backlash"):
        result.plot.signature("creep")


def test_the_model_found_predicts_and_scores_a_recording(result: Diagnosis, made: Recording) -> None:
    scores = result.model.score(made)
    assert scores["joint_2"] < 0.2 * HALF_WIDTH
    assert scores["joint_2"] < 0.3 * diagnose_nothing(made)["joint_2"]
    predicted = result.model.predict(made).series["joint_states"]
    assert predicted.position.shape == made.series["joint_states"].position.shape


def diagnose_nothing(recording: Recording) -> dict[str, float]:
    """Scores of the nominal arm."""
    from trunk_ros.model import load_model

    return load_model("trunk").score(recording)


def test_degrees_become_radians_and_names_are_kept() -> None:
    t = np.arange(20) / 10.0
    made = Recording.from_arrays(t + 5.0, 180.0 * np.sin(t), 90.0 * np.sin(t), joints=["elbow"], unit="deg")
    joint = made.series["joint_states"]
    assert joint.joints == ("elbow",)
    assert joint.stamp[0] == 0.0
    np.testing.assert_allclose(joint.position[:, 0], np.pi / 2 * np.sin(t))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (([0.0, 1.0, 1.0], [1, 2, 3], [1, 2, 3]), "must rise"),
        (([0.0, 1.0, 2.0], [1, 2], [1, 2, 3]), "gearbox_states has the shape"),
        (([0.0, 1.0], [[1, 2], [1, 2]], [1, 2]), "joint_states has 1 columns for 2 joints"),
        (([0.0, 1.0],), "give motor and joint"),
    ],
)
def test_arrays_that_do_not_fit_are_refused_in_one_line(arguments: tuple, says: str) -> None:
    with pytest.raises(RecordingError, match=says):
        Recording.from_arrays(*arguments)


def test_a_table_of_pandas_is_a_recording() -> None:
    pandas = pytest.importorskip("pandas")
    t = np.arange(10) / 10.0
    table = pandas.DataFrame({"t": t, "m": 2 * t, "e": t})
    made = Recording.from_pandas(table, motor={"elbow": "m"}, joint={"elbow": "e"}, time="t")
    np.testing.assert_allclose(made.series["gearbox_states"].position[:, 0], 2 * t)
    assert made.joints == ("elbow",)
    with pytest.raises(RecordingError, match="no column 'x'"):
        Recording.from_pandas(table, motor="m", joint="x", time="t")
    table.index = pandas.date_range("2026-01-01", periods=10, freq="100ms")
    dated = Recording.from_pandas(table, motor="m", joint="e")
    np.testing.assert_allclose(dated.series["joint_states"].stamp, t)


def test_a_data_set_of_xarray_is_a_recording() -> None:
    xarray = pytest.importorskip("xarray")
    t, values = np.arange(10) / 10.0, np.arange(20.0).reshape(2, 10)
    data = xarray.Dataset(
        {"motor": (("name", "time"), values), "joint": (("name", "time"), values / 2)},
        coords={"time": t, "name": ["shoulder", "elbow"]},
    )
    made = Recording.from_xarray(data)
    assert made.joints == ("shoulder", "elbow")
    np.testing.assert_allclose(made.series["joint_states"].position, values.T / 2)
