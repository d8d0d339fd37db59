"""Shafts that something else than their setpoints drives are told as such, and nothing is said of their
servos; servos that are slow, weak, saturated or loaded follow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, reshaped
from test.diagnosis.test_nominal_servo import JOINTS, NOISE, PLAIN, _asked, recorded_servos
from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups import mix_ups
from trunk_ros.model import load_model
from trunk_ros.recording.recording import Recording

DIRECT = load_model("direct")


def elsewhere(recording: Recording, joints: tuple[int, ...], size: float = 3.0) -> Recording:
    """Motors that a torque drives: where nobody asked them to go."""
    series = recording.series["gearbox_states"]
    went, other = series.position.copy(), size * _asked(series.stamp, seed=99)
    went[:, joints] = (other + NOISE * np.random.default_rng(1).standard_normal(other.shape))[:, joints]
    return reshaped(recording, "gearbox_states", position=went)


def loaded(went: Array, stamp: Array, asked: Array) -> Array:
    """A third of the way that was asked, beside what a load makes of it, which is more."""
    return went / 3.0 + 1.2 * np.std(asked, axis=0) / 3.0 * np.sin(2 * np.pi * stamp / 1.7)[:, None]


@pytest.mark.parametrize("seed", range(1, 4))
@pytest.mark.parametrize("joints", [(0, 1, 2), (1,)])
def test_motors_that_go_elsewhere_are_told(joints: tuple[int, ...], seed: int) -> None:
    (told,) = mix_ups(elsewhere(recorded_servos(PLAIN, seed, seconds=60.0), joints), DIRECT)
    assert (told.kind, told.stage, told.certain) == ("unled", "servo", True)
    assert told.joints == tuple(JOINTS[j] for j in joints)
    assert "does not follow trunk/setpoints" in told.statement


@pytest.mark.parametrize(
    "servo",
    [
        {},
        {"kp": (0.5,) * 3},
        {"kp": (5.0,) * 3, "delay": (0.3,) * 3},
        {"v_max": (0.05,) * 3},
        {"kp": (5.0,) * 3, "tau_v": (0.2,) * 3},
    ],
    ids=["sound", "slow", "late", "saturated", "swinging"],
)
def test_servos_that_follow_are_none(servo: dict[str, tuple[float, float, float]]) -> None:
    for seed in range(1, 5):
        assert mix_ups(recorded_servos(PLAIN | servo, seed), DIRECT) == []


def test_servos_that_droop_or_stand_or_bear_a_load_are_none() -> None:
    assert mix_ups(recorded_servos(PLAIN, pulled=0.9), DIRECT) == []
    made = recorded_servos(PLAIN, seconds=120.0)
    series = made.series["gearbox_states"]
    standing = NOISE * np.random.default_rng(2).standard_normal(series.position.shape)
    assert mix_ups(reshaped(made, "gearbox_states", position=standing), DIRECT) == []
    asked = made.series["setpoints"].position
    assert (
        mix_ups(
            reshaped(made, "gearbox_states", position=loaded(series.position, series.stamp, asked)), DIRECT
        )
        == []
    )


def test_nothing_is_said_of_such_a_servo_and_the_others_are_judged(tmp_path: Path) -> None:
    told = diagnose([elsewhere(recorded_servos(PLAIN, seconds=20.0), (1,))], DIRECT)
    assert [(rest.stage, rest.joints) for rest in told.unexplained] == [("servo", [JOINTS[1]])]
    assert set(told.stages["servo"]["joints"]) == {JOINTS[0], JOINTS[2]}
    assert told.stages["servo"]["silent"] == []
    kp = np.broadcast_to(told.model.arm.kp, 3)
    assert kp[1] == np.broadcast_to(DIRECT.arm.kp, 1)[0]  # what it was
    assert kp[[0, 2]] == pytest.approx(20.0, rel=0.05)
    told.save(tmp_path)
    assert load_model(tmp_path / "model.yaml").hash() == told.model.hash()


def test_where_no_servo_is_led_all_is_unexplained_without_a_search() -> None:
    told = diagnose([elsewhere(recorded_servos(PLAIN, seconds=60.0), (0, 1, 2))], DIRECT)
    assert (told.verdict, told.findings) == ("unexplained", [])
    assert not told.stages["servo"]["compared"]
