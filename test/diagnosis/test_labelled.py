"""Labelled recordings of an independent simulation, where they lie beside the project."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from trunk_ros.diagnosis import diagnose

FOLDER = Path(__file__).parents[3] / "shared" / "concealed"
LABELS = {c["name"]: c for c in json.loads((FOLDER / "labels.json").read_text())} if FOLDER.is_dir() else {}

pytestmark = pytest.mark.skipif(not LABELS, reason="no labelled recordings here")


@pytest.mark.parametrize("name", sorted(LABELS))
def test_what_was_hidden_is_named_and_placed(name: str) -> None:
    result = diagnose([FOLDER / name / "train"])
    found = {(f.effect, f.stage, tuple(f.joints)) for f in result.findings}
    hidden = {
        (
            t["effect"] if LABELS[name]["known"] else "unknown",
            t["stage"],
            tuple(f"joint_{j}" for j in t["joints"]),
        )
        for t in LABELS[name]["truth"]
    }
    assert found == hidden
