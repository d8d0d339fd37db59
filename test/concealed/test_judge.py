"""Claims about judging a case: what is kept, what goes, what is not done twice."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from test.concealed import judge, others
from test.concealed.case import draw_case
from test.concealed.codes import ROOT
from test.concealed.solver import Said

OTHERS = {"refit": {"before": 1e-3, "after": 1e-3, "fitted_before": 1e-3, "fitted_after": 1e-3}}
CASE = draw_case(1, effects=["ratio_error"], seconds=10.0)


@pytest.fixture
def diagnoses(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Bags that were diagnosed, by a stand-in which names the effect and models nothing."""
    bags: list[Path] = []

    def diagnosed(shut: Path, bag: Path, out: Path) -> Said:
        bags.append(bag)
        out.mkdir()
        found = {**CASE.truth[0], "confidence": 1.0, "equivalents": [], "parameters": {}}
        (out / "diagnosis.json").write_text(json.dumps({"verdict": "explained", "findings": [found]}))
        shutil.copy(ROOT / "config" / "trunk.yaml", out / "model.yaml")
        return Said(1.5)

    def compared(*_: Any) -> dict[str, Any]:
        return OTHERS

    monkeypatch.setattr(judge, "drawn", lambda kind, seed: CASE)
    monkeypatch.setattr(judge, "diagnosed", diagnosed)
    monkeypatch.setattr(others, "compared", compared)
    return bags


def test_a_case_leaves_its_marks_and_nothing_else(diagnoses: list[Path], tmp_path: Path) -> None:
    task = judge.Task("singles", 1, tmp_path)
    marks = judge.judged(task)
    assert [hit["effect"] for hit in marks["hits"]] == ["ratio_error"]
    assert marks["after"] == pytest.approx(marks["before"])
    assert marks["seconds"] == 1.5
    assert marks["others"] == OTHERS
    assert judge.known_marks(task) == marks
    left = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {"singles_1.json"}


def test_missing_comparisons_do_not_call_for_another_diagnosis(diagnoses: list[Path], tmp_path: Path) -> None:
    task = judge.Task("singles", 1, tmp_path)
    first = judge.judged(task)
    task.others.unlink()
    assert judge.known_marks(task) is None
    assert judge.judged(task) == first
    assert len(diagnoses) == 1


def test_changed_code_of_the_diagnosis_keeps_the_comparisons(
    diagnoses: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = judge.Task("singles", 1, tmp_path)
    judge.judged(task)
    monkeypatch.setattr(judge, "marks_code", lambda: "newer")
    monkeypatch.setattr(others, "compared", None)
    assert judge.judged(task)["others"] == OTHERS
    assert len(diagnoses) == 2


def test_a_diagnosis_that_fails_has_found_nothing(
    diagnoses: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(judge, "diagnosed", lambda *_: Said(0.0, "ended with 1"))
    task = judge.Task("singles", 1, tmp_path)
    marks = judge.judged(task)
    assert [name for name, _ in marks["missed"]] == ["ratio_error"]
    assert marks["failed"] == "ended with 1"
    assert judge.known_marks(task) is None
