"""The statistics of ``watch``: few false alarms, changes seen soon, memory that does not grow."""

import copy

import numpy as np
import pytest

from test.diagnosis.arms import NOISE, on, recorded
from trunk_ros.fleet.watch.detector import LEARNT, Detector
from trunk_ros.fleet.watch.looks import looked
from trunk_ros.fleet.watch.monitor import Change, Monitor
from trunk_ros.fleet.watch.regimes import REGIMES, Motion
from trunk_ros.model import load_model

CHANGES = {  # by what they look like; on one joint each
    "always": ({"zero_offset": {"offset": on(3, 3 * NOISE)}}, "wire", "joint_3"),
    "reversal": ({"backlash": {"half_width": on(2, 3 * NOISE)}}, "wire", "joint_2"),
    "posture": ({"ratio_error": {"relative": on(4, 3 * NOISE / 0.15)}}, "wire", "joint_4"),
    "high_speed": ({"viscous_lag": {"time_constant": on(1, 3 * NOISE / 0.1)}}, "wire", "joint_1"),
}


def fed(monitor, recording, start=0.0, every=50):
    """Changes that a monitor finds in a recording whose first sample is at ``start`` s."""
    found, series = [], recording.series
    stamp = series["joint_states"].stamp
    for k in range(len(stamp)):
        at = start + stamp[k]
        monitor.setpoints(at, series["setpoints"].position[k])
        monitor.gearbox(at, series["gearbox_states"].position[k])
        monitor.joint_states(at, series["joint_states"].position[k])
        if k % every == 0:
            found += monitor.look()
    return found


@pytest.fixture(scope="module")
def whole():
    """A monitor that has seen 150 s of a clean arm, and what it said."""
    monitor = Monitor(load_model("trunk"))
    return monitor, fed(monitor, recorded({}, seconds=150.0, seed=1))


@pytest.fixture
def monitor(whole):
    return copy.deepcopy(whole[0])


def test_a_clean_arm_says_nothing(whole):
    assert whole[1] == []


@pytest.mark.parametrize("looks", CHANGES)
def test_a_change_of_three_times_the_noise_is_seen_in_seconds_on_its_joint(monitor, looks):
    effects, stage, joint = CHANGES[looks]
    found = fed(monitor, recorded(effects, seconds=12.0, seed=1), start=151.0)
    assert [(c.stage, c.joint) for c in found] == [(stage, joint)]
    assert found[0].seen - 151.0 < 10.0
    assert 147.0 < found[0].since < found[0].seen
    assert found[0].evidence > monitor.wire.detector.bound
    assert looks == found[0].regime
    motion = {"posture": (1.8e-4, 3e-4), "high_speed": (3e-4, 9e-4)}  # goes by how far or fast it went
    least, most = motion.get(looks, (2.7e-4, 3.3e-4))
    assert least < abs(found[0].size) < most


@pytest.mark.parametrize(
    ("looks", "effects", "sign", "sizes"),
    [
        ("reversal", {"backlash": {"half_width": on(2, 4e-3)}}, -1.0, (3.8e-3, 4.1e-3)),
        ("always", {"zero_offset": {"offset": on(2, 2e-2)}}, 1.0, (1.98e-2, 2.02e-2)),
        ("posture", {"ratio_error": {"relative": on(2, 0.1)}}, 1.0, (1.8e-3, 2.4e-3)),
    ],
)
def test_what_is_far_beyond_the_noise_is_said_in_its_size_whatever_glitches(
    monitor, looks, effects, sign, sizes
):
    changed = recorded(effects, seconds=14.0, seed=1)
    changed.series["joint_states"].position[::40, 1] += 0.5
    (change,) = fed(monitor, changed, start=151.0)
    assert (change.joint, change.regime, change.rivals) == ("joint_2", looks, ())
    assert sizes[0] < sign * change.size < sizes[1]
    assert f"({looks}): {1e3 * change.size:+.3g} mrad, " in change.statement


def test_a_change_of_the_usual_is_said_by_how_much_it_changed():
    """A model whose joint is 5 mrad off all the time, fifty times the noise."""
    off = {"zero_offset": {"offset": on(3, 5e-3)}}
    monitor = Monitor(load_model("trunk"))
    assert fed(monitor, recorded(off, seconds=90.0, seed=1)) == []
    more = {"zero_offset": {"offset": on(3, -2e-3)}}
    (change,) = fed(monitor, recorded(more, seconds=14.0, seed=2), start=91.0)
    assert (change.joint, change.regime) == ("joint_3", "always")
    assert change.size == pytest.approx(-7e-3, rel=0.02)


