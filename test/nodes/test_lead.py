"""Setpoints that have the servo be in time."""

from dataclasses import replace

import numpy as np
import pytest

from trunk_ros.chain import Chain
from trunk_ros.model import Model, load_model
from trunk_ros.nodes.control.lead import Lead

NOMINAL = load_model("trunk")
TOPS = np.full(5, NOMINAL.arm.v_max), np.full(5, NOMINAL.arm.v_max)
SERVO = np.full(5, NOMINAL.arm.kp), NOMINAL.arm.tau_v, TOPS
STEP = 0.01
AT = np.arange(0, 3, STEP)


def led(wanted, most=np.inf, fed=0.0):
    """Where the servo goes (n,) rad, ``wanted`` of a time [s]; setpoints change by ``most`` at once, and it
    is ``fed`` some of their speed.
    """
    last = np.full(5, wanted(0.0))
    lead = Lead(last, *SERVO, fed)
    out = []
    for k, now in enumerate(AT):
        lead.elapse(STEP if k else 0.0)
        goes = lead.setpoint(np.full(5, wanted(now + lead.sight)))
        last = lead.sent(last + np.clip(goes - last, -most, most))
        out.append(last)
    servo = replace(NOMINAL, arm=replace(NOMINAL.arm, feedforward=fed))
    return Chain(servo, "servo").run(np.array(out), AT)[0][:, 0]


def plain(wanted):
    return Chain(NOMINAL, "servo").run(np.outer(wanted, np.ones(5)), AT)[0][:, 0]


def leap(size):
    return lambda t: size if t >= 1.0 else 0.0


def test_a_step_is_there_sooner_and_not_overshot():
    wanted = np.where(AT < 1.0, 0.0, 0.01)
    there, usual = led(leap(0.01)), plain(wanted)
    assert np.abs(there - wanted).sum() < 0.8 * np.abs(usual - wanted).sum()
    assert there.max() < 0.01 * 1.001 < 0.01 * 1.01 < usual.max()


def test_a_servo_that_is_fed_the_speed_of_its_setpoints_is_led_to_the_same_place():
    np.testing.assert_allclose(led(leap(0.01), fed=0.6), led(leap(0.01)), atol=1e-9)


@pytest.mark.parametrize("size", [0.02, 0.1, 0.5])
def test_what_a_limit_held_back_is_caught_up_with_and_not_overshot(size):
    there = led(leap(size), most=NOMINAL.arm.v_max * STEP)
    assert there.max() < size * 1.02
    assert there[-1] == pytest.approx(size, abs=1e-6)


def led_with_derivatives(at, model=NOMINAL, **told):
    """Where the servo of a model goes (n,) rad, of 0.2 sin(2t)."""
    lead = Lead(np.zeros(5), *SERVO, ahead=model.arm.ahead, delay=model.arm.delay, **told)
    out = []
    for k, now in enumerate(at):
        lead.elapse(now - at[k - 1] if k else 0.0)
        angle, speed = (0.2 * np.sin(2 * (now + lead.sight)), 0.4 * np.cos(2 * (now + lead.sight)))
        ahead = lead.ahead(np.full(5, speed), np.full(5, -4 * angle))
        out.append(lead.sent(lead.setpoint(angle + ahead)))
    return Chain(model, "servo").run(np.array(out), at)[0][:, 0]


def test_what_is_led_is_followed_to_a_thousandth():
    angle = 0.2 * np.sin(2 * AT)
    assert np.abs(led_with_derivatives(AT) - angle)[100:].max() < 2e-4
    assert np.abs(plain(angle) - angle)[100:].max() > 1e-2


def test_a_servo_whose_loop_runs_faster_is_followed_as_well():
    faster = replace(NOMINAL, arm=replace(NOMINAL.arm, step=0.0))
    angle = 0.2 * np.sin(2 * AT)
    assert np.abs(led_with_derivatives(AT, faster) - angle)[100:].max() < 1e-4


@pytest.mark.parametrize("fed", [0.0, 0.5])
def test_an_integral_part_is_led_as_well(fed):
    """A lead that does not know of it asks for what it has made up for by itself."""
    arm, angle = replace(NOMINAL.arm, feedforward=fed), 0.2 * np.sin(2 * AT)
    model = Model(arm, {"integral_action": {"ki": 40.0}})
    knows, does_not = (np.abs(led_with_derivatives(AT, model, fed=fed, ki=ki) - angle) for ki in (40.0, 0.0))
    assert knows[100:].max() < 3e-4
    assert does_not[100:].max() > 4e-3


@pytest.mark.parametrize(("period", "uneven", "most"), [(0.01, 0.003, 4e-4), (0.05, 0.0, 6e-4)])
def test_periods_may_be_uneven_or_long(period, uneven, most):
    at = np.arange(0, 6, period)
    at[1:] += np.random.default_rng(1).uniform(-uneven, uneven, len(at) - 1)
    off = (led_with_derivatives(at) - 0.2 * np.sin(2 * at))[at > 2.0]
    assert np.abs(off).max() < most


@pytest.mark.parametrize("delay", [0.005, 0.05])
def test_setpoints_that_act_late_go_out_early(delay):
    late = replace(NOMINAL, arm=replace(NOMINAL.arm, delay=delay))
    angle = 0.2 * np.sin(2 * AT)
    assert np.abs(led_with_derivatives(AT, late) - angle)[100:].max() < 3e-4
    each = np.array([0.0, 0.3, 1.0, 1.0, 1.0]) * delay
    late = replace(NOMINAL, arm=replace(NOMINAL.arm, delay=each))
    assert np.abs(led_with_derivatives(AT, late) - angle)[100:].max() < 3e-4


def test_the_end_of_a_motion_in_sight_is_not_gone_back_from():
    lead, heard = Lead(np.zeros(5), *SERVO, delay=0.05), []
    for k in range(len(AT)):
        lead.elapse(STEP if k else 0.0)
        s = min(AT[k] + lead.sight, 1.0)  # a second from rest to rest
        heard.append(10 * s**3 - 15 * s**4 + 6 * s**5)
        lead.ahead(np.full(5, 30 * (s * (1 - s)) ** 2), np.full(5, 60 * s * (1 - s) * (1 - 2 * s)))
    assert np.diff(heard).min() >= 0.0
