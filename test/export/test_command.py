"""export: the command."""

from __future__ import annotations

from pathlib import Path

import pytest

from test.export.arms import URDF, model_of, pair
from trunk_ros.__main__ import main
from trunk_ros.export.reality import RealityLayer
from trunk_ros.model import save_model


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user's URDF and a model; what the simulator has of it already."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(URDF)
    save_model(
        model_of({"backlash": {"half_width": pair(4e-3, 1e-3)}, "sensor_delay": {"delay": 0.03}}),
        "model.yaml",
    )
    return tmp_path


def run(*more: str) -> int:
    """Export into the URDF."""
    return main(["export", "model.yaml", "--to", "urdf", "--into", "arm.urdf", "--output", "new.urdf", *more])


def test_what_the_format_cannot_say_is_listed_and_is_the_reality_layers(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run() == 0
    said = capsys.readouterr().out
    assert "backlash: half_width shoulder 0.004 rad, elbow 0.001 rad" in said
    assert "sensor_delay: delay 0.03 s" in said
    layer = RealityLayer("new.reality.yaml")
    assert layer.model.effects["backlash"]["half_width"] == pytest.approx([4e-3, 1e-3])
    assert (folder / "arm.urdf").read_text() == URDF
    assert run() == 2
    assert run("--overwrite") == 0


def test_what_the_simulator_has_is_found_beside_the_model(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_model(model_of({"backlash": {"half_width": pair(4e-3, 3e-3)}}), "simulation.yaml")
    assert run() == 0
    said = capsys.readouterr().out
    assert "what your simulator had already: simulation.yaml" in said
    assert "note: backlash: the simulator has more of it than the arm (elbow 0.002 rad)" in said
    assert set(RealityLayer("new.reality.yaml").model.effects) == {"sensor_delay"}


def test_what_is_read_is_not_written_over(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--overwrite", "--output", "./arm.urdf") == 2
    assert "would be written over what is read" in capsys.readouterr().err
    assert (folder / "arm.urdf").read_text() == URDF
    save_model(model_of({}), "simulation.yaml")
    before = (folder / "simulation.yaml").read_text()
    assert run("--overwrite", "--output", "simulation.yaml") == 2
    assert (folder / "simulation.yaml").read_text() == before


@pytest.mark.parametrize(
    ("model", "into", "said"),
    [("model.yaml", "nope.urdf", "no such file"), ("direct", "arm.urdf", "wants a model with joints")],
)
def test_bad_input_is_one_line(
    folder: Path, model: str, into: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", model, "--to", "urdf", "--into", into, "--output", "new.urdf"]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not (folder / "new.urdf").exists()
