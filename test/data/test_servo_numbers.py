"""Numbers of servos in another unit are told by the recording; numbers that are only wrong are not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import diagnose
from test.diagnosis.test_nominal_servo import JOINTS, PLAIN, _stated, recorded_servos
from trunk_ros.data.mix_ups import mix_ups


@pytest.mark.parametrize(
    ("servo", "stated", "told"),
    [
        ({"delay": (0.012,) * 3}, {"delay": 12.0}, ["servo.delay = 12 in the model file looks like ms"]),
        ({}, {"tau_v": 20.0}, ["servo.tau_v = 20 in the model file looks like ms", "write 0.02"]),
        ({}, {"kp": 0.05}, ["servo.kp = 0.05 in the model file looks like its inverse, in s", "write 20"]),
        ({}, {"kp": 0.02}, ["servo.kp = 0.02 in the model file looks like 1/ms", "write 20"]),
        ({"delay": (0.01,) * 3}, {"delay": 10.0, "tau_v": 20.0}, ["servo.delay = 10", "servo.tau_v = 20"]),
        ({"kp": (12.0, 30.0, 60.0)}, {"kp": [1 / 12, 1 / 30, 1 / 60]}, ["write 12, 30, 60"]),
    ],
)  # fmt: skip
def test_a_unit_is_told_by_where_the_motors_went(
    servo: dict[str, Any], stated: dict[str, Any], told: list[str]
) -> None:
    (found,) = mix_ups(recorded_servos(PLAIN | servo, after=0.0), _stated(**stated))
    assert (found.kind, found.stage, found.certain, found.joints) == ("unit", "servo", True, JOINTS)
    assert all(each in found.statement for each in told)


@pytest.mark.parametrize(
    ("servo", "stated"),
    [
        ({}, {}),
        ({}, {"kp": 4.0}),
        ({}, {"kp": 200.0}),
        ({"tau_v": (1.5,) * 3, "kp": (0.3,) * 3}, {"tau_v": 1.5, "kp": 0.3}),
        ({"v_max": (0.2,) * 3}, {}),
        ({"delay": (0.3,) * 3}, {}),
    ],
    ids=["right", "slow", "quick", "heavy and told so", "saturated", "late"],
)
def test_numbers_that_are_wrong_or_large_are_in_no_other_unit(
    servo: dict[str, Any], stated: dict[str, Any]
) -> None:
    assert mix_ups(recorded_servos(PLAIN | servo, after=0.0), _stated(**stated)) == []


def test_what_is_told_is_not_diagnosed_and_stays_unexplained() -> None:
    found = diagnose(recorded_servos(PLAIN, after=0.0), model=_stated(tau_v=20.0))
    assert found.verdict == "unexplained"
    assert not found.findings
    assert np.all(found.model.number("tau_v") == 20.0)
