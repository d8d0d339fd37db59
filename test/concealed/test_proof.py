"""Claims about the proof's seeds, numbers and files, with marks made up."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from test.concealed import codes, judge, proof
from test.concealed.evidence import evidence
from test.concealed.intervals import bootstrap, wilson
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


def test_the_files_say_every_number_with_its_interval(tmp_path: Path) -> None:
    table = proof.write(
        [_marks("a"), _marks("b", **MISSED), {"name": "c", "kind": "hard", "not_drawn": "x"}], tmp_path
    )
    assert "0.50 (0.09 … 0.91)" in table
    kept = json.loads((tmp_path / "results.json").read_text())
    assert set(kept["all"]["recall"]) == {"value", "low", "high", "n"}
    assert len(list(tmp_path.glob("proof-*.png"))) == 5


def test_a_case_is_not_done_twice_unless_the_code_changed(tmp_path: Path) -> None:
    task = judge.Task("singles", 50_000, tmp_path)
    task.kept.parent.mkdir()
    task.kept.write_text(json.dumps(_marks("singles_50000", code=codes.marks_code())))
    assert len(proof.prove([task], 1, 0.0, Console(quiet=True))) == 1
    task.kept.write_text(json.dumps(_marks("singles_50000", code="other")))
    assert judge.known_marks(task) is None
