"""Claims about drives whose ratio nobody knew: what is told of them goes by the ratio that was found."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import NOISE, diagnose, of_the_wires, on, recorded
from test.diagnosis.search.looks import context
from test.effects.example import arm_of
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.sparse import Sparse
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording

RATIO = 0.1
COARSE = replace(arm_of(2, dead_band=0.0), ratio=np.full(2, RATIO), counts_per_rev=4096)
WIDTH = 4.0 * NOISE


def geared_down(effects: dict[str, Any]) -> Recording:
    """Wires behind a gear, whose motors are read as coarsely as the joints are noisy, but for the gear."""
    return of_the_wires(recorded(effects, nominal=Model(COARSE)))


def test_an_encoders_step_is_as_fine_at_the_joint_as_the_ratio_that_was_found() -> None:
    start, found = context("clean"), Hypothesis(ratio_error=Term("ratio_error", own={2: {"relative": -0.9}}))
    seen = start.weighed(found)
    assert seen.resolution[2] == pytest.approx(0.1 * start.resolution[2])
    assert seen.resolution[1] == start.resolution[1]
    every = Sparse(*(getattr(start, name) for name in ("stage", "views", "noise")), denser=start, every=2)
    assert every.weighed(found).resolution == seen.resolution


@pytest.mark.parametrize("ratio", [RATIO, 1.0])
def test_what_is_small_beside_a_motors_step_is_found_behind_a_gear_that_nobody_stated(ratio: float) -> None:
    """At the motor a count is four times the dead band, at the joint a fourth of it."""
    seen = geared_down({"backlash": {"half_width": on(1, WIDTH, 2)}})
    found = diagnose([seen], Model(replace(COARSE, ratio=np.full(2, ratio))))
    (play,) = (f for f in found.findings if f.effect == "backlash")
    assert play.joints == ["joint_1"]
    assert found.model.effects["backlash"]["half_width"][0] == pytest.approx(WIDTH, rel=0.1)
    assert found.verdict == "explained"


def test_what_formulas_may_be_off_by_is_not_hidden_by_what_motors_read_by_chance() -> None:
    """At the motor it is fifty times the joint's noise, and hid what the joint does."""
    seen = geared_down({"backlash": {"half_width": on(1, 20.0 * NOISE, 2)}})
    motors = seen.series["gearbox_states"]
    chance = np.random.default_rng(3).normal(0.0, 50.0 * NOISE, motors.position.shape)
    motors = replace(motors, position=motors.position + chance, velocity=None)
    noisy = replace(seen, series=seen.series | {"gearbox_states": motors})
    looks = []
    for ratio in (RATIO, 1.0):
        model = Model(replace(COARSE, ratio=np.full(2, ratio), counts_per_rev=0))
        looks.append(begun(first_look(WireStage([wire_span(noisy, model)], model))).context)
    told, found = (look.formed_misfit[0] * look.noise[0].std ** 2 for look in looks)
    assert found == pytest.approx(told, rel=0.15)  # less what looks like another ratio
