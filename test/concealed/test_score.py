"""Claims about scoring a folder of cases, with a stand-in for the diagnosis."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test.concealed import score
from test.concealed.bag import write_bag
from test.concealed.case import Case, draw_case
from test.concealed.generate import write_case
from test.concealed.removed import nominal_angle, read_angles, servo_angles


def _answers(case: Case, job: score.Job, arguments: list[str]) -> None:
    """Diagnoses by the answer, and simulates by the noise-free angle."""
    out = Path(arguments[arguments.index("--output") + 1])
    if arguments[0] == "diagnose":
        said = {
            "confidence": 1.0,
            "equivalents": [],
            "parameters": {},
            "depends_on": [],
            "statement": "It is so.",
        }
        keys = ("effect", "stage", "joints", "regime")
        found = [{key: one[key] for key in keys} | said | {"evidence": {}, "curve": {}} for one in case.truth]
        out.mkdir()
        told = {
            "schema": "trunk_ros/diagnosis/1", "verdict": "explained", "findings": found,
            "stages": {}, "unexplained": [], "experiments": [], "quality": {},
        }  # fmt: skip
        (out / "diagnosis.json").write_text(json.dumps(told))
    else:
        topics = {"joint_states": {**case.test.topics["joint_states"], "position": case.test.theta_clean}}
        write_bag(replace(case.test, topics=topics), out)


def test_a_perfect_answer_removes_everything_and_is_not_asked_for_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = draw_case(1, effects=["ratio_error"], seconds=15.0)
    write_case(case, tmp_path / "case_0001")
    asked: list[str] = []

    def answer(job: score.Job, arguments: list[str]) -> None:
        asked.append(arguments[0])
        _answers(case, job, arguments)

    monkeypatch.setattr(score, "_command", answer)
    for _ in range(2):
        assert score.main([str(tmp_path), "--workers", "1"]) == 0
    kept = json.loads((tmp_path / "results" / "last.json").read_text())
    assert asked == ["diagnose", "simulate"]
    assert kept["summary"]["all"]["f1"] == 1.0
    assert kept["summary"]["removed"]["worst"] == pytest.approx(1.0, abs=1e-6)


def test_a_diagnosis_that_fails_has_found_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_case(draw_case(1, effects=["backlash"], seconds=15.0), tmp_path / "case_0001")

    def fail(job: score.Job, arguments: list[str]) -> None:
        raise RuntimeError("ended with 1")

    monkeypatch.setattr(score, "_command", fail)
    marks = score.diagnosed(score.jobs(tmp_path, "x")[0])
    assert [name for name, _ in marks["missed"]] == ["backlash"]
    assert "ended with 1" in marks["failed"]


def test_the_nominal_arm_from_setpoints_is_exact_on_a_clean_arm(tmp_path: Path) -> None:
    case = draw_case(7, count=0, seconds=15.0)
    write_bag(case.test, tmp_path / "test")
    shown = read_angles(tmp_path / "test", "joint_states")
    nominal = nominal_angle(servo_angles(tmp_path / "test"), shown.stamp)
    np.testing.assert_allclose(nominal, case.test.theta_clean, atol=1e-9)
