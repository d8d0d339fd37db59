"""A motor's teeth are its own."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, of_the_servos, recorded
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term, hypothesis_of
from trunk_ros.diagnosis.search.descent import Desk
from trunk_ros.diagnosis.search.moves.member import MEMBER
from trunk_ros.diagnosis.verdict.result import Diagnosis

TEETH = {"cycles_per_rev": np.array([24.0, 24.0, 31.0]), "phase": np.array([0.0, 0.0, 1.0])}


def diagnosed(cogging: dict[str, Any]) -> Diagnosis:
    return diagnose([of_the_servos(recorded({"cogging": cogging}, 20.0, nominal=SHORT))], model=SHORT)


@pytest.mark.long
def test_motors_that_cog_each_in_its_own_way_leave_the_others_as_they_are() -> None:
    size = np.array([0.0, 2e-3, 1e-3])
    said = diagnosed({"amplitude": size, "form": "apart", **TEETH})
    (finding,) = said.findings
    assert (finding.effect, finding.joints) == ("cogging", ["joint_2", "joint_3"])
    values = said.model.effects["cogging"]
    assert values["amplitude"] == pytest.approx(size, rel=0.02, abs=0.0)
    assert values["cycles_per_rev"][1:] == pytest.approx(TEETH["cycles_per_rev"][1:], rel=1e-3)


@pytest.mark.long
def test_motors_that_cog_alike_share_their_size() -> None:
    said = diagnosed({"amplitude": 2e-3, "cycles_per_rev": 24.0, "phase": np.array([0.0, 0.5, 2.0])})
    (finding,) = said.findings
    assert (finding.evidence["form"], len(finding.joints)) == ("alike", 3)
    assert finding.parameters["arm"]["amplitude"]["value"] == pytest.approx(2e-3, rel=0.02)


@pytest.mark.parametrize(("form", "groups"), [("alike", 0), ("apart", 3)])
def test_a_joint_may_leave_only_what_it_has_a_size_of_its_own_of(form: str, groups: int) -> None:
    """A model says the size once for all who share it: who had left would still have it."""
    term = Term("cogging", form, own={column: {"phase": 0.0} for column in range(3)})
    best: Any = SimpleNamespace(
        hypothesis=Hypothesis(cogging=term), context=SimpleNamespace(columns=[0, 1, 2])
    )
    assert len(list(MEMBER.groups(best, Desk()))) == groups


def test_a_stated_size_that_joints_share_is_on_all_of_them_whatever_their_phases() -> None:
    stated = {"amplitude": 2e-3, "cycles_per_rev": 24.0, "phase": np.array([0.0, 0.5, 0.0])}
    assert hypothesis_of({"cogging": stated}, "servo", 3)["cogging"].columns == [0, 1, 2]
