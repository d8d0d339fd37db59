"""Drives with an integral part in one of their loops are told by that, and hold on another motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, of_joints
from test.diagnosis.test_drive_limits import limited
from test.diagnosis.test_nominal_servo import _left, _stated


@pytest.mark.parametrize("ki", [2.0, 15.0])
def test_an_integral_part_is_told_by_its_name(ki: float) -> None:
    """One of 15 had been a feedforward of 0.95 beside another gain and velocity loop. What one of 2 holds as
    a run begins shows for ten seconds.
    """
    hidden = {"integral_action": {"ki": ki}}
    found = diagnose(limited(hidden, 1), model=_stated())
    (finding,) = found.findings
    assert (finding.effect, found.verdict) == ("integral_action", "explained")
    assert finding.parameters["arm"]["ki"]["value"] == pytest.approx(ki, rel=0.01)
    assert _left(found.model, limited(hidden, 2)).max() < 6e-5


def test_one_drive_that_has_it_is_told_alone() -> None:
    hidden: dict[str, Any] = {"integral_action": {"form": "apart", "ki": np.array([0.0, 12.0, 0.0])}}
    found = diagnose(limited(hidden, 1), model=_stated())
    (finding,) = found.findings
    assert (finding.effect, finding.joints) == ("integral_action", ["elbow"])
    assert finding.parameters["elbow"]["ki"]["value"] == pytest.approx(12.0, rel=0.01)


@pytest.mark.parametrize("model", [_stated(v_max=0.8), "direct"])
def test_one_that_winds_up_is_told_by_that(model: Any) -> None:
    """It had been `unknown` beside a velocity loop, at 50 to 250 mrad on another motion."""
    winds = {"integral_action": {"ki": 15.0, "windup": 1e4}}
    run, other = (of_joints(limited(winds, seed, v_max=0.8), "shoulder", "elbow") for seed in (1, 2))
    found = diagnose(run, model=model)
    (finding,) = found.findings
    assert (finding.effect, found.verdict) == ("integral_action", "explained")
    assert finding.parameters["arm"]["windup"]["value"] > 10.0
    assert _left(found.model, other).max() < 6e-5


def test_an_offset_is_none_that_hardly_sums_up() -> None:
    hidden = {"servo_offset": {"offset": np.array([0.0, 0.01, 0.0])}}
    (finding,) = diagnose(limited(hidden, 1), model=_stated()).findings
    assert (finding.effect, finding.joints) == ("servo_offset", ["elbow"])


@pytest.mark.parametrize("model", [_stated(), "direct"])
def test_an_integral_part_of_the_velocity_loop_is_told_by_its_name(model: Any) -> None:
    """It had been a slower velocity loop, and half of it was left."""
    hidden = {"speed_integral": {"rate": 12.0}}
    run, other = (of_joints(limited(hidden, seed), "shoulder", "elbow") for seed in (1, 2))
    found = diagnose(run, model=model)
    (finding,) = found.findings
    assert (finding.effect, found.verdict) == ("speed_integral", "explained")
    assert finding.parameters["arm"]["rate"]["value"] == pytest.approx(12.0, rel=0.01)
    assert _left(found.model, other).max() < 6e-5
