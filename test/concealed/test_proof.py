"""Claims about the proof's seeds, numbers and files, with marks made up."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from test.concealed import codes, judge, others, proof
from test.concealed.codes import ROOT
from test.concealed.evidence import evidence
from test.concealed.evidence_others import WAYS
from test.concealed.intervals import bootstrap, wilson
from test.concealed.paper_case import Row
from test.concealed.proof_page import BEGIN, END, update_page, with_table
from test.concealed.proof_table import Beside
from test.concealed.seeds import CLEAN, CONCEALED, PART, in_turn


def _marks(name: str, **more: Any) -> dict[str, Any]:
    hit = {"effect": "backlash", "by": "backlash", "exact": True, "strength": 3.0, "iou": 1.0, "regime": True,
           "z": {"joint_1.half_width": 1.0}, "onset_error": None, "depends_on": None}  # fmt: skip
    usual = {"name": name, "kind": "singles", "seed": 1, "count": 1, "known": True, "effects": ["backlash"],
             "noise": 1e-4, "hits": [hit], "missed": [], "false": [], "confidence": [[0.9, True]],
             "before": 1e-3, "after": 1e-4, "seconds": 1.0}  # fmt: skip
    return {**usual, **more}


MISSED = {"hits": [], "missed": [["backlash", 0.7]], "false": ["ratio_error"], "after": 2e-3}
ALARM = {"kind": "clean", "count": 0, "effects": [], "hits": [], "false": ["zero_offset"], "before": 0.0}


def test_everything_is_at_least_500_concealed_and_300_clean_arms_with_seeds_of_their_own() -> None:
    seeds = [seed for some in {**CONCEALED, **CLEAN}.values() for seed in some]
    assert sum(map(len, CONCEALED.values())) >= 500
    assert sum(map(len, CLEAN.values())) >= 300
    assert len(set(seeds)) == len(seeds) == len(in_turn(True))


def test_the_part_is_the_beginning_of_everything_and_holds_every_kind() -> None:
    part = in_turn(False)
    assert part == in_turn(True)[:PART]
    assert {kind for kind, _ in part} == {*CONCEALED, *CLEAN}


def test_the_proof_may_be_of_some_kinds_only() -> None:
    assert set(in_turn(True, ("masses", "clean_masses"))) == {
        *(("masses", seed) for seed in CONCEALED["masses"]),
        *(("clean_masses", seed) for seed in CLEAN["clean_masses"]),
    }


def test_cases_that_a_version_has_seen_can_be_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked_for: list[str] = []

    def prove(tasks: list[judge.Task], *_: object) -> list[dict[str, Any]]:
        asked_for.extend(task.name for task in tasks)
        return []

    monkeypatch.setattr(proof, "prove", prove)
    assert proof.main(["--full", "--after", "3", "--cases", "2", "--output", str(tmp_path)]) == 1
    assert asked_for == [f"{kind}_{seed}" for kind, seed in in_turn(True)[3:5]]


def test_the_interval_of_a_proportion_is_wilsons() -> None:
    half = wilson(8, 10)
    assert (half.low, half.high) == pytest.approx((0.4902, 0.9433), abs=1e-4)
    assert wilson(0, 10).low == 0.0
    assert wilson(0, 0).n == 0


def test_the_interval_of_a_median_holds_it() -> None:
    some = list(np.random.default_rng(1).normal(size=50))
    median = bootstrap(some, lambda x: float(np.median(x)))
    assert median.low < median.value < median.high


def test_rates_alarms_and_removal_are_counted() -> None:
    found = evidence([_marks("a"), _marks("b"), _marks("c", **MISSED), _marks("d", **ALARM)])
    assert found["all"]["recall"].value == pytest.approx(2 / 3)
    assert found["all"]["precision"].value == pytest.approx(2 / 3)
    assert found["effects"]["ratio_error"]["precision"].value == 0.0
    assert found["false_alarms"]["all"].value == 1.0
    assert found["removed_worst"] == pytest.approx(-1.0)
    assert found["confusion"][("backlash", "ratio_error")] == 1


ARM = {"seed": 1, "effects": ["backlash"], "said": ["backlash"], "named": 1,
       "before": {"joints": 2e-3, "tip": 1e-3}, "after": {"joints": 1e-4, "tip": 1e-4}}  # fmt: skip
ROW = Row("k / %", (96.0,), 0.1, 1e-5, "mu1 = 0.03")


def _others(after: float) -> dict[str, Any]:
    errors = {"fitted_before": 1e-3, "fitted_after": 1e-5, "before": 1e-3, "after": after, "seconds": 1.0}
    return {way: dict(errors) for way in WAYS if way != "diagnosis"}


def test_a_fit_that_only_looks_good_is_seen_as_such() -> None:
    trap = [_marks(name, others=_others(2e-3), fitted_before=1e-3, fitted_after=1e-4) for name in "abc"]
    found = evidence([*trap, _marks("d")])
    assert found["others"]["boosting"]["fitted"].value == pytest.approx(0.99)
    assert found["others"]["boosting"]["other"].value == pytest.approx(-1.0)
    assert found["others"]["boosting"]["worse"].value == 1.0
    assert found["others"]["diagnosis"]["other"].value == pytest.approx(0.9)
    assert found["others"]["diagnosis"]["other"].n == 3
    assert found["beaten"]["echo"].value == 1.0


def test_a_run_without_anything_to_remove_does_not_count() -> None:
    found = evidence([_marks("a", others=_others(1e-4), fitted_before=0.0, fitted_after=0.0)])
    assert found["others"]["diagnosis"]["fitted"].n == 0
    assert found["others"]["diagnosis"]["other"].n == 1


def test_a_comparison_that_failed_has_removed_nothing() -> None:
    others = {**_others(1e-4), "sindy": {"fitted_before": 1e-3, "before": 1e-3, "failed": "singular"}}
    found = evidence([_marks("a", others=others)])
    assert found["others"]["sindy"]["other"].value == 0.0
    assert found["others"]["echo"]["other"].value == pytest.approx(0.9)


CHAOS = {
    "seconds": 60.0, "done": {"killed": 2}, "hostile_messages": 9, "fastest_over_limit": 0.99,
    "not_finite": [], "ended_by_themselves": [], "broken_bags": [], "reasons": {"recorder": "disk full"},
}  # fmt: skip


def test_the_files_say_every_number_with_its_interval(tmp_path: Path) -> None:
    cases = [_marks("a", others=_others(2e-3)), _marks("b", **MISSED)]
    table = proof.write(
        [*cases, {"name": "c", "kind": "hard", "not_drawn": "x"}], tmp_path, Beside([ARM], [ROW], None, CHAOS)
    )
    assert "(2 times killed) among 9 hostile messages" in table
    assert "most 0.9900 times as fast as the servo's limit; recorder is not back: disk full" in table
    assert "0.50 (0.09 … 0.91)" in table
    assert "| k / % | 10.0 % | 0.001 % | mu1 = 0.03 |" in table
    assert "2.00 → 0.100" in table
    kept = json.loads((tmp_path / "results.json").read_text())
    assert set(kept["all"]["recall"]) == {"value", "low", "high", "n"}
    assert kept["live"]["arms made worse"]["value"] == 0.0
    assert len(list(tmp_path.glob("proof-*.png"))) == 7


def test_the_page_gets_the_table_between_its_marks_and_nothing_else(tmp_path: Path) -> None:
    docs, kept = tmp_path / "docs", tmp_path / "proof"
    (docs / "figures").mkdir(parents=True)
    kept.mkdir()
    (docs / "PROOF.md").write_text(f"before\n{BEGIN}\nold\n{END}\nafter")
    (kept / "table.md").write_text("new")
    (kept / "proof-a.png").write_bytes(b"x")
    update_page(kept, docs)
    assert (docs / "PROOF.md").read_text() == f"before\n{BEGIN}\n\nnew\n\n{END}\nafter"
    assert (docs / "figures" / "proof-a.png").exists()
    with pytest.raises(ValueError, match="no place"):
        with_table("no marks", "new")


def test_docs_have_a_place_for_the_table() -> None:
    with_table((ROOT / "docs" / "PROOF.md").read_text(), "x")


def test_a_case_is_not_done_twice_unless_the_code_changed(tmp_path: Path) -> None:
    task = judge.Task("singles", 50_000, tmp_path)
    task.kept.parent.mkdir()
    task.kept.write_text(json.dumps(_marks("singles_50000", code=codes.marks_code(), source=None)))
    assert len(proof.prove([task], 1, 0.0, Console(quiet=True))) == 1
    task.kept.write_text(json.dumps(_marks("singles_50000", code="other")))
    assert judge.known_marks(task) is None


def test_a_case_is_done_again_where_only_the_comparisons_are_missing(tmp_path: Path) -> None:
    task = judge.Task("singles", 50_001, tmp_path)
    task.kept.parent.mkdir()
    marks = _marks("singles_50001", code=codes.marks_code(), source="gearbox_states")
    task.kept.write_text(json.dumps(marks))
    assert judge.known_marks(task) is None
    others.keep(task.others, _others(1e-4))
    assert judge.known_marks(task) == {**marks, "others": _others(1e-4)}


def test_marks_of_two_states_of_the_code_are_not_mixed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = judge.Task("singles", 50_002, tmp_path)
    changed = [_marks(task.name, code="newer")]
    monkeypatch.setattr(proof, "_running", lambda todo, workers, deadline: iter(changed))
    with pytest.raises(proof.ProofError, match="code changed"):
        proof.prove([task], 1, 1.0, Console(quiet=True))
