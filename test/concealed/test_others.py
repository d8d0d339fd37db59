"""Claims about what people do instead of the tool: each can learn what it is made for, on the same split."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from test.concealed import others, others_tuning
from test.concealed.bag import write_bag
from test.concealed.case import Case, draw_case
from test.concealed.others import METHODS, compared
from test.concealed.seeds import CLEAN, CONCEALED

Compare = Callable[[str], Any]


def _written(folder: Path, case: Case) -> tuple[Path, Path]:
    runs = (folder / "a", folder / "b")
    for run, motion in zip(runs, (case.train, case.test), strict=True):
        write_bag(motion, run)
    return runs


@pytest.fixture
def results(tmp_path: Path) -> Compare:
    """What the methods make of a strong effect."""

    def of(effect: str) -> Any:
        case = draw_case(3, effects=[effect], seconds=15.0, level=(10.0, 12.0))
        source = "setpoints" if case.truth[0]["stage"] == "servo" else "gearbox_states"
        runs = _written(tmp_path, case)
        return compared(runs, source, case.test.theta_clean, case.noise["noise"])

    return of


def test_all_learn_the_fitted_run_and_a_refit_of_the_ratio_holds_on_the_next(results: Compare) -> None:
    found = results("ratio_error")
    assert set(found) == set(METHODS)
    assert all(one["fitted_after"] < 0.5 * one["fitted_before"] for one in found.values())
    assert found["refit"]["after"] < 0.1 * found["refit"]["before"]


def test_a_refit_that_takes_in_a_coupling_of_joints_looks_good_on_the_fitted_run_alone(
    results: Compare,
) -> None:
    found = results("joint_coupling")["refit"]
    assert found["fitted_after"] < 0.2 * found["fitted_before"]
    assert found["after"] > 0.4 * found["before"]


def test_a_refit_of_the_servo_finds_its_gain(results: Compare) -> None:
    found = results("servo_bandwidth")["refit"]
    assert found["after"] < 0.1 * found["before"]


def test_settings_were_tuned_on_seeds_that_the_proof_never_draws() -> None:
    tuned = range(others_tuning.FIRST, others_tuning.FIRST + 1000)
    assert all(seed not in tuned for some in {**CONCEALED, **CLEAN}.values() for seed in some)


def test_results_of_other_code_are_not_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = tmp_path / "others" / "x.json"
    assert others.known(kept) is None
    others.keep(kept, {"refit": {"after": 1.0}})
    assert others.known(kept) == {"refit": {"after": 1.0}}
    monkeypatch.setattr(others, "others_code", lambda: "other")
    assert others.known(kept) is None
