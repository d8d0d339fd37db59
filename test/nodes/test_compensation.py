"""The model run backward and tamed."""

from dataclasses import replace

import numpy as np
import pytest

from trunk_ros.chain import Chain
from trunk_ros.model import load_model
from trunk_ros.nodes.bus import gearbox_limits
from trunk_ros.nodes.control.compensation import Compensation

NOMINAL = load_model("trunk")
LOOSE = replace(NOMINAL, effects={"backlash": {"half_width": np.full(5, 2e-3)}})
STEP = 0.01
REVERSAL = 5e-5


def drive(compensation, references):
    return np.array([compensation.step(reference, STEP) for reference in references])


def sweep(size, seconds=4.0):
    return size * np.sin(np.arange(0, seconds, STEP))[:, None] * np.ones(5)


@pytest.mark.parametrize("model", [NOMINAL, LOOSE])
def test_what_goes_through_the_wire_comes_out_as_the_reference(model):
    references = sweep(0.2)
    setpoints = drive(Compensation(model, REVERSAL), references)
    theta, _ = Chain(model, "wire").run(setpoints, np.arange(len(setpoints)) * STEP)
    np.testing.assert_allclose(theta[50:], references[50:], atol=REVERSAL)


def test_the_first_setpoint_is_where_the_motors_stand():
    position = np.full(5, 0.123)
    compensation = Compensation(LOOSE, REVERSAL, position)
    np.testing.assert_array_equal(compensation.step(compensation.joint_angle(position), 0.0), position)


def test_a_swapped_model_does_not_make_it_jump():
    compensation = Compensation(NOMINAL, REVERSAL)
    before = drive(compensation, sweep(0.2, 2.0))[-1]
    compensation.swap(LOOSE)
    resting = np.full(5, 0.2 * np.sin(2.0 - STEP))
    after = drive(compensation, np.tile(resting, (300, 1)))
    assert np.abs(after[0] - before).max() < 2e-4
    assert np.abs(np.diff(after, axis=0)).max() < 3e-4
    fresh = drive(Compensation(LOOSE, REVERSAL), sweep(0.2, 2.0))[-1]
    assert np.abs(after[-1] - fresh).max() < 2 * 2e-3 / 0.625


def wave(t, size=0.2, pace=1.0):
    """Angle, speed and acceleration."""
    return size * np.sin(pace * t), size * pace * np.cos(pace * t), -size * pace**2 * np.sin(pace * t)


def told(compensation, course, now, dt):
    """The setpoint of a reference that is known in advance, the same for all joints."""
    angle, speed, acceleration = (np.full(5, each) for each in course(now + compensation.sight))
    return compensation.step(angle, dt, speed, acceleration)


def led(compensation, seconds, begin=0.0):
    """Setpoints of the first joint for 0.2 sin t, known with its derivatives."""
    at = np.arange(begin, begin + seconds, STEP)
    return np.array([told(compensation, wave, t, STEP if t else 0.0)[0] for t in at])


@pytest.mark.parametrize(("model", "kick"), [(NOMINAL, 1e-5), (LOOSE, 1e-3)])
def test_a_model_that_is_swapped_in_motion_does_not_stop_it(model, kick):
    compensation = Compensation(NOMINAL, REVERSAL, np.zeros(5))
    before = led(compensation, 3.0)
    compensation.swap(model)
    steps = np.diff(np.concatenate([before[-20:], led(compensation, 0.2, 3.0)]))
    assert np.abs(np.diff(steps)).max() < kick


def test_a_reference_that_leaps_after_a_trajectory_is_followed_as_fast_as_ever():
    compensation = Compensation(NOMINAL, REVERSAL, np.zeros(5))
    led(compensation, 3.0)
    far = np.full(5, 0.2 * np.sin(3.0) + 0.2)
    reached = np.array([compensation.step(far, STEP)[0] for _ in range(40)])
    assert np.argmax(reached > 0.9 * reached[-1]) < 30
    assert reached[-1] == pytest.approx(far[0] / 0.625, abs=0.02)


def test_noise_below_the_reversal_does_not_make_it_chatter():
    rng = np.random.default_rng(1)
    references = 0.1 + 2e-5 * rng.uniform(-1, 1, (400, 5))
    setpoints = drive(Compensation(LOOSE, REVERSAL), references)
    assert np.ptp(setpoints[5:], axis=0).max() < 2 * REVERSAL / 0.625
    careless = drive(Compensation(LOOSE, 0.0), references)
    assert np.ptp(careless[5:], axis=0).max() > 2e-3 / 0.625


