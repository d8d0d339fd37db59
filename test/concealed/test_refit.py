"""Claims about the refit of nominal parameters, the baseline of the proof."""

from __future__ import annotations

from pathlib import Path

from test.concealed.bag import write_bag
from test.concealed.case import draw_case
from test.concealed.refit import refit


def _errors(folder: Path, effect: str) -> tuple[dict[str, float], float]:
    case = draw_case(3, effects=[effect], seconds=20.0, level=(10.0, 12.0))
    for name, motion in (("a", case.train), ("b", case.test)):
        write_bag(motion, folder / name)
    noise = case.noise["noise"]
    return refit(folder / "a", folder / "b", case.test.theta_clean, noise), noise


def test_a_refit_finds_an_error_of_the_ratio(tmp_path: Path) -> None:
    found, _ = _errors(tmp_path, "ratio_error")
    assert found["after"] < 0.1 * found["before"]


def test_a_refit_cannot_take_in_a_coupling_of_joints(tmp_path: Path) -> None:
    found, _ = _errors(tmp_path, "joint_coupling")
    assert found["after"] > 0.2 * found["before"]
