"""Where two recordings of the same run differ."""

import numpy as np
import pytest

from trunk_ros.recording.compare import differences, table
from trunk_ros.recording.recording import JointSeries, PoseSeries, Recording

STAMP = np.arange(5) * 0.1
START = 1_750_000_000 * 10**9


def recording(position, joints=("a", "b"), start_ns=START, stamp=STAMP, tip=None):
    series = {"joint_states": JointSeries(stamp, joints, position)}
    return Recording("test", start_ns, 0.4, series, tip)


def waves():
    return np.outer(STAMP, [1.0, 2.0])


def test_the_same_run_does_not_differ():
    (found,) = differences(recording(waves()), recording(waves()))
    assert (found.compared, found.recorded, found.largest, found.rms) == (5, 5, 0.0, 0.0)


def test_the_largest_difference_is_found_with_its_joint_and_time():
    other = waves()
    other[3, 1] += 0.5
    (found,) = differences(recording(waves()), recording(other))
    assert (found.largest, found.name, found.stamp) == (pytest.approx(0.5), "b", pytest.approx(0.3))
    assert found.rms == pytest.approx(0.5 / np.sqrt(10))
    assert "joint_states  position  5 of 5" in table([found])[1]
    assert "b at 0.300 s" in table([found])[1]


def test_joints_are_matched_by_name_and_samples_by_stamp():
    other = recording(waves()[1:, ::-1], ("b", "a"), START + 10**8, STAMP[:4])
    (found,) = differences(recording(waves()), other)
    assert (found.compared, found.recorded) == (4, 5)
    assert found.largest == 0.0


def test_what_cannot_be_compared_is_not_called_the_same():
    (found,) = differences(recording(waves()), recording(waves(), start_ns=START + 5))
    assert found.compared == 0
    assert np.isnan(found.largest)
    assert differences(recording(waves()), recording(waves(), ("c", "d"))) == []


def test_the_tip_is_compared_too():
    tip = PoseSeries(STAMP, np.zeros((5, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (5, 1)))
    moved = PoseSeries(STAMP, np.tile([0.0, 0.01, 0.0], (5, 1)), tip.orientation)
    found = differences(recording(waves(), tip=tip), recording(waves(), tip=moved))[1]
    assert (found.topic, found.unit, found.largest, found.name) == ("trunk/tip_pose", "m", 0.01, "y")
