"""What a load does to a servo between two of the moments at which it is told."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from trunk_ros.compiled import Array
from trunk_ros.effects.servo.loop import fresh, servo_loop, unlimited
from trunk_ros.effects.servo.loops import servo_loops


def _run(loop: Callable[..., Any], period: float) -> Array:
    """Where the shafts of two loops stand each 20 ms under loads that swing, told each ``period`` s."""
    stamp = np.arange(0.0, 2.0, period)
    load = 0.02 * np.sin(3.0 * stamp)[:, None] * np.array([1.0, -2.0])
    still, one, out = np.zeros_like(load), np.ones(2), np.empty_like(load)
    state = fresh(np.zeros(2))
    numbers = [np.ascontiguousarray((value * one)[None]) for value in (20.0, 0.02, 9.0, 9.0, 0.0)]
    if loop is servo_loops:
        numbers = [each[0] for each in numbers]
    torque, rub, cogging = 0.0 * one, 0.0 * one, np.zeros((3, 1, 2))
    limits, ki = unlimited(2), 0.0 * one
    if loop is servo_loop:
        torque, rub, ki = torque[None], rub[None], ki[None]
    else:
        cogging, limits = np.ascontiguousarray(cogging[:, 0]), np.ascontiguousarray(limits[:, 0])
    loop(
        still, stamp, *numbers, still, load, torque, rub, 0.0 * one, still, cogging, limits, ki, still[:0],
        0.5, 0, state, out,
    )  # fmt: skip
    return out[:: round(0.02 / period)]


@pytest.mark.parametrize("loop", [servo_loop, servo_loops])
def test_a_load_goes_on_between_the_moments_at_which_it_is_told(loop: Callable[..., Any]) -> None:
    """Held from either end it would be 10 ms off, of up to 120 mrad/s: 1.2 mrad."""
    seldom, often = _run(loop, 0.02), _run(loop, 0.002)
    assert np.abs(often).max() > 0.03
    np.testing.assert_allclose(seldom, often, atol=1e-4)
