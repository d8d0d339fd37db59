"""Dead bands that shrink as grease warms up: the formula, and from a recording to another motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, of_the_wires, on, recorded
from test.effects.example import arm_of
from trunk_ros.chain import Chain
from trunk_ros.effects import effect, imitated
from trunk_ros.effects.effect import Motion
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.model import Model
from trunk_ros.simulate import simulate

BAND, FALL, CONSTANT = 1.5e-3, 7e-4, 12.0  # rad, rad, s
STAMP = np.arange(3001) * 0.01
THETA = 0.2 * np.sin(np.minimum(STAMP, 20.0))[:, None]


def _of(form: str, joints: int = 1, joint: int = 1, fall: float = FALL) -> dict[str, dict[str, object]]:
    """On one joint, of a mean speed of 0.1 rad/s."""
    speed = {"speed": np.full(joints, 0.1)} if form == "heated" else {}
    constant = np.full(joints, CONSTANT)
    return {
        "friction_warming": {
            "form": form,
            "fall": on(joint, fall, joints),
            "time_constant": constant,
            **speed,
        }
    }


@pytest.mark.parametrize("form", ["exponential", "heated"])
def test_the_dead_band_shrinks_in_blocks_as_in_one_piece(form: str) -> None:
    chain = Chain(Model(arm_of(1, BAND), _of(form)), "wire")
    whole, _ = chain.run(THETA / 0.625, STAMP)
    first, state = chain.run(THETA[:1234] / 0.625, STAMP[:1234])
    second, _ = chain.run(THETA[1234:] / 0.625, STAMP[1234:], state)
    assert np.abs(np.concatenate([first, second]) - whole).max() < 1e-12
    if form == "exponential":
        width = BAND + FALL * np.expm1(-STAMP[:, None] / CONSTANT)
        assert np.abs(SharpPlay().run(THETA, width, None)[0] - whole).max() < 1e-12


def test_it_comes_back_in_a_pause_where_motion_heats_and_never_falls_below_nothing() -> None:
    at_first, warm, rested = np.arange(0, 700), np.arange(1300, 2000), np.arange(2100, 2800)
    again = np.concatenate([THETA[:2000], np.repeat(THETA[1999:2000], 12000, axis=0), THETA[2000:0:-1]])
    stamp = np.arange(len(again)) * 0.01
    chain = Chain(Model(arm_of(1, BAND), _of("heated")), "wire")
    behind = np.abs(chain.run(again / 0.625, stamp)[0] - again)[:, 0]
    later = rested + 14000 - 2100
    assert np.median(behind[warm]) < 0.8 * np.median(behind[at_first])
    assert np.median(behind[later]) > 1.1 * np.median(behind[warm])
    gone = Chain(Model(arm_of(1, BAND), _of("exponential", fall=3e-2)), "wire")
    assert np.abs(gone.run(THETA / 0.625, STAMP)[0] - THETA)[300:].max() < 1e-12


def test_a_place_that_is_passed_once_shows_nothing_of_it() -> None:
    assert effect("friction_warming").forms_shown(Motion(once=True)) == ()


@pytest.mark.parametrize("form", ["exponential", "heated"])
def test_friction_that_falls_as_it_warms_is_named_and_predicts_another_motion(form: str) -> None:
    """It had been a narrow_band in three sizes, at one half."""
    arm = replace(SHORT.arm, dead_band=np.full(3, BAND))
    model = Model(arm)
    hidden = _of(form, 3, 2)
    result = diagnose([of_the_wires(recorded(hidden, seconds=60.0, noise=5e-5, nominal=model))], model=model)
    (found,) = result.findings
    assert (found.effect, found.joints) == ("friction_warming", [arm.joints[1]])
    assert found.parameters[arm.joints[1]]["time_constant"]["value"] == pytest.approx(CONSTANT, rel=0.2)
    other = recorded(hidden, seconds=60.0, seed=5, noise=0.0, nominal=model)
    shown = simulate(other, result.model).series["joint_states"].position
    off = np.abs(shown - other.series["joint_states"].position)[600:, 1]
    before = np.abs(
        simulate(other, model).series["joint_states"].position - other.series["joint_states"].position
    )
    assert off.max() < 1e-4
    assert before[600:, 1].max() > 4e-4


def test_what_skewed_clocks_look_like_is_a_dead_band_that_grows_or_one_that_shrinks() -> None:
    assert {"friction_wear", "friction_warming"} <= set(imitated("skew"))
