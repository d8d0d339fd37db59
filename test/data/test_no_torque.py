"""Effort without a sign, or with a turned one, is said to be that."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import reshaped
from trunk_ros.data.mix_ups import mix_ups, without_mix_ups
from trunk_ros.data.mix_ups.pair import MixUp
from trunk_ros.data.torque import torque_remarks
from trunk_ros.model import load_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.resistance import on_motors, resistance

DIRECT = load_model("direct")
FRICTION = 0.2


def pulled(weight: float = 1.0) -> Recording:
    """40 s of two joints that swing against their weights and friction, with the torques of their motors."""
    t = np.arange(4000) / 100.0
    phi = np.column_stack([0.8 * np.sin(0.9 * t), 0.6 * np.sin(1.3 * t + 1.0)])
    speed = np.gradient(phi, t, axis=0)
    torque = -weight * np.sin(phi) + FRICTION * np.sign(speed) + 0.05 * speed
    torque += 0.01 * np.random.default_rng(2).normal(size=phi.shape)
    series = {"gearbox_states": JointSeries(t, ("a", "b"), phi, None, torque)}
    return Recording("pulled", 0, float(t[-1]), series)


def of(recording: Recording, effort: np.ndarray) -> list[tuple[str, tuple[str, ...], bool]]:
    found = mix_ups(reshaped(recording, "gearbox_states", effort=effort), DIRECT)
    return [(one.kind, one.joints, one.certain) for one in found]


@pytest.mark.parametrize("weight", [1.0, -1.0, 0.0])
def test_a_torque_with_its_sign_is_none_of_these(weight: float) -> None:
    made = pulled(weight)
    effort = made.series["gearbox_states"].effort
    assert effort is not None
    assert of(made, effort) == []
    assert of(made, effort + 2.0) == []  # of a joint that others carry, or a spring


def test_a_magnitude_is_told_and_counts_neither_as_a_torque_nor_as_a_load() -> None:
    """It was the load of servos that stand beyond their setpoints against it."""
    made = pulled()
    effort = made.series["gearbox_states"].effort
    assert effort is not None
    current = np.round(np.abs(effort), 2)  # counts of a servo's current
    assert of(made, current) == [("magnitude", ("a", "b"), False)]
    mixed = reshaped(made, "gearbox_states", effort=current)
    assert "Give it its sign" in mix_ups(mixed, DIRECT)[0].statement
    assert without_mix_ups(mixed, mix_ups(mixed, DIRECT)).series["gearbox_states"].effort is None


def test_the_other_motors_of_an_arm_keep_their_torque() -> None:
    made = pulled()
    told_of = MixUp("magnitude", "servo", ("a",), "effort of a has no sign", certain=False)
    left = without_mix_ups(made, [told_of]).series["gearbox_states"]
    arm = DIRECT.for_joints(("a", "b")).loaded_arm()
    for told in (resistance, on_motors):
        known = told(arm, left, left.stamp, left.position)
        assert known is not None
        assert not known.moment[:, 0].any()
        assert np.ptp(known.moment[:, 1]) > 1.0


def test_a_tension_that_only_ever_pulls_is_no_magnitude() -> None:
    """A wire cannot push: what is left shows the friction of the way up."""
    made = pulled()
    effort = made.series["gearbox_states"].effort
    assert effort is not None
    assert of(made, np.clip(effort, 0.0, None)) == []


def test_friction_that_drives_is_a_turned_sign_and_is_not_printed_as_friction() -> None:
    made = pulled()
    effort = made.series["gearbox_states"].effort
    assert effort is not None
    turned = effort * [1.0, -1.0]
    assert of(made, turned) == [("sign", ("b",), False)]
    mixed = reshaped(made, "gearbox_states", effort=turned)
    assert without_mix_ups(mixed, mix_ups(mixed, DIRECT)) == mixed
    (used,) = (text for text in torque_remarks(mixed, DIRECT) if "less friction" in text)
    assert used.startswith("load from the motors' torque, less friction [N m at the shaft]: a 0.2")
    assert "b" not in used.split(":")[1]
