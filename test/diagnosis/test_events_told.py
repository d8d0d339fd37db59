"""Of which moments a report tells."""

from __future__ import annotations

import pytest

from trunk_ros.diagnosis.verdict.events import events
from trunk_ros.diagnosis.verdict.finding import Finding, evidence_of


@pytest.mark.parametrize(("std", "told"), [(0.005, 0), (1e-4, 1)])
def test_a_load_that_may_weigh_nothing_is_not_told_to_be_taken_up(std: float, told: int) -> None:
    """A page had told that 4 ± 5 g are carried for a second, of an arm that carried nothing."""
    moments = {"payload_from": 48.85, "payload_until": 49.83}
    arm = {name: {"value": at, "std": 0.1, "unit": "s"} for name, at in moments.items()}
    arm["payload"] = {"value": 0.004, "std": std, "unit": "kg"}
    stiffening = Finding(
        effect="wire_stiffening",
        stage="wire",
        joints=["joint_1"],
        regime="posture",
        confidence=0.95,
        equivalents=[],
        parameters={"arm": arm},
        depends_on=["load"],
        statement="",
        evidence=evidence_of(),
    )
    assert len(events([stiffening])) == told
