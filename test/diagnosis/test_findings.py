"""Findings in the words and units of the recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from test.diagnosis.arms import recorded, reshaped
from trunk_ros.diagnosis import diagnose


def test_a_curve_over_a_sliding_joint_is_in_metres() -> None:
    recording = recorded(seconds=20.0)
    position = recording.series["joint_states"].position.copy()
    position[:, 2] += 1e-3 * np.exp(-0.5 * ((position[:, 2] - 0.05) / 0.05) ** 2)
    recording = reshaped(recording, "joint_states", position=position)
    (found,) = diagnose([replace(recording, units={"joint_3": "m"})]).findings
    assert (found.effect, found.depends_on) == ("unknown", ["position"])
    assert (found.curve["x_unit"], found.curve["y_unit"]) == ("m", "m")
