"""Velocity loops with an integral part, against plain Python."""

from __future__ import annotations

import numpy as np
import pytest

from test.test_drive_limits import FINE, KP, RATE, TAU, asked
from test.test_integral_action import servo
from trunk_ros.compiled import Array


def in_steps(setpoint: Array, rate: float, most: float = np.inf) -> Array:
    """Gearbox angles of a joint (n,), in steps of 0.1 ms; its speed changes by no more than ``most``."""
    phi, v, total, out = setpoint[0], 0.0, 0.0, []
    for target in setpoint:
        out.append(phi)
        for _ in range(round(1.0 / RATE / FINE)):
            wanted = KP * (target - phi)
            change = (wanted + total - v) / TAU
            off = rate * (wanted - v) * FINE
            total += off if abs(change) < most or off * change < 0.0 else 0.0
            v += np.clip(change, -most, most) * FINE
            phi += v * FINE
    return np.array(out)


@pytest.mark.parametrize("rate", [3.0, 15.0])
def test_it_sums_up_how_far_the_speed_is_from_what_is_asked(rate: float) -> None:
    stamp, setpoint = asked()
    got = servo(setpoint, stamp, {"speed_integral": {"rate": rate}})
    assert got[:, 1] == pytest.approx(in_steps(setpoint[:, 1], rate), abs=3e-4)
    assert got[:, 0] == pytest.approx(in_steps(setpoint[:, 0], rate), abs=4e-3)
    assert np.abs(got - servo(setpoint, stamp, {})).max() > 3e-3


def test_it_does_not_sum_up_what_the_motor_cannot_do() -> None:
    stamp, setpoint = asked()
    got = servo(
        setpoint, stamp, {"speed_integral": {"rate": 15.0}, "acceleration_limit": {"acceleration": 80.0}}
    )
    assert got[:, 0] == pytest.approx(in_steps(setpoint[:, 0], 15.0, most=80.0), abs=3e-3)


def test_a_torque_that_pulls_is_made_up_for() -> None:
    """One that comes lets the shaft go, and it comes back; one that was there at first does nothing."""
    stamp = np.arange(0.0, 8.0, 1.0 / RATE)
    setpoint = np.tile(np.where(stamp > 4.0, 0.6, 0.3)[:, None], (1, 2))
    droop = {"load_droop": {"gain": 0.02, "form": "weight", "as_torque": 1.0}}
    alone = servo(setpoint, stamp, droop)
    got = servo(setpoint, stamp, droop | {"speed_integral": {"rate": 10.0}})
    assert np.abs(alone - setpoint)[-1].min() > 1e-3
    assert np.abs(got - setpoint)[-1].max() < 1e-5
    assert np.abs(got - setpoint)[stamp < 4.0].max() < 1e-5
    none = servo(setpoint, stamp, {"speed_integral": {"rate": 10.0}})
    assert np.abs(got - none).max() > 3e-4, "in between it yields"
