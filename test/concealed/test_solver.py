"""Claims about the process that diagnoses: what it cannot open, and that it has the answer nowhere."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from test.concealed import solver
from test.concealed.case import draw_case
from test.concealed.protocol import Concealed, conceal
from test.concealed.solver import ForbiddenError


@pytest.fixture
def walls(tmp_path: Path) -> solver._Walls:
    """All of a folder is shut but for one bag and one place to write."""
    for name in ("sealed", "open/run_1", "open/run_2", "answers"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "file").write_text("x")
    return solver._Walls(tmp_path, (tmp_path / "open" / "run_1", tmp_path / "answers"))


@pytest.mark.parametrize("form", [str, Path, os.fsencode])
@pytest.mark.parametrize("name", ["sealed/file", "open/run_2/file", "open/run_1/../../sealed/file"])
def test_the_answer_and_the_second_run_are_closed_to_a_diagnosis(
    walls: solver._Walls, tmp_path: Path, name: str, form: Any
) -> None:
    with pytest.raises(ForbiddenError):
        walls.check("open", (form(str(tmp_path / name)), "r", 0))


def test_a_link_to_the_answer_is_closed_as_well(walls: solver._Walls, tmp_path: Path) -> None:
    link = tmp_path / "answers" / "link"
    link.symlink_to(tmp_path / "sealed" / "file")
    with pytest.raises(ForbiddenError):
        walls.check("open", (str(link), "r", 0))


def test_its_own_recording_and_output_are_open(walls: solver._Walls, tmp_path: Path) -> None:
    walls.check("open", (str(tmp_path / "open" / "run_1" / "file"), "r", 0))
    walls.check("open", (str(tmp_path / "answers" / "new"), "w", 0))
    walls.check("open", (3, "r", 0))
    with pytest.raises(ForbiddenError):
        walls.check("os.listdir", (str(tmp_path),))


@pytest.fixture(scope="module")
def where(tmp_path_factory: pytest.TempPathFactory) -> Concealed:
    """A short concealed case."""
    folder = tmp_path_factory.mktemp("proof")
    return conceal(draw_case(1, effects=["ratio_error"], seconds=15.0), folder / "open", folder / "sealed")


def test_the_other_process_diagnoses_and_is_refused_the_second_run(where: Concealed) -> None:
    proof = where.folder.parents[1]
    (proof / "a").mkdir()
    said = solver.diagnosed(proof, where.folder / "run_1", proof / "a" / "out")
    assert not said.failed
    assert said.seconds > 0
    assert (proof / "a" / "out" / "diagnosis.json").exists()
    again = solver.diagnosed(proof, where.folder / "run_1", proof / "a" / "out")
    assert "exists" in again.failed


def test_a_recording_that_leads_to_the_second_run_is_refused(where: Concealed) -> None:
    proof, run_3 = where.folder.parents[1], where.folder / "run_3"
    for folder in (run_3, proof / "b"):
        folder.mkdir()
    for file in (where.folder / "run_2").iterdir():
        (run_3 / file.name).symlink_to(file)
    said = solver.diagnosed(proof, run_3, proof / "b" / "out")
    assert "opened during the diagnosis" in said.failed
