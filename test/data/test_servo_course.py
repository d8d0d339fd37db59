"""Where a motor was read counts more than where its model's servo would have gone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from test.diagnosis.arms import TRUNK, recorded
from trunk_ros.data.align import wire_span
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.resample import resample


def test_what_a_servo_swings_by_beside_its_model_hides_not_where_it_stops_short() -> None:
    recording = recorded(seconds=30.0)
    gearbox = recording.series["gearbox_states"]
    swings = np.where(gearbox.stamp < 20.0, 0.3 * np.sin(2 * np.pi * 1.5 * gearbox.stamp), 0.004)
    own = JointSeries(gearbox.stamp, gearbox.joints, gearbox.position + swings[:, None])
    span = wire_span(replace(recording, series={**recording.series, "gearbox_states": own}), TRUNK)
    read, _ = resample(own, span.grid)
    assert np.abs(span.source - read)[span.grid > 21.0].max() < 1e-3
