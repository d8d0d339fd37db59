"""How far a sensor's zero is off tells nothing of the arm: all else that is said stays as it is."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, of_the_wires, on, recorded, reshaped
from trunk_ros.diagnosis.verdict.result import Diagnosis

WORN = {
    "backlash": {"half_width": on(2, 2e-3, 3)},
    "viscoelastic_creep": {"gain": on(3, 0.04, 3), "time_constant": 2.0 * np.ones(3)},
}


@cache
def found(zero: float) -> Diagnosis:
    """Of a worn arm, all of whose sensors read ``zero`` rad too much."""
    made = of_the_wires(recorded(WORN, nominal=SHORT))
    position = made.series["joint_states"].position + zero
    return diagnose([reshaped(made, "joint_states", position=position)], model=SHORT)


def said(told: Diagnosis) -> dict[str, dict[str, dict[str, float]]]:
    """Values by effect and joint, of all but zeros."""
    others = [finding for finding in told.findings if finding.effect != "zero_offset"]
    return {
        one.effect: {
            owner: {name: told["value"] for name, told in values.items()}
            for owner, values in one.parameters.items()
        }
        for one in others
    }


@pytest.mark.parametrize("zero", [0.02, 0.37, -3.0])
def test_a_constant_in_all_readings_changes_nothing_but_the_zero(zero: float) -> None:
    right, off = found(0.0), found(zero)
    assert said(right).keys() == WORN.keys()
    assert said(off).keys() == WORN.keys()
    for effect, joints in said(right).items():
        for joint, values in joints.items():
            assert said(off)[effect][joint] == pytest.approx(values, rel=1e-2)
    for joint, judged in right.stages["wire"]["joints"].items():
        error = off.stages["wire"]["joints"][joint]["rmse_after"]
        assert error == pytest.approx(judged["rmse_after"], rel=1e-2)


@pytest.mark.parametrize("zero", [0.37, -3.0])
def test_the_zero_of_each_joint_is_found_however_large(zero: float) -> None:
    (told,) = (finding for finding in found(zero).findings if finding.effect == "zero_offset")
    offsets = {joint: values["offset"]["value"] for joint, values in told.parameters.items()}
    assert offsets == {joint: pytest.approx(zero, abs=1e-3) for joint in SHORT.arm.joints}
