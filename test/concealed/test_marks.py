"""Claims about the marks: what is a hit, what is a miss, how joints and parameters count."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from test.concealed.marks import joints_iou, marked, z_scores
from test.concealed.summary import as_text, summed_up

Entry = dict[str, Any]


def _truth(effect: str = "backlash", joints: tuple[str, ...] = ("joint_2",), **more: Any) -> Entry:
    return {"effect": effect, "stage": "wire", "regime": "reversal", "joints": list(joints), "known": True,
            "parameters": {}, "same": [], "depends_on": "", "strength": 3.0, **more}  # fmt: skip


def _finding(effect: str = "backlash", joints: tuple[str, ...] = ("joint_2",), **more: Any) -> Entry:
    return {"effect": effect, "stage": "wire", "regime": "reversal", "joints": list(joints),
            "confidence": 0.9, "equivalents": [], "parameters": {}, **more}  # fmt: skip


def _marks(truth: list[Entry], findings: list[Entry]) -> Entry:
    return marked(truth, {"verdict": "explained", "findings": findings})


def test_the_right_name_is_a_hit() -> None:
    marks = _marks([_truth()], [_finding()])
    assert (len(marks["hits"]), marks["missed"], marks["false"]) == (1, [], [])


@pytest.mark.parametrize(("place", "hits"), [(0, 1), (1, 1), (2, 0)])
def test_only_the_first_two_equivalents_count(place: int, hits: int) -> None:
    others = ["ratio_error", "zero_offset", "wire_slip"]
    others[place] = "backlash"
    assert len(_marks([_truth()], [_finding("tension_error", equivalents=others)])["hits"]) == hits


def test_an_extra_finding_is_a_miss_of_its_own() -> None:
    marks = _marks([_truth()], [_finding(), _finding("zero_offset")])
    assert marks["false"] == ["zero_offset"]
    assert marks["confidence"] == [[0.9, True], [0.9, False]]


def test_one_finding_serves_one_truth_only() -> None:
    both = [_truth(), _truth("tension_error")]
    marks = _marks(both, [_finding("backlash", equivalents=["tension_error"])])
    assert marks["missed"] == [["tension_error", 3.0]]


def test_strange_physics_wants_unknown_at_its_stage_and_joint() -> None:
    strange = _truth("x_bump", known=False, depends_on="position")
    assert _marks([strange], [_finding("unknown", depends_on=["position"])])["hits"][0]["depends_on"]
    assert not _marks([strange], [_finding("unknown", joints=("joint_4",))])["hits"]
    assert not _marks([strange], [_finding("unknown", stage="servo")])["hits"]
    assert not _marks([strange], [_finding("ratio_error")])["hits"]


def test_joints_count_by_intersection_over_union() -> None:
    assert joints_iou(_truth(joints=("joint_1", "joint_2")), _finding()) == 0.5
    assert joints_iou(_truth(joints=()), _finding(joints=())) == 1.0


def test_a_phase_is_compared_around_the_circle() -> None:
    truth = _truth(parameters={"joint_2": {"phase": 3.1}}, same=["phase"])
    said = _finding(parameters={"joint_2": {"phase": {"value": -3.1, "std": 0.1}}})
    assert abs(z_scores(truth, said)["joint_2.phase"]) < 1.0


def test_parameters_of_another_form_are_not_compared() -> None:
    truth = _truth(parameters={"joint_2": {"width": 1.0}}, same=[])
    said = _finding(parameters={"joint_2": {"width": {"value": 9.0, "std": 0.1}}})
    assert z_scores(truth, said) == {}


def test_the_moment_of_a_jump_is_told_apart() -> None:
    truth = _truth("wire_slip", parameters={"joint_2": {"onset": 20.0, "step": 1e-3}})
    said = _finding("wire_slip", parameters={"joint_2": {"onset": {"value": 20.3, "std": 0.1}}})
    assert _marks([truth], [said])["hits"][0]["onset_error"] == pytest.approx(0.3)


def test_the_summary_counts_clean_arms_apart() -> None:
    about = {"known": True, "noise": 1e-4, "seconds": 1.0}
    hit = {
        "name": "a",
        "count": 1,
        **about,
        **_marks([_truth()], [_finding()]),
        "before": 1e-3,
        "after": 1e-5,
    }
    alarm = {"name": "b", "count": 0, **about, **_marks([], [_finding()]), "before": 9e-6, "after": 5e-5}
    total = summed_up([hit, alarm])
    assert total["all"]["f1"] == 1.0
    assert total["clean"]["alarms"] == [["b", "backlash"]]
    assert total["removed"]["median"] == pytest.approx(0.99)
    assert total["removed"]["made_worse"] == ["b"]
    assert "backlash" in as_text(total)


def test_a_name_that_is_no_lie_there_is_neither_owed_nor_false() -> None:
    said = {"verdict": "explained", "findings": [_finding("sensor_delay"), _finding("backlash")]}
    marks = marked([], said, allowed=["sensor_delay"])
    assert marks["false"] == ["backlash"]
    assert marks["confidence"] == [[0.9, False]]
    owed = marked([_truth("sensor_delay")], said, allowed=["sensor_delay"])
    assert [hit["effect"] for hit in owed["hits"]] == ["sensor_delay"]


@pytest.mark.parametrize(("events", "error"), [([{"effect": "backlash", "from": 21.5}], 1.5), ([], np.inf)])
def test_an_event_is_marked_by_when_it_is_said_to_begin(events: list[Entry], error: float) -> None:
    said = {"verdict": "explained", "findings": [_finding()], "events": events}
    (hit,) = marked([_truth(extra={"from": 20.0})], said)["hits"]
    assert hit["event_error"] == error
    (hit,) = marked([_truth()], said)["hits"]
    assert hit["event_error"] is None


def test_what_the_description_states_exactly_was_not_found() -> None:
    truth = {"parameters": {"joint_1": {"compliance": 0.03}}, "same": ["compliance"]}
    said = {"parameters": {"joint_1": {"compliance": {"value": 0.03 * (1 + 1e-15), "std": 1e-3}}}}
    assert z_scores(truth, said) == {}
