"""Claims about the arms of the live graph, without the graph."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.concealed import live_proof
from test.concealed.demo_runs import DemoError
from test.concealed.hide import hide
from test.concealed.live_proof import drawn_effects, off, tried
from test.concealed.seeds import CLEAN, CONCEALED, LIVE, LIVE_MANY


def test_at_least_ten_arms_hide_three_effects_each_that_a_live_arm_can_have() -> None:
    assert len(LIVE) >= 10
    assert not set(LIVE) & {seed for some in {**CONCEALED, **CLEAN}.values() for seed in some}
    names = [drawn_effects(seed) for seed in LIVE]
    assert len({name for some in names for name in some}) > 6
    assert len(hide(41_003, drawn_effects(41_003))) == 3


def test_others_hide_five_to_eight_that_go_together() -> None:
    assert not set(LIVE_MANY) & set(LIVE)
    counts = [len(hide(seed, drawn_effects(seed))) for seed in LIVE_MANY]
    assert min(counts) >= 5
    assert max(counts) <= 8
    assert len(set(counts)) > 1


def test_the_tip_is_off_by_the_way_between_where_it_is_and_where_it_should_be() -> None:
    wanted, true = np.zeros((3, 5)), np.zeros((3, 5))
    true[:, 0] = 1e-3
    assert off(wanted, true)["tip"] == pytest.approx(0.25e-3, rel=1e-3)
    assert off(wanted, true)["joints"] == pytest.approx(1e-3 / np.sqrt(5))


def test_an_arm_is_not_run_twice_and_one_that_failed_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ran: list[int] = []

    def fails(seed: int, folder: Path, seconds: float) -> dict[str, Any]:
        ran.append(seed)
        raise DemoError("bringup ended with 1: no word")

    def works(seed: int, folder: Path, seconds: float) -> dict[str, Any]:
        ran.append(seed)
        return {"effects": ["backlash"]}

    monkeypatch.setattr(live_proof, "_tried", fails)
    assert tried(5, tmp_path)["failed"].startswith("bringup")
    monkeypatch.setattr(live_proof, "_tried", works)
    assert [tried(5, tmp_path)["effects"] for _ in range(2)] == [["backlash"]] * 2
    assert ran == [5, 5]
    assert not (tmp_path / "live" / "arm_5").exists()
    assert json.loads((tmp_path / "live" / "arm_5.json").read_text())["seed"] == 5
