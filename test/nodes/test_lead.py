"""Setpoints that have the servo be in time."""

import numpy as np
import pytest

from trunk_ros.chain import Chain
from trunk_ros.model import load_model
from trunk_ros.nodes.control.lead import Lead

NOMINAL = load_model("trunk")
SERVO = np.full(5, NOMINAL.arm.kp), NOMINAL.arm.tau_v, NOMINAL.arm.v_max
STEP = 0.01
AT = np.arange(0, 3, STEP)


def led(wanted, most=np.inf):
    """Where the servo goes (n,) rad, of setpoints that change by ``most`` at a time."""
    last = np.full(5, wanted[0])
    lead = Lead(last, *SERVO)
    out = []
    for each in wanted:
        last = last + np.clip(lead.setpoint(np.full(5, each), STEP) - last, -most, most)
        lead.went(last, STEP)
        out.append(last)
    return Chain(NOMINAL, "servo").run(np.array(out), AT)[0][:, 0]


def plain(wanted):
    return Chain(NOMINAL, "servo").run(np.outer(wanted, np.ones(5)), AT)[0][:, 0]


def test_a_step_is_there_sooner_and_not_overshot():
    wanted = np.where(AT < 1.0, 0.0, 0.01)
    there, usual = led(wanted), plain(wanted)
    assert np.abs(there - wanted).sum() < 0.8 * np.abs(usual - wanted).sum()
    assert there.max() < 0.01 * 1.001 < 0.01 * 1.01 < usual.max()


@pytest.mark.parametrize("size", [0.02, 0.1, 0.5])
def test_what_a_limit_held_back_is_caught_up_with_and_not_overshot(size):
    wanted = np.where(AT < 1.0, 0.0, size)
    there = led(wanted, most=NOMINAL.arm.v_max * STEP)
    assert there.max() < size * 1.02
    assert there[-1] == pytest.approx(size, abs=1e-6)


def test_a_reference_that_is_led_is_followed_to_a_thousandth():
    lead = Lead(np.zeros(5), *SERVO)
    angle, speed = 0.2 * np.sin(2 * AT), 0.4 * np.cos(2 * AT)
    ahead = np.array([lead.ahead(v, a, STEP)[0] for v, a in zip(speed, -4 * angle, strict=True)])
    assert np.abs(led(angle + ahead) - angle)[100:].max() < 2e-4
    assert np.abs(plain(angle) - angle)[100:].max() > 1e-2
