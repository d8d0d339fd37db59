"""A lag beside wide loops is believed where nothing else leaves only noise."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import setpoints_of
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.search.descent import Desk
from trunk_ros.diagnosis.search.greedy import told_by_speed
from trunk_ros.diagnosis.search.long import WORK, granted
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording

JOINTS = ("shoulder", "elbow", "wrist")


def looked_at(effects: dict[str, Any], phi: Array) -> Context:
    """An arm of which nothing is known, whose motors went ``phi`` (n, joints) rad at 100 Hz."""
    joints = JOINTS[: phi.shape[1]]
    model, stamp = load_model("direct").for_joints(joints), np.arange(len(phi)) / 100
    theta, _ = Chain(Model(model.arm, effects), "wire").run(phi, stamp)
    theta = theta + 1e-4 * np.random.default_rng(0).standard_normal(theta.shape)
    series = {n: JointSeries(stamp, joints, x) for n, x in (("gearbox_states", phi), ("joint_states", theta))}
    span = wire_span(Recording("run", 0, float(stamp[-1]), series), model)
    context = replace(first_look(WireStage([span], model)), work=granted())
    assert not context.speed_tells
    return context


@pytest.mark.long
def test_late_readings_of_a_short_recording_are_no_wide_loop() -> None:
    """Without what goes by speed, names and curves had been fitted to them for a minute."""
    late = {
        "sensor_delay": {"delay": 0.03},
        "ratio_error": {"relative": np.array([0.03, 0.0])},
        "backlash": {"half_width": np.array([0.0, 4e-3])},
    }
    context = looked_at(late, setpoints_of(7.0, 2))
    found = told_by_speed(context, Desk())
    assert found is not None
    assert found.hypothesis.keys() == late.keys()
    assert found.hypothesis["sensor_delay"].shared["delay"] == pytest.approx(0.03, rel=0.01)
    assert context.work.most - context.work.done == pytest.approx(WORK), "it is no part of what is granted"


def test_a_wide_play_under_one_swing_is_a_wide_loop() -> None:
    stamp = np.arange(1500)[:, None] / 100
    swing = np.array([0.5, 0.4]) * np.sin(2.0 * np.pi * np.array([0.3, 0.23]) * stamp)
    context = looked_at({"backlash": {"half_width": np.array([0.12, 0.1])}}, swing)
    assert told_by_speed(context, Desk()) is None


def test_late_readings_of_wide_plays_under_one_swing() -> None:
    """A lag or another joint's motion, each taken before the plays, had kept their place."""
    stamp = np.arange(1500)[:, None] / 100
    swing = np.array([0.5, 0.4]) * np.sin(2.0 * np.pi * 0.3 * stamp + np.array([0.0, 2.0]))
    late = {"sensor_delay": {"delay": 0.1}, "backlash": {"half_width": np.array([0.15, 0.05])}}
    found = told_by_speed(looked_at(late, swing), Desk())
    assert found is not None
    assert found.hypothesis.keys() == late.keys()
    assert found.hypothesis["sensor_delay"].shared["delay"] == pytest.approx(0.1, rel=0.01)


def test_a_lag_is_no_mixture_of_joints_that_swing_as_often() -> None:
    """With ratios that are off as well, each of three joints had been coupled to the others."""
    stamp = np.arange(3000)[:, None] / 100
    swing = np.array([0.5, 0.4, 0.3]) * np.sin(2.0 * np.pi * 0.3 * stamp + np.array([0.0, 1.0, 2.2]))
    late = {
        "sensor_delay": {"delay": 0.06},
        "ratio_error": {"relative": np.array([0.05, -0.03, 0.02])},
        "backlash": {"half_width": np.array([0.1, 0.06, 0.04])},
    }
    found = told_by_speed(looked_at(late, swing - swing[0]), Desk())
    assert found is not None
    assert found.hypothesis.keys() == late.keys()
    assert not found.context.alone, "what follows may look at other joints"
