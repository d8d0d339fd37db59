"""What a motor without an integral part pulls: the weight, and the friction of the wire."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import TRUNK, diagnose, of_the_servos, recorded
from trunk_ros.recording.recording import JointSeries, Recording


@pytest.mark.long
def test_friction_is_found_where_the_weight_alone_explains_next_to_nothing() -> None:
    hidden = {"gain": 0.02, "friction": np.full(5, 0.5), "form": "weight_and_friction"}
    (found,) = diagnose([of_the_servos(recorded({"load_droop": hidden}))], TRUNK).findings
    assert found.effect == "load_droop"
    assert found.parameters["arm"]["gain"]["value"] == pytest.approx(0.02, rel=0.05)
    for joint in found.joints:
        assert found.parameters[joint]["friction"]["value"] == pytest.approx(0.5, rel=0.1)


@pytest.mark.long
def test_a_torque_that_the_drive_feeds_forward_is_no_part_of_what_its_recorded_torque_bends() -> None:
    """An impedance servo, tau = kp (q* - q) - kd q' + tau_ff(q), with tau_ff against a link's weight: no
    error shows for that. Taken for droop, all of the torque had told a gain several times too small.
    """
    t, firm, rng = np.arange(0.0, 60.0, 0.02), 30.0, np.random.default_rng(3)
    asked = 0.4 * np.sin(0.31 * t) + 0.25 * np.sin(0.83 * t + 1.0)
    pushed = 0.6 * np.sin(0.57 * t) + 0.8 * np.sin(1.9 * t)  # N m, from outside
    went = asked.copy()
    for _ in range(50):
        weight = 7.0 * np.sin(went + 0.2)
        fed = 0.95 * weight
        went = asked + (weight + pushed - fed) / -firm
    torque = weight + pushed + 0.02 * rng.standard_normal(len(t))
    series = {
        "setpoints": JointSeries(t, ("j",), asked[:, None]),
        "gearbox_states": JointSeries(
            t, ("j",), (went + 1e-4 * rng.standard_normal(len(t)))[:, None], effort=torque[:, None]
        ),
    }
    result = diagnose([Recording("fed", 0, 60.0, series)], model="direct")
    found = {finding.effect: finding.parameters for finding in result.findings}
    assert set(found) == {"load_droop", "weight_feedforward"}
    assert found["load_droop"]["arm"]["gain"]["value"] == pytest.approx(1.0 / firm, rel=0.05)
    assert found["weight_feedforward"]["j"]["amplitude"]["value"] == pytest.approx(6.65 / firm, rel=0.1)
    joint = result.stages["servo"]["joints"]["j"]
    assert joint["rmse_after"] < 0.1 * joint["rmse_before"]
