"""Labelled recordings of an independent simulation, where they lie beside the project."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import pytest

from test.diagnosis.arms import diagnose, of_the_wires
from test.diagnosis.test_report import pictures
from trunk_ros.diagnosis.report import write
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.recording.read import read_recording

FOLDER = Path(__file__).parents[3] / "shared" / "concealed"
LABELS = {c["name"]: c for c in json.loads((FOLDER / "labels.json").read_text())} if FOLDER.is_dir() else {}
LATE = ("dev_01", "dev_16")  # what these hide shows in the rest

pytestmark = pytest.mark.skipif(not LABELS, reason="no labelled recordings here")


@cache
def diagnosed(name: str) -> Diagnosis:
    """What is found on a recording, of most in a part of it; of servos where they, or nothing, differ."""
    whole = read_recording(FOLDER / name / "train")
    seen = of_the_wires(whole) if {t["stage"] for t in LABELS[name]["truth"]} == {"wire"} else whole
    return diagnose([seen], until=None if name in LATE else "40%")


@pytest.mark.parametrize("name", sorted(LABELS))
def test_what_was_hidden_is_named_and_placed(name: str) -> None:
    found = {(f.effect, f.stage, tuple(f.joints)) for f in diagnosed(name).findings}
    hidden = {
        (
            t["effect"] if LABELS[name]["known"] else "unknown",
            t["stage"],
            tuple(f"joint_{j}" for j in t["joints"]),
        )
        for t in LABELS[name]["truth"]
    }
    assert found == hidden


def test_a_real_diagnosis_fills_the_page(tmp_path: Path) -> None:
    result = diagnosed("dev_two_0")
    write(result, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert len(pictures(page)) == 2 + len(result.findings)
    assert all(f.effect.replace("_", " ") in page for f in result.findings)
