"""An arm that goes from station to station, stands, and is read once at each."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import NOISE, RATE
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.diagnosis import diagnose
from trunk_ros.diagnosis.data.align import wire_span
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording

COUNT, STAND, MOVE = 180, 200, 150  # stations, samples of each, and in which the arm moves there


def visited(effects: dict[str, Any] | None = None, seed: int = 0) -> Recording:
    """Setpoints, gearbox and joints, a sample of each just before the arm moves on."""
    model = Model(load_model("trunk").arm, effects or {})
    rng = np.random.default_rng(seed)
    joints, stamp = model.arm.joints, np.arange(COUNT * STAND) / RATE
    stations = np.vstack([np.zeros(len(joints)), rng.uniform(-0.25, 0.25, (COUNT, len(joints)))])
    share = np.clip(np.arange(STAND)[:, None] / MOVE, 0.0, 1.0)
    eased = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    setpoints = np.vstack([a + eased * (b - a) for a, b in itertools.pairwise(stations)])
    phi, _ = Chain(model, "servo").run(setpoints, stamp)
    theta, _ = Chain(model, "wire").run(phi, stamp)
    rows = np.arange(STAND - 1, len(stamp), STAND)
    seen: dict[str, Array] = {
        "setpoints": setpoints[rows],
        "gearbox_states": phi[rows],
        "joint_states": theta[rows] + NOISE * rng.normal(size=(COUNT, len(joints))),
    }
    series = {key: JointSeries(stamp[rows], joints, position) for key, position in seen.items()}
    return Recording("stations", 0, float(stamp[-1]), series)


def test_readings_are_taken_as_they_are_whatever_the_setpoints_say() -> None:
    recording = visited()
    span = wire_span(recording, load_model("trunk"))
    readings = recording.series["gearbox_states"].position
    np.testing.assert_allclose(span.gearbox[span.rows], readings, atol=1e-12)


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("load_elasticity", {"compliance": np.full(5, 0.05)}),
        ("tension_error", {"factor": 3.5}),
        ("backlash", {"half_width": np.full(5, 2e-3)}),
    ],
)
def test_what_differs_from_one_station_to_the_next_is_not_taken_for_noise(
    effect: str, values: dict[str, Any]
) -> None:
    result = diagnose([visited({effect: values})])
    assert effect in {f.effect for f in result.findings} | {e for f in result.findings for e in f.equivalents}
    assert result.verdict in ("explained", "partly_explained")


def test_stations_of_a_nominal_arm_show_nothing() -> None:
    assert diagnose([visited()]).verdict == "no_mismatch"