def test_where_the_motion_does_not_tell_regimes_apart_it_is_said():
    """One way only: a zero, a dead band and a lag look alike."""
    rng = np.random.default_rng(0)
    weights = np.zeros((500, 6))
    weights[:, [0, 2]] = 1.0
    look = looked(-40.0 + rng.normal(size=500), weights, 1.0)
    assert {REGIMES[k] for k in (look.regime, *look.rivals)} == {"always", "reversal"}
    assert look.size == pytest.approx(-40.0, rel=0.01)
    change = Change("wire", "elbow", "always", -4e-3, 1e-4, "rad", 0.0, 0.0, 9.0, ("reversal",))
    assert change.statement.endswith("(always or reversal): -4 mrad, 40 times the noise")


def test_what_has_no_look_is_said_as_scatter_in_its_size(monitor):
    changed = recorded({}, seconds=14.0, seed=1)
    shown = changed.series["joint_states"]
    shown.position[:, 3] += 3e-3 * np.sin(2 * np.pi * 7.3 * shown.stamp)
    (change,) = fed(monitor, changed, start=151.0)
    assert (change.joint, change.regime, change.unit) == ("joint_4", "scatter", "1")
    rms = np.sqrt(change.size) * change.noise
    assert rms == pytest.approx(3e-3 / np.sqrt(2), rel=0.05)
    assert f"(scatter): {1e3 * rms:.3g} mrad rms" in change.statement


def test_what_is_seen_as_samples_end_is_said(monitor):
    changed = recorded({"zero_offset": {"offset": on(3, 1e-2)}}, seconds=2.0, seed=1)
    assert fed(monitor, changed, start=151.0) == []
    (change,) = monitor.settle()
    assert change.joint == "joint_3"
    assert change.size == pytest.approx(1e-2, rel=0.05)
    assert monitor.settle() == []


def test_after_a_change_what_is_usual_is_learnt_anew_and_said_once(monitor):
    changed = recorded({"zero_offset": {"offset": on(3, 1e-3)}}, seconds=40.0, seed=2)
    assert len(fed(monitor, changed, start=151.0)) == 1
    assert fed(monitor, changed, start=192.0) == []


def test_gaps_missing_joints_and_time_that_jumps_are_no_changes(monitor):
    holes = recorded({}, seconds=30.0, seed=4)
    holes.series["joint_states"].position[500:1500, 1] = np.nan
    assert fed(monitor, holes, start=400.0) == []
    monitor.restart()
    assert fed(monitor, recorded({}, seconds=30.0, seed=5), start=0.0) == []


def test_a_single_glitch_is_no_change(monitor):
    glitch = recorded({}, seconds=20.0, seed=6)
    glitch.series["joint_states"].position[700, 2] += 0.5
    assert fed(monitor, glitch, start=151.0) == []


def test_buffers_do_not_grow(monitor):
    held = [len(s.given.stamps) + len(s.shown.stamps) for s in (monitor.wire.stage, monitor.servo.stage)]
    assert max(held) < 150


def test_false_alarms_come_no_more_often_than_stated():
    rng = np.random.default_rng(0)
    alpha, tests, numbers = 1e-3, 50, 2000
    detector = Detector(tests, alpha, tolerated=0.0, least=0.1)
    everything, begun = np.ones(tests, dtype=bool), np.zeros(tests)
    alarms = 0
    for _ in range(LEARNT + numbers):
        passed = detector.update(rng.normal(size=tests) * 0.2, everything, begun)
        alarms += int(passed.sum())
        detector.evidence[passed] = 0.0
    assert alarms <= alpha * tests * numbers


def test_a_test_waits_until_it_knows_what_is_usual_and_dates_what_it_finds():
    detector = Detector(1, 1e-9, tolerated=1.0, least=0.2)
    ready, when = np.ones(1, dtype=bool), 0.0
    for _ in range(LEARNT + 20):
        assert not detector.update(np.array([5.0]), ready, np.array([when])).any()
        when += 1.0
    assert not detector.update(np.array([5.9]), ready, np.array([when])).any(), "within what is tolerated"
    changed = when + 1.0
    for step in range(3):
        if detector.update(np.array([8.0]), ready, np.array([changed + step])).any():
            break
    assert detector.begun(0) == changed


def test_a_joint_that_stands_keeps_its_last_direction():
    motion = Motion(np.zeros(1))
    speed = np.array([[0.0], [0.1], [0.0], [-0.1], [0.0]])
    told = motion.weights(np.zeros_like(speed), speed)[:, 0, REGIMES.index("reversal")]
    assert told.tolist() == [0.0, 1.0, 1.0, -1.0, -1.0]
    assert motion.direction[0] == -1.0
