"""Position loops with an integral part, against plain Python."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.effects.example import arm_of
from test.test_drive_limits import FINE, KP, RATE, TAU, asked
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.model import Model


def servo(setpoint: Array, stamp: Array, effects: dict[str, Any], **loop: Any) -> Array:
    """Gearbox angles (n, joints)."""
    arm = replace(arm_of(setpoint.shape[1]), **{"kp": KP, "tau_v": TAU, "v_max": 500.0, "step": 0.0} | loop)
    return Chain(Model(arm, effects), "servo").run(setpoint, stamp)[0]


def in_steps(setpoint: Array, ki: float, top: float = np.inf, fed: float = 0.0, winds: bool = False) -> Array:
    """The same of a joint (n,), in steps of 0.1 ms; ``winds``: it sums up whatever it cannot do."""
    phi, v, total, last, out = setpoint[0], 0.0, 0.0, setpoint[0], []
    for target in setpoint:
        out.append(phi)
        slope, last = RATE * (target - last), target
        for _ in range(round(1.0 / RATE / FINE)):
            error = target - phi
            wanted = KP * error + total + fed * slope
            if winds or abs(wanted) <= top or error * wanted < 0.0:
                total += ki * error * FINE
            v += (np.clip(wanted, -top, top) - v) / TAU * FINE
            phi += v * FINE
    return np.array(out)


@pytest.mark.parametrize("ki", [15.0, 150.0])
@pytest.mark.parametrize("fed", [0.0, 0.6])
def test_it_sums_up_how_far_the_shaft_is_from_its_setpoint(ki: float, fed: float) -> None:
    """And not what the velocity loop is told of how fast setpoints move."""
    stamp, setpoint = asked()
    got = servo(setpoint, stamp, {"integral_action": {"ki": ki}}, feedforward=fed)
    assert got[:, 1] == pytest.approx(in_steps(setpoint[:, 1], ki, fed=fed), abs=3e-4)
    assert got[:, 0] == pytest.approx(in_steps(setpoint[:, 0], ki, fed=fed), abs=2e-3)
    assert np.abs(got - servo(setpoint, stamp, {}, feedforward=fed)).max() > 8e-3


def test_it_does_not_wind_up_while_the_loop_asks_for_more_than_its_top_speed() -> None:
    stamp, setpoint = asked()
    got = servo(setpoint, stamp, {"integral_action": {"ki": 40.0}}, v_max=0.8)[:, 0]
    assert got == pytest.approx(in_steps(setpoint[:, 0], 40.0, top=0.8), abs=2e-3)
    wound = in_steps(setpoint[:, 0], 40.0, top=0.8, winds=True)
    assert np.abs(got - wound).max() > 0.05
    winds = {"integral_action": {"ki": 40.0, "windup": 1e4}}
    assert servo(setpoint, stamp, winds, v_max=0.8)[:, 0] == pytest.approx(wound, abs=2e-3)


def test_what_loads_pull_is_made_up_for() -> None:
    """A load that comes lets the shaft go, and it comes back; one that was there from the beginning does
    nothing.
    """
    stamp = np.arange(0.0, 12.0, 1.0 / RATE)
    setpoint = np.tile(np.where(stamp > 4.0, 0.6, 0.3)[:, None], (1, 2))
    droop = {"load_droop": {"gain": 0.02, "form": "weight"}}
    for past in (0.0, 1.0):
        droop["load_droop"]["as_torque"] = past
        alone = servo(setpoint, stamp, droop)
        got = servo(setpoint, stamp, droop | {"integral_action": {"ki": 30.0}})
        assert np.abs(alone - setpoint)[-1].min() > 1e-3
        assert np.abs(got - setpoint)[-1].max() < 1e-5
        assert np.abs(got - setpoint)[stamp < 4.0].max() < 1e-5
        none = servo(setpoint, stamp, {"integral_action": {"ki": 30.0}})
        assert np.abs(got - none).max() > 1e-3, "in between it yields"


def test_a_run_that_begins_under_way_goes_on() -> None:
    """What the integral part held before nobody recorded follows from how fast the shaft goes."""
    stamp, setpoint = asked(8.0)
    setpoint = 0.4 * stamp[:, None] + np.zeros((1, 2))
    model = Model(
        replace(arm_of(2), kp=KP, tau_v=TAU, v_max=50.0, step=0.0), {"integral_action": {"ki": 30.0}}
    )
    chain = Chain(model, "servo")
    whole, state = chain.run(setpoint, stamp)
    half, state = chain.run(setpoint[:400], stamp[:400])
    rest, _ = chain.run(setpoint[400:], stamp[400:], state)
    np.testing.assert_allclose(np.concatenate([half, rest]), whole, atol=1e-12)
