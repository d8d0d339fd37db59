"""Readings that never move, or that were given twice, are said to be that and are no physics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, on, recorded, reshaped
from trunk_ros.data.mix_ups import mix_ups, without_mix_ups
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import Recording

TRUNK, DIRECT = load_model("trunk"), load_model("direct")
NOISE = np.random.default_rng(3).normal(size=3000)


@pytest.fixture(scope="module")
def good() -> Recording:
    return recorded({"backlash": {"half_width": on(2, 8e-4)}}, 30.0)


def standing(recording: Recording, key: str, joints: list[int], noise: float = 0.0) -> Recording:
    """With readings of some joints that never move."""
    position = recording.series[key].position.copy()
    position[:, joints] = 0.05 + noise * NOISE[: len(position), None]
    return reshaped(recording, key, position=position, velocity=None)


def told(recording: Recording, model: Model = TRUNK) -> list[tuple[str, str, tuple[str, ...]]]:
    return [(one.kind, one.stage, one.joints) for one in mix_ups(recording, model) if one.certain]


@pytest.mark.parametrize("model", [TRUNK, DIRECT])
@pytest.mark.parametrize("noise", [0.0, 3e-4])
def test_a_joint_that_never_moves_while_its_motor_does_is_told(
    good: Recording, model: Model, noise: float
) -> None:
    """It was a ratio of nothing."""
    mixed = standing(good, "joint_states", [1, 3], noise)
    assert told(mixed, model) == [("stuck", "wire", ("joint_2", "joint_4"))]
    said = mix_ups(mixed, model)[0].statement
    assert said.startswith(
        "joint_states of joint_2, joint_4 never moves, while trunk/gearbox_states goes up to"
    )
    left = without_mix_ups(mixed, mix_ups(mixed, model)).series["joint_states"].position
    assert np.isnan(left[:, [1, 3]]).all()
    assert np.isfinite(left[:, [0, 2, 4]]).all()


def test_a_dead_joint_is_not_diagnosed_and_the_others_are() -> None:
    made = recorded({"backlash": {"half_width": on(2, 4e-3, 3)}}, 20.0, nominal=SHORT)
    found = diagnose([standing(made, "joint_states", [0], 3e-4)], SHORT)
    assert {joint for one in found.findings for joint in one.joints} == {"joint_2"}
    assert "never moves" in found.unexplained[0].statement
    assert list(found.stages["wire"]["joints"]) == ["joint_2", "joint_3"]


@pytest.mark.parametrize("joints", [[0, 1, 2, 3, 4], [2]])
def test_a_motor_that_never_moves_while_its_joint_swings_is_told(good: Recording, joints: list[int]) -> None:
    """It was a curve over time without a name."""
    mixed = standing(good, "gearbox_states", joints)
    names = tuple(f"joint_{j + 1}" for j in joints)
    assert told(mixed) == [("stuck", "wire", names), ("stuck", "servo", names)]
    asked = without_mix_ups(mixed, mix_ups(mixed, TRUNK)).series["setpoints"].position
    assert np.isnan(asked[:, joints]).all()


def test_motors_that_stand_while_others_a_load_or_time_move_their_joints_are_none(good: Recording) -> None:
    """Such joints are judged, as are those that move less than a wire yields."""
    rests, names = standing(good, "gearbox_states", [2]), ("gearbox_states", "joint_states")
    rests = replace(rests, series={key: rests.series[key] for key in names})
    shown = rests.series["joint_states"]
    others, stamp = shown.position[:, 0], shown.stamp
    for moved in (0.5 * others, 0.3 * np.sin(others), 0.2 * (stamp / 30.0) ** 2, 0.02 * np.sin(stamp)):
        position = shown.position.copy()
        position[:, 2] = moved + 3e-4 * NOISE
        assert told(reshaped(rests, "joint_states", position=position)) == []
    effort = np.full_like(shown.position, np.nan)
    effort[:, 2] = np.sin(stamp)
    assert told(reshaped(rests, "joint_states", effort=effort)) == []


def test_readings_at_random_places_are_not_stuck() -> None:
    """From stop to stop they are as white as noise."""
    stamp = np.arange(180.0)
    motor = np.random.default_rng(5).uniform(-0.3, 0.3, (180, 5))
    series = recorded(seconds=2.0).series
    joint = replace(series["joint_states"], stamp=stamp, position=motor * TRUNK.arm.ratio)
    sides = {"gearbox_states": replace(joint, position=motor), "joint_states": joint}
    assert told(Recording("stops", 0, 179.0, sides)) == []


def test_swapped_columns_of_a_joint_at_rest_stay_swapped(good: Recording) -> None:
    rests = standing(standing(good, "gearbox_states", [1]), "joint_states", [1], 1e-4)
    columns = rests.series["joint_states"].position[:, [0, 2, 1, 3, 4]]
    kinds = told(reshaped(rests, "joint_states", position=columns))
    assert kinds[0] == ("order", "wire", ("joint_2", "joint_3"))


def test_motors_given_for_joints_are_told_digit_by_digit(good: Recording) -> None:
    """They were a ratio twice as large. Where the model has the two alike it may be an ideal simulator."""
    motors = good.series["gearbox_states"].position
    mixed = reshaped(good, "joint_states", position=motors)
    assert told(mixed) == [("copy", "wire", good.joints)]
    assert [(one.kind, one.certain) for one in mix_ups(mixed, DIRECT)] == [("copy", False)]
    one_digit = np.nextafter(motors, np.inf)
    assert not any(
        one.kind == "copy" for one in mix_ups(reshaped(good, "joint_states", position=one_digit), TRUNK)
    )
