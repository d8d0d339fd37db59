"""Slides and fine scales: steps and periods are those of the data, not those of some rotary encoder."""

from __future__ import annotations

import numpy as np
import pytest

from trunk_ros.compiled import Array
from trunk_ros.diagnosis import diagnose
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.effects.periods import finest
from trunk_ros.recording.recording import Recording

STAMP = np.arange(0.0, 60.0, 0.01)
MOTOR = 20.0 * np.sin(2 * np.pi * 0.1 * STAMP) + 6.0 * np.sin(2 * np.pi * 0.37 * STAMP)  # mm
NOISE = 2e-4  # mm


def found(off: Array) -> Diagnosis:
    joint = MOTOR + off + NOISE * np.random.default_rng(0).normal(size=len(STAMP))
    recording = Recording.from_arrays(STAMP, motor=MOTOR, joint=joint, unit="mm")
    return diagnose(recording, model="direct", experiments=False)


def test_a_dead_band_of_a_slide_far_below_the_steps_of_a_rotary_encoder_is_found() -> None:
    half, out, at = 0.01, np.empty_like(MOTOR), MOTOR[0]
    for k, x in enumerate(MOTOR):
        at = out[k] = min(max(at, x - half), x + half)
    (finding,) = found(out - MOTOR).findings
    assert finding.effect == "backlash"
    assert finding.parameters["joint_1"]["half_width"]["value"] == pytest.approx(1e-5, rel=0.02)


def test_the_ripple_of_a_lead_screw_is_found() -> None:
    (finding,) = found(0.02 * np.sin(2 * np.pi * MOTOR / 5.0)).findings
    said = {name: told["value"] for name, told in finding.parameters["joint_1"].items()}
    assert finding.effect == "transmission_ripple"
    assert said["amplitude"] == pytest.approx(2e-5, rel=0.02)
    assert said["cycles_per_rev"] == pytest.approx(2 * np.pi / 5e-3, rel=1e-3)
    units = {name: told["unit"] for name, told in finding.parameters["joint_1"].items()}
    assert units["amplitude"] == "m"
    assert units["phase"] == "rad"
    assert units["cycles_per_rev"] == "1/(2 pi m)"


@pytest.mark.parametrize(("unit", "size"), [("mm", 1e-3), ("1", 1.0)])
def test_a_ripple_of_which_two_periods_are_seen_far_from_zero_is_found_in_any_unit(
    unit: str, size: float
) -> None:
    """Its phase at angle 0 turns by 160 periods with the order, which is found all the same; its zero is
    further off than that of a joint that turns could be.
    """
    motor = 40.0 + 0.3 * np.sin(2 * np.pi * 0.1 * STAMP)
    off = 0.02 * np.sin(2 * np.pi * motor / 0.25 + 1.0) - 42.0
    joint = motor + off + NOISE * np.random.default_rng(0).normal(size=len(STAMP))
    recording = Recording.from_arrays(STAMP, motor=motor, joint=joint, unit=unit)
    found = {one.effect: one for one in diagnose(recording, model="direct", experiments=False).findings}
    said = {name: one.parameters["joint_1"] for name, one in found.items()}
    assert said.keys() == {"zero_offset", "transmission_ripple"}
    assert said["zero_offset"]["offset"]["value"] == pytest.approx(-42.0 * size, rel=1e-4)
    ripple = {name: told["value"] for name, told in said["transmission_ripple"].items()}
    assert ripple["amplitude"] == pytest.approx(0.02 * size, rel=0.02)
    assert ripple["cycles_per_rev"] == pytest.approx(2 * np.pi / 0.25 / size, rel=1e-3)
    assert abs(ripple["phase"]) <= np.pi


def test_a_slide_with_nothing_missing_has_no_finding() -> None:
    assert found(np.zeros_like(MOTOR)).verdict == "no_mismatch"


def test_periods_are_as_fine_as_the_samples_of_a_moving_shaft_show() -> None:
    rests = np.concatenate([np.zeros(500), np.arange(500) * 1e-3, np.full(500, 0.5)])
    assert finest(rests) == pytest.approx(2 * np.pi / 4e-3, rel=0.01)
    assert finest(np.zeros(9)) == 0.0
