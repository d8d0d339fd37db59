"""Named trajectories."""

import numpy as np
import pytest

from trunk_ros.model import load_model
from trunk_ros.motion import NAMES, begun_from, named_trajectory
from trunk_ros.nodes.control.follower import limits_of
from trunk_ros.nodes.run.arguments import TRAJECTORIES
from trunk_ros.trajectory import Limits, TrajectoryError

ARM = load_model("trunk").arm
TOP = ARM.v_max * ARM.ratio


def test_the_default_moves_all_joints_with_sweeps_fast_moves_reversals_and_holds():
    position, velocity, _ = named_trajectory("default", ARM, 60.0).sample(np.arange(0, 60, 0.01))
    assert (np.ptp(position, axis=0) > 0.7 * (ARM.upper - ARM.lower)).all()
    assert (np.abs(velocity).max(axis=0) > 0.7 * TOP).all()
    moving = np.sign(np.where(np.abs(velocity) > 1e-3, velocity, 0.0))
    for joint in moving.T:
        directions = joint[joint != 0]
        assert np.count_nonzero(np.diff(directions)) > 20
        assert np.count_nonzero(joint == 0) * 0.01 > 4.0


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seconds", [2.0, 7.0, 45.0])
def test_every_motion_stays_within_time_and_limits(name, seconds):
    trajectory = named_trajectory(name, ARM, seconds)
    assert trajectory.duration <= seconds
    trajectory.check(Limits(ARM.lower, ARM.upper, TOP, np.full(5, 30.0)))


def test_joints_do_not_move_alike():
    position = named_trajectory("default", ARM, 30.0).sample(np.arange(0, 30, 0.02))[0]
    assert np.abs(np.corrcoef(position.T) - np.eye(5)).max() < 0.35


def test_an_unknown_name_is_answered_with_those_that_there_are():
    with pytest.raises(TrajectoryError, match="default, sweeps, fast"):
        named_trajectory("waltz", ARM, 10.0)


def test_the_help_of_bringup_names_every_motion() -> None:
    assert TRAJECTORIES == NAMES


def test_an_arm_that_stands_elsewhere_is_led_to_where_a_motion_begins():
    motion, still = named_trajectory("default", ARM, 20.0), np.zeros(len(ARM.joints))
    for away in (0.0, 1e-3):
        assert begun_from(motion, ARM, dict(zip(ARM.joints, ARM.rest + away, strict=True))) is motion
    there = ARM.rest + np.array([0.0, 0.4, 0.0, -0.3, 0.0])
    led = begun_from(motion, ARM, dict(zip(ARM.joints, there, strict=True)))
    assert np.ptp(led.time) == pytest.approx(np.ptp(motion.time))
    with pytest.raises(TrajectoryError, match="its limit"):
        motion.after(there, still, still).check(limits_of(ARM, np.inf))
    led.after(there, still, still).check(limits_of(ARM, np.inf))