def test_a_jump_of_the_reference_goes_out_at_the_servos_top_speed():
    references = np.vstack([np.zeros((5, 5)), np.full((50, 5), 0.3)])
    speed = np.diff(drive(Compensation(LOOSE, REVERSAL), references), axis=0) / STEP
    assert np.abs(speed).max() <= NOMINAL.arm.v_max * (1 + 1e-9)
    assert np.abs(speed).max() > 0.99 * NOMINAL.arm.v_max


def test_a_slower_servo_that_was_found_is_respected():
    slow = replace(NOMINAL, effects={"velocity_saturation": {"v_max": 0.5}})
    references = np.vstack([np.zeros((5, 5)), np.full((50, 5), 0.3)])
    assert np.abs(np.diff(drive(Compensation(slow, REVERSAL), references), axis=0)).max() <= 0.5 * STEP * (
        1 + 1e-9
    )


@pytest.mark.parametrize(
    ("found", "up", "down"),
    [
        ({"uneven_speed": {"excess": np.full(5, 0.2)}}, 1.5, 1.2),
        ({"uneven_speed": {"excess": np.full(5, 0.2)}, "velocity_saturation": {"v_max": 1.0}}, 1.2, 0.8),
        ({"velocity_saturation": {"v_max": 3.0}}, 1.5, 1.5),
    ],
    ids=["uneven", "uneven and slower", "faster"],
)
def test_setpoints_go_each_way_as_fast_as_the_servo_and_never_faster_than_the_models_v_max(found, up, down):
    references = np.vstack([np.zeros((5, 5)), np.full((60, 5), 0.3), np.full((60, 5), -0.3)])
    compensation = Compensation(replace(NOMINAL, effects=found), REVERSAL)
    speed = np.diff(drive(compensation, references), axis=0) / STEP
    assert speed.max() == pytest.approx(up)
    assert speed.min() == pytest.approx(-down)


def test_a_servo_that_hardly_moves_does_not_hold_the_others_back():
    tops = np.array([0.01, 1.5, 1.5, 1.5, 1.5])
    own = replace(NOMINAL, arm=replace(NOMINAL.arm, v_max=tops))
    references = np.vstack([np.zeros((5, 5)), np.full((50, 5), 0.3)])
    fastest = np.abs(np.diff(drive(Compensation(own, REVERSAL), references), axis=0)).max(axis=0) / STEP
    np.testing.assert_allclose(fastest, tops, rtol=0.01)


def test_a_servo_that_was_slow_for_a_while_is_not_slow_any_more():
    was = {
        "velocity_saturation": {"v_max": 0.5, "until": 10.0},
        "servo_bandwidth": {"relative": -0.5, "until": 10.0},
    }
    now = Compensation(replace(NOMINAL, effects=was, duration=20.0), REVERSAL)
    np.testing.assert_array_equal(now.tops, np.full((2, 5), NOMINAL.arm.v_max))
    np.testing.assert_array_equal(now.gain, np.full(5, NOMINAL.arm.kp))


def test_it_never_leaves_the_limits_and_says_which_joint_is_held_back():
    lower, upper = gearbox_limits(NOMINAL.arm)
    compensation = Compensation(LOOSE, REVERSAL)
    setpoints = drive(compensation, sweep(3.0))
    assert (setpoints <= upper).all()
    assert (setpoints >= lower).all()
    assert compensation.limited.all()


def tracked(compensation, arm, course, at, ahead=True):
    """How far the joints are off (n, joints) rad, of an arm under compensation."""
    setpoints, last = [], at[0]
    for now in at:
        step = told(compensation, course, now, now - last) if ahead else None
        if step is None:
            step = compensation.step(np.full(5, course(now)[0]), now - last)
        setpoints.append(step)
        last = now
    phi, _ = Chain(arm, "servo").run(np.array(setpoints), at)
    return Chain(arm, "wire").run(phi, at)[0] - course(at)[0][:, None]


def rms(off):
    return np.sqrt(np.mean(off**2))


def test_running_ahead_makes_up_for_the_servos_lag():
    def error(ahead):
        at = np.arange(0, 6, STEP)
        compensation = Compensation(NOMINAL, REVERSAL, np.zeros(5))
        return rms(tracked(compensation, NOMINAL, lambda t: wave(t, 0.15, 2.0), at, ahead)[300:])

    assert error(ahead=False) > 1e-2
    assert error(ahead=True) < 1e-4


