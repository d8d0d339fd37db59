"""A velocity loop that is not the described one is told as such, and as nothing else."""

from __future__ import annotations

from dataclasses import replace

import pytest

from test.diagnosis.arms import diagnose
from test.diagnosis.test_nominal_servo import PLAIN, _stated, recorded_servos


@pytest.mark.parametrize("tau_v", [0.012, 0.03])
@pytest.mark.parametrize("kp", [20.0, 15.0])
def test_its_time_constant_is_told_beside_the_gain(kp: float, tau_v: float) -> None:
    servo = {"kp": (kp,) * 3, "tau_v": (tau_v,) * 3}
    found = diagnose(recorded_servos(PLAIN | servo, after=0.0), model=_stated())
    assert [finding.effect for finding in found.findings] == ["servo_bandwidth"]
    assert found.verdict == "explained"
    told = found.model.effects["servo_bandwidth"]
    assert told["velocity_loop"] == pytest.approx(tau_v / 0.02 - 1.0, abs=0.02)
    assert found.model.number("kp") == pytest.approx(kp, rel=0.01)
    assert found.model.number("tau_v") == pytest.approx(tau_v, rel=0.02)


def test_gains_of_each_joint_go_with_a_velocity_loop_of_all() -> None:
    servo = {"kp": (15.0, 20.0, 28.0), "tau_v": (0.028,) * 3}
    (found,) = diagnose(recorded_servos(PLAIN | servo, after=0.0), model=_stated()).findings
    assert (found.effect, found.evidence["form"]) == ("servo_bandwidth", "apart")
    for joint, value in {"shoulder": -0.25, "wrist": 0.4}.items():
        assert found.parameters[joint]["relative"]["value"] == pytest.approx(value, abs=0.01)


def test_a_gain_alone_has_the_described_velocity_loop() -> None:
    found = diagnose(recorded_servos(PLAIN | {"kp": (26.0,) * 3}, after=0.0), model=_stated())
    assert "velocity_loop" not in found.model.effects["servo_bandwidth"]


def test_one_that_the_model_has_already_is_no_finding() -> None:
    has = {"relative": 0.0, "velocity_loop": 0.5}
    model = replace(_stated(), effects={"servo_bandwidth": has})
    assert diagnose(recorded_servos(PLAIN | {"tau_v": (0.03,) * 3}, after=0.0), model=model).findings == []
