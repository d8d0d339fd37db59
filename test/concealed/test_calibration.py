"""Claims about the calibration of a confidence over plants that are left out, with findings made up."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from test.concealed.calibration import calibration_error, left_out, plant, said
from test.concealed.seeds import CLEAN, CONCEALED


def _cases(kind: str, confidence: float, right: float, n: int = 200) -> list[dict[str, Any]]:
    """``n`` findings at a confidence, of which a share is right."""
    return [{"kind": kind, "confidence": [[confidence, k < right * n]]} for k in range(n)]


def test_every_kind_of_the_proof_is_of_one_of_four_plants() -> None:
    assert {plant(kind) for kind in {**CONCEALED, **CLEAN}} == {"formula", "wire", "mujoco", "masses"}


def test_the_error_is_the_mean_distance_from_the_share_that_was_right() -> None:
    some = said(_cases("singles", 0.95, 0.85) + _cases("singles", 0.6, 0.6))
    assert calibration_error(some) == pytest.approx(0.05)


def test_findings_without_a_confidence_do_not_count() -> None:
    assert said([{"kind": "singles", "confidence": [[None, True], [0.9, True]]}]) == [(0.9, True)]


def test_a_plant_on_which_all_say_too_much_alike_is_put_right_by_the_others() -> None:
    too_sure = _cases("singles", 0.95, 0.8) + _cases("mujoco", 0.95, 0.8)
    for one in left_out(too_sure):
        assert one.off.value == pytest.approx(0.15)
        assert one.brier[1] < one.brier[0]
        assert one.brier[1] == pytest.approx(0.16, abs=2e-3)  # the least that 0.8 right can have


def test_what_is_calibrated_already_is_left_as_it_is() -> None:
    honest = [
        case
        for kind in ("singles", "wire", "masses")
        for c in np.linspace(0.55, 0.95, 5)
        for case in _cases(kind, float(c), float(c))
    ]
    for one in left_out(honest):
        assert one.error < 0.01
        assert one.brier[1] == pytest.approx(one.brier[0], abs=2e-3)


def test_a_plant_alone_has_no_others_to_learn_from() -> None:
    (one,) = left_out(_cases("singles", 0.9, 0.5))
    assert one.brier[0] == one.brier[1]