@pytest.mark.parametrize(("period", "uneven", "most"), [(0.01, 0.003, 1e-4), (0.05, 0.0, 2e-4)])
def test_uneven_and_long_periods_are_tracked(period, uneven, most):
    at = np.arange(0, 12, period)
    at[1:] += np.random.default_rng(1).uniform(-uneven, uneven, len(at) - 1)
    compensation = Compensation(NOMINAL, REVERSAL, np.zeros(5))
    off = tracked(compensation, NOMINAL, lambda t: wave(t, 0.15, 2.0), at)
    assert rms(off[at > 3.0]) < most


def test_a_motion_ends_where_it_should():
    """What runs ahead does not turn back at the end: joints with play would stay where it turned."""

    def course(t):
        s = np.clip(t / 0.8, 0.0, 1.0)
        bend = 60 * s - 180 * s**2 + 120 * s**3
        return (
            0.2 * s**3 * (10 - 15 * s + 6 * s**2),
            0.2 / 0.8 * 30 * (s - s**2) ** 2,
            0.2 / 0.64 * bend,
        )

    at = np.arange(0, 2, STEP)
    off = tracked(Compensation(LOOSE, REVERSAL, np.zeros(5)), LOOSE, course, at)
    assert np.abs(off[at > 1.5]).max() < 1e-5


def test_a_reference_that_becomes_known_in_motion_is_caught_up_with_and_not_overshot():
    compensation = Compensation(NOMINAL, REVERSAL, np.zeros(5))
    at = np.arange(0, 3.3, STEP)
    setpoints = [compensation.step(np.full(5, wave(t)[0]), STEP) for t in at[:300]]
    setpoints += [told(compensation, wave, t, STEP) for t in at[300:]]
    phi, _ = Chain(NOMINAL, "servo").run(np.array(setpoints), at)
    theta, _ = Chain(NOMINAL, "wire").run(phi, at)
    behind = theta[:, 0] - wave(at)[0]  # it is on the way down
    assert behind[299] > 1e-2
    assert behind[300:].min() > -5e-5
    assert np.abs(behind[-10:]).max() < 1e-4


def test_a_step_in_which_no_time_passes_changes_nothing():
    sticks = {"amplitude": np.full(5, 3e-3), "velocity": np.full(5, 0.05)}
    arm = replace(NOMINAL, effects={"stribeck_friction": sticks})
    plain, twice = (Compensation(arm, REVERSAL, np.zeros(5)) for _ in range(2))
    for t in np.arange(0, 3, STEP):
        once = told(plain, wave, t, STEP)
        np.testing.assert_array_equal(told(twice, wave, t, STEP), once)
        np.testing.assert_array_equal(told(twice, wave, t, 0.0), once)


def test_what_holds_the_lead_back_is_said():
    arm = replace(NOMINAL, effects={"backlash": {"half_width": np.full(5, 4e-3)}})
    compensation = Compensation(arm, REVERSAL, np.zeros(5))
    last, most = np.zeros(5), NOMINAL.arm.v_max * STEP * (1 - 1e-9)
    fast = 0
    for t in np.arange(0, 6, STEP):
        out = told(compensation, lambda t: wave(t, 0.05), t, STEP)
        held = np.abs(out - last) > most
        assert compensation.limited[held].all()
        fast, last = fast + held.any(), out
    assert fast


@pytest.mark.parametrize(
    ("amplitude", "fades", "step"),
    [(5e-4, 0.017, STEP), (2.3e-2, 0.017, STEP), (3e-3, 0.05, 1e-3), (2.5e-2, 0.05, 1e-3)],
)
def test_friction_that_fades_while_the_servo_crosses_it_is_made_good(amplitude, fades, step):
    """Slow turns of an arm that sticks: with the nominal model, and with that of the arm."""
    sticks = {"amplitude": np.full(5, amplitude), "velocity": np.full(5, fades), "form": "gaussian"}
    arm = replace(NOMINAL, effects={"stribeck_friction": sticks})
    stamp = np.arange(0, 25 if step == STEP else 13, step)

    def off(believed):
        compensation = Compensation(believed, REVERSAL, np.zeros(5))
        return rms(tracked(compensation, arm, lambda t: wave(t, 0.05), stamp)[stamp > 3.0])

    assert off(arm) < 0.4 * off(NOMINAL)
