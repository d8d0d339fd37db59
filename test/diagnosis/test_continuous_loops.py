"""Drives whose loops are not stepped as the nominal servo's are: all of them are 1 to 2 ms later."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import PAIR, SHORT, diagnose, of_the_servos, setpoints_of
from test.diagnosis.arms import recorded as recorded_arm
from trunk_ros.chain import Chain
from trunk_ros.data.sensing.thinned import thinned
from trunk_ros.diagnosis.evidence.as_given import _is_lag
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries, Recording

FINE = 20  # steps between setpoints


def recorded(gain: np.ndarray, seconds: float = 15.0, read: int = 1) -> Recording:
    """Setpoints at 100 Hz and what drives of so much of the nominal ``gain`` (joints,) make of them, ``read``
    times as often.
    """
    arm = SHORT.arm
    asked = setpoints_of(seconds, len(arm.joints))
    stamp = np.arange(len(asked) * FINE) * 0.01 / FINE
    phi, _ = Chain(Model(replace(arm, kp=gain * arm.kp)), "servo").run(np.repeat(asked, FINE, axis=0), stamp)
    step, rows = 2.0 * np.pi / arm.counts_per_rev, slice(None, None, FINE // read)
    series = {
        "setpoints": JointSeries(stamp[::FINE], arm.joints, asked),
        "gearbox_states": JointSeries(stamp[rows], arm.joints, step * np.round(phi[rows] / step)),
    }
    return Recording("made", 0, seconds, series)


def test_they_are_as_described() -> None:
    assert not diagnose([recorded(np.ones(3))], SHORT).findings


@pytest.mark.long
def test_one_that_is_slower_is_told_alone() -> None:
    (found,) = diagnose([recorded(np.array([1.0, 0.7, 1.0]))], SHORT).findings
    assert (found.effect, found.joints) == ("servo_bandwidth", ["joint_2"])
    relative = found.parameters["joint_2"]["relative"]
    assert relative["value"] == pytest.approx(-0.3, abs=0.02)
    assert abs(relative["value"] + 0.3) < 2.0 * relative["std"], "by as much as the nominal steps are ahead"
    assert found.confidence > 0.9


def test_their_setpoints_came_as_they_were_recorded() -> None:
    """The nominal servo's steps between readings make stairs that such drives do not have."""
    series = recorded(np.ones(3), read=2).series
    assert thinned(series["setpoints"], series["gearbox_states"], SHORT) is None


@pytest.mark.parametrize(("relative", "told"), [(0.03, True), (-0.01, False)])
def test_a_loop_that_is_quicker_is_no_continuous_one(relative: float, told: bool) -> None:
    """That is 1.4 ms ahead; one that is half a millisecond behind may be."""
    hidden = {"servo_bandwidth": {"relative": relative}}
    found = diagnose([of_the_servos(recorded_arm(hidden, nominal=PAIR))], PAIR).findings
    assert [f.effect for f in found] == (["servo_bandwidth"] if told else [])


@pytest.mark.parametrize(("last", "lags"), [(0.9, True), (0.0, False)])
def test_what_is_not_nearly_all_along_a_loops_lag_is_none(last: float, lags: bool) -> None:
    """Joints that often go as fast as they can are behind by it as by a lag, but for where they do not."""
    assert _is_lag({0: np.array([1.0, 1.0, 1.0, last])}, {0: np.ones(4)}) == lags
