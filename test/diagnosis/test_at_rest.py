"""Joints whose motors stand, while other joints, their load or time move them."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import NOISE, SHORT, of_the_wires
from trunk_ros.effects import registry
from trunk_ros.effects.effect import Motion

on = partial(arms.on, joints=3)
recorded = partial(arms.recorded, nominal=SHORT)
diagnose = partial(arms.diagnose, model=SHORT)
STANDS = np.array([1.0, 1.0, 0.0])
COUPLED: dict[str, Any] = {"joint_coupling": {"gain": on(3, 0.01), "source": ["", "", "joint_2"]}}


@pytest.mark.parametrize(
    ("effects", "found"),
    [
        (COUPLED, {"joint_coupling"}),
        ({"thermal_drift": {"amplitude": on(3, 4e-3), "time_constant": np.full(3, 8.0)}}, {"thermal_drift"}),
    ],
)
def test_what_moves_a_joint_whose_motor_stands_is_found(effects: dict[str, Any], found: set[str]) -> None:
    result = diagnose([of_the_wires(recorded(effects, size=STANDS))])
    assert {finding.effect for finding in result.findings} == found
    assert {joint for finding in result.findings for joint in finding.joints} == {"joint_3"}
    assert result.stages["wire"]["silent"] == []


def test_a_coupling_behind_a_wider_dead_band_is_one_whichever_of_the_two_has_the_play() -> None:
    """gain s through a play is a coupling whose wires drag each other back."""
    loose = COUPLED | {"backlash": {"half_width": on(3, 1e-3)}}
    result = diagnose([of_the_wires(recorded(loose, size=STANDS))])
    assert "joint_coupling" in {f.effect for f in result.findings} <= {"joint_coupling", "backlash"}
    joint = result.stages["wire"]["joints"]["joint_3"]
    assert joint["rmse_after"] == pytest.approx(NOISE, rel=0.1)


def test_noise_of_a_joint_whose_motor_stands_is_no_motion() -> None:
    result = diagnose([of_the_wires(recorded(size=STANDS))])
    assert (result.verdict, result.findings, result.unexplained) == ("no_mismatch", [], [])
    assert result.stages["wire"]["silent"] == ["joint_3"]


def test_a_joint_at_rest_shows_what_does_not_go_by_its_own_motion() -> None:
    rests = Motion(rests=True)
    shown = {name: kind.forms_shown(rests) for name, kind in registry().items() if kind.stage == "wire"}
    assert all(shown[name] for name in ("joint_coupling", "load_elasticity", "thermal_drift", "zero_offset"))
    assert not any(shown[name] for name in ("ratio_error", "transmission_ripple", "viscous_lag", "hard_stop"))
    assert shown["viscoelastic_creep"] == ("load",)


def test_a_joint_that_jumps_at_rest_by_less_than_its_noise_stays_without_a_verdict() -> None:
    quiet = of_the_wires(recorded(size=STANDS))
    position = quiet.series["joint_states"].position.copy()
    position[len(position) // 2 :, 2] += NOISE
    series = quiet.series | {"joint_states": replace(quiet.series["joint_states"], position=position)}
    assert diagnose([replace(quiet, series=series)]).stages["wire"]["silent"] == ["joint_3"]
