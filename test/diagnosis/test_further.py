"""Drives of which nothing is said, that do what no first-order loop does: both are found."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, of_joints
from test.diagnosis.test_drive_limits import limited
from test.diagnosis.test_nominal_servo import NOISE, _left, _stated
from trunk_ros.diagnosis.servos.further import Further, Part, like_others
from trunk_ros.diagnosis.servos.nominal_servo import moved
from trunk_ros.diagnosis.servos.servo_loop import Loop
from trunk_ros.effects import effect


@pytest.mark.parametrize(
    ("effect", "parameter", "size"),
    [
        ("integral_action", "ki", 15.0),
        ("motor_friction", "friction", 0.004),
        pytest.param("acceleration_limit", "acceleration", 8.0, marks=pytest.mark.long),
        pytest.param("setpoint_profile", "acceleration", 6.0, marks=pytest.mark.long),
    ],
)
def test_a_loop_is_found_beside_what_its_drive_does_besides(effect: str, parameter: str, size: float) -> None:
    """Its numbers had made up for that, and another motion was off by 0.1 to 57 mrad."""
    run, other = (of_joints(limited({effect: {parameter: size}}, seed), "shoulder") for seed in (1, 2))
    found = diagnose(run, model="direct")
    (finding,) = found.findings
    assert (finding.effect, found.verdict) == (effect, "explained")
    (values,) = finding.parameters.values()
    assert values[parameter]["value"] == pytest.approx(size, rel=0.01)
    arm = found.model.arm
    assert [*arm.kp, *arm.tau_v] == pytest.approx([20.0, 0.02], rel=0.01)
    assert _left(found.model, other).max() < 1.1 * NOISE


def test_a_drive_that_feeds_its_loop_the_speed_of_its_profile_is_told_as_one() -> None:
    both = {"setpoint_profile": {"acceleration": 6.0}, "speed_feedforward": {"share": 0.7}}
    run, other = (of_joints(limited(both, seed), "shoulder") for seed in (1, 2))
    found = diagnose(run, model=_stated().only(("shoulder",)))
    assert ({f.effect for f in found.findings}, found.verdict) == (set(both), "explained")
    assert _left(found.model, other).max() < 1.1 * NOISE


@pytest.mark.long
def test_two_such_things_are_found_one_after_the_other() -> None:
    """The integral part had been 17 and friction 0.0038, at 0.6 mrad."""
    both = {"integral_action": {"ki": 15.0}, "motor_friction": {"friction": 0.004}}
    run, other = (of_joints(limited(both, seed), "shoulder") for seed in (1, 2))
    found = diagnose(run, model="direct")
    assert ({f.effect for f in found.findings}, found.verdict) == (set(both), "explained")
    assert _left(found.model, other).max() < 1.1 * NOISE


def test_a_slow_joint_may_begin_from_what_a_fast_one_does() -> None:
    """Whose top speed lies beyond all that the slow one may have: the fit refused that, and all ended."""
    run = of_joints(limited({"integral_action": {"ki": 15.0}}, 1), "shoulder")
    ((context, column, _),) = moved(_stated().only(("shoulder",)), [run])
    loop = Loop.of(context, column)
    fast = (
        Further(loop, (Part(effect("integral_action")),)),
        np.array([*np.log([20.0, 0.4, 1e3]), 0.0, 10.0]),
        0.0,
    )
    own = Further(loop, ()), loop.at(np.array([20.0, 0.02, 5.0, 0.0, 0.0]))[:4], np.inf
    found, at, _ = like_others(own, [fast])
    assert (len(found.parts), at[-1]) == (1, pytest.approx(15.0, rel=0.01))
