"""Arms in space that an engine moves: what looks the same is one cause, and is said."""

from __future__ import annotations

import pytest

from test.concealed.space_case import SpaceCase, draw_case
from test.space_proof import told
from trunk_ros.diagnosis.verdict.finding import Finding


def findings(seed: int) -> tuple[SpaceCase, list[Finding]]:
    case = draw_case(seed)
    return case, told(case).findings


@pytest.mark.parametrize("seed", [60, 64, 181])
def test_a_tool_that_sits_askew_is_one_cause(seed: int) -> None:
    case, found = findings(seed)
    assert [hidden.effect for hidden in case.truth] == ["tool_offset"]
    assert [f.effect for f in found] == ["tool_offset"]


def test_friction_under_a_load_that_never_changes_may_be_any_dead_band() -> None:
    case, (found,) = findings(40)
    assert [(hidden.effect, hidden.joints) for hidden in case.truth] == [
        ("load_dependent_friction", ("slide",))
    ]
    assert found.joints == ["slide"]
    assert {"backlash", "load_dependent_friction"} <= {found.effect, *map(str, found.equivalents)}
