"""What drives do to their setpoints, or do not get done, is told by its name, and holds on another motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, of_joints, reshaped
from test.diagnosis.test_described_otherwise import _moved
from test.diagnosis.test_nominal_servo import PLAIN, _left, _stated, recorded_servos
from trunk_ros.recording.recording import Recording


def limited(effects: dict[str, Any], seed: int, **servo: float) -> Recording:
    run = recorded_servos(PLAIN, seed, after=0.0, seconds=15.0)
    moved = _moved(run, replace(_stated(**servo), effects=effects))
    return replace(run, series=run.series | {"gearbox_states": moved})


@pytest.mark.parametrize(
    ("name", "values", "at"),
    [
        ("setpoint_ceiling", {"upper": np.array([1e4, 0.2, 1e4])}, "elbow"),
        ("setpoint_floor", {"lower": np.array([-0.15, -1e4, -1e4])}, "shoulder"),
        pytest.param("acceleration_limit", {"acceleration": 6.0}, "arm", marks=pytest.mark.long),
        pytest.param("setpoint_profile", {"acceleration": 4.0}, "arm", marks=pytest.mark.long),
        ("motor_friction", {"friction": 0.003}, "arm"),
    ],
)
def test_it_is_told_by_its_name(name: str, values: dict[str, Any], at: str) -> None:
    found = diagnose(limited({name: values}, 1), model=_stated())
    (finding,) = found.findings
    assert (finding.effect, found.verdict) == (name, "explained")
    (lead,) = values
    size = values[lead] if np.ndim(values[lead]) == 0 else values[lead][np.abs(values[lead]) < 1e3][0]
    assert finding.parameters[at][lead]["value"] == pytest.approx(size, rel=0.02)
    assert _left(found.model, limited({name: values}, 2)).max() < 3e-4


def test_a_servo_of_which_nothing_is_said_is_found_beside_its_limit() -> None:
    """Its loop had been one that nothing does, with what was left unknown."""
    upper = {"setpoint_ceiling": {"upper": np.array([1e4, 0.2, 1e4])}}
    found = diagnose(limited(upper, 1), model="direct")
    (finding,) = found.findings
    assert (finding.effect, found.verdict) == ("setpoint_ceiling", "explained")
    assert found.model.number("kp") == pytest.approx(20.0, rel=0.05)
    assert _left(found.model, limited(upper, 2)).max() < 5e-4


@pytest.mark.parametrize("late", [0.006, 0.02])
def test_stamps_of_setpoints_that_are_late_are_a_delay_below_nothing(late: float) -> None:
    """They had been a feedforward beside another gain."""
    run = of_joints(recorded_servos(PLAIN, 1, after=0.0, seconds=15.0), "shoulder", "elbow")
    stamped = reshaped(run, "setpoints", stamp=run.series["setpoints"].stamp + late)
    found = diagnose(stamped, model=_stated())
    (finding,) = found.findings
    assert (finding.effect, found.verdict) == ("servo_delay", "explained")
    assert finding.parameters["arm"]["delay"]["value"] == pytest.approx(-late, abs=5e-4)
