"""Slow feedback takes away what the model does not know of, without jumps and without hunting."""

from dataclasses import replace

import numpy as np
import pytest

from trunk_ros.chain import Chain
from trunk_ros.model import load_model
from trunk_ros.nodes.control.compensation import Compensation
from trunk_ros.nodes.control.goal import State
from trunk_ros.nodes.control.observation import Observation
from trunk_ros.nodes.control.slow_feedback import Settings, SlowFeedback

STEP, SECOND = 0.01, 10**9
NOMINAL = load_model("trunk")
SETTINGS = Settings(gain=1.0, rate=0.005, limit=0.05, tolerance=5e-4)
WHOLE = np.ones(5)


def with_effects(**effects):
    return replace(NOMINAL, effects=effects)


def drive(plant, references, settings=SETTINGS, believed=NOMINAL, deaf=slice(0, 0), noise=0.0):
    """Setpoints, corrections and joint angles (n, 5) of a plant under compensation with slow feedback."""
    rng = np.random.default_rng(3)
    compensation, observation = Compensation(believed, 5e-5), Observation(believed, strict=False)
    servo, wire, memory = Chain(believed, "servo"), Chain(plant, "wire"), [None, None]
    setpoints, trims, angles = [], [], []
    for k, reference in enumerate(references):
        now, stamp = round(k * STEP * SECOND), np.array([k * STEP])
        observation.remember(now, reference, np.zeros(5))
        fresh = not deaf.start <= k < deaf.stop
        trim = observation.correction(now, fresh, settings, reference, compensation.limited, STEP)
        setpoints.append(compensation.step(reference + trim, STEP))
        trims.append(trim)
        phi, memory[0] = servo.run(setpoints[-1][None], stamp, memory[0])
        theta, memory[1] = wire.run(phi, stamp, memory[1])
        angles.append(theta[0] + noise * rng.normal(size=5))
        if fresh:
            observation.measured.joints.put(now, State(angles[-1], np.zeros(5)))
    return np.array(setpoints), np.array(trims), np.array(angles)


def resting(seconds, angle=0.1):
    """A quick move to an angle, and a rest there."""
    at = np.arange(0, seconds, STEP)
    return np.minimum(at / 0.5, 1.0)[:, None] * angle * WHOLE


OFFSET = with_effects(zero_offset={"offset": 4e-3 * WHOLE})
DRIFT = with_effects(thermal_drift={"form": "straight", "rate": 2e-4 * WHOLE})


def test_an_offset_that_no_model_knows_goes_away_and_stays_away():
    references = resting(12.0)
    _, trims, angles = drive(OFFSET, references)
    assert np.abs(angles - references)[100].min() > 2e-3
    assert np.abs(angles - references)[-300:].max() < SETTINGS.tolerance
    assert np.abs(np.diff(trims, axis=0)).max() <= SETTINGS.rate * STEP * (1 + 1e-9)


def test_a_drift_is_followed_within_the_tolerance():
    references = resting(40.0)
    _, _, angles = drive(DRIFT, references)
    _, _, alone = drive(DRIFT, references, settings=replace(SETTINGS, gain=0.0))
    assert np.abs(alone - references)[-1].min() > 5e-3
    assert np.abs(angles - references)[1000:].max() < 1.5 * SETTINGS.tolerance


def test_off_it_changes_nothing():
    references = resting(3.0)
    _, trims, _ = drive(OFFSET, references, settings=replace(SETTINGS, gain=0.0))
    assert not trims.any()


@pytest.mark.parametrize("width", [2e-3, -3e-4])
@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_a_dead_band_that_the_model_has_wrong_is_not_hunted_in(width, noise):
    believed = with_effects(backlash={"half_width": (1e-3 + max(-width, 0)) * WHOLE})
    plant = with_effects(
        backlash={"half_width": (1e-3 + max(width, 0)) * WHOLE}, zero_offset={"offset": 3e-3 * WHOLE}
    )
    _, trims, _ = drive(plant, resting(30.0), believed=believed, noise=noise)
    turns = np.diff(np.sign(np.diff(trims, axis=0)[200:]), axis=0)
    assert (np.abs(turns) > 1).sum(axis=0).max() <= 1
    assert np.ptp(trims[-500:], axis=0).max() < 1e-3


def test_without_fresh_joint_states_the_correction_stays():
    deaf = slice(300, 900)
    _, trims, _ = drive(OFFSET, resting(10.0), deaf=deaf)
    assert trims[300].min() != 0
    np.testing.assert_array_equal(trims[deaf], np.broadcast_to(trims[300], trims[deaf].shape))


def test_a_joint_at_its_limit_does_not_wind_up():
    top = NOMINAL.arm.upper[0]
    references = resting(6.0, angle=top)
    _, trims, _ = drive(with_effects(zero_offset={"offset": -0.02 * WHOLE}), references)
    assert np.abs(trims).max() < 3e-3


def test_what_a_known_delay_shows_while_moving_is_not_taken_for_an_offset():
    late = with_effects(sensor_delay={"delay": 0.05})
    at = np.arange(0, 20, STEP)
    references = 0.15 * np.sin(0.5 * at)[:, None] * WHOLE
    _, trims, _ = drive(late, references, believed=late, settings=replace(SETTINGS, tolerance=5e-3))
    assert np.abs(trims).max() == 0


def test_switched_off_on_the_way_it_lets_go_slowly():
    feedback = SlowFeedback(5)
    for _ in range(100):
        feedback.step(SETTINGS, 0 * WHOLE, 0.01 * WHOLE, np.zeros(5, dtype=bool), STEP)
    learnt = feedback.trim.copy()
    assert (learnt > 1e-3).all()
    off = replace(SETTINGS, gain=0.0)
    path = [feedback.step(off, 0 * WHOLE, None, np.zeros(5, dtype=bool), STEP) for _ in range(400)]
    assert np.abs(np.diff([learnt, *path], axis=0)).max() <= SETTINGS.rate * STEP * (1 + 1e-9)
    assert not path[-1].any()
