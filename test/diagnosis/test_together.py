"""What is said of all stages together goes by what the model tells of the arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.diagnosis.verdict.finding import UNKNOWN, Finding, evidence_of
from trunk_ros.diagnosis.verdict.together import together
from trunk_ros.model import load_model

ARM = load_model("trunk").arm


def of(effect: str, stage: str) -> Finding:
    return Finding(effect, stage, ["joint_2"], "posture", 0.9, [], {}, [], "joint_2: so.", evidence_of())


def test_what_says_other_entries_of_the_coupling_says_so_where_it_is_told() -> None:
    found = [
        of("joint_coupling", "wire"),
        of("backlash", "wire"),
        of(UNKNOWN, "wire"),
        of("cogging", "servo"),
    ]
    coupled = replace(ARM, coupling=np.diag(ARM.ratio))
    said = together(found, coupled)
    assert [f.effect for f in said] == ["cogging", "joint_coupling", "backlash", UNKNOWN]
    assert said[1].statement.startswith("joint_2: so. The model tells by wire.coupling what moves joint_2")
    assert [f.statement for f in said if f is not said[1]] == ["joint_2: so."] * 3
    assert [f.statement for f in together(found, ARM)] == ["joint_2: so."] * 4
