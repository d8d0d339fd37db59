"""Recordings of one arm are taken together; those that contradict each other are refused, with what does."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import SHORT, reshaped
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence.one_arm import _agree, _lasting, contradiction
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import refit
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.errors import RecordingError
from trunk_ros.recording.recording import Recording

on = partial(arms.on, joints=3)
recorded = partial(arms.recorded, nominal=SHORT)
diagnose = partial(arms.diagnose, model=SHORT)
BACKLASH = {"backlash": {"half_width": on(2, 8e-4)}}


def context(*recordings: Recording) -> Context:
    return first_look(WireStage([wire_span(recording, SHORT) for recording in recordings], SHORT))


def made(effects: dict, seed: int, name: str, size: float = 1.0) -> Recording:
    return recorded(effects, 20.0, seed, name=name, size=size)


def test_the_nominal_simulation_beside_a_real_run_is_named_for_what_it_is() -> None:
    with pytest.raises(RecordingError) as refused:
        diagnose([made({}, 1, "decisive"), made(BACKLASH, 0, "run1")])
    said = str(refused.value)
    assert said.startswith("run1 and decisive are not of one arm: decisive is the nominal simulation")
    assert "What run1 shows on joint_2 (backlash)" in said


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (BACKLASH, {"backlash": {"half_width": on(3, 8e-4)}}),
        (BACKLASH, {"backlash": {"half_width": on(2, 1e-4)}}),
        ({"zero_offset": {"offset": on(3, 2e-3)}}, {"zero_offset": {"offset": on(3, -2e-3)}}),
    ],
)
def test_two_arms_contradict_each_other(one: dict, other: dict) -> None:
    assert contradiction(context(made(one, 0, "a"), made(other, 1, "b")), lambda _: None) is not None


@pytest.mark.parametrize(
    ("effects", "size"),
    [
        (BACKLASH, 1.0),
        (BACKLASH, 0.4),
        ({"load_elasticity": {"compliance": np.full(3, 0.02)}}, 1.0),
        ({"friction_wear": {"rate": on(2, 3e-5)}}, 1.0),
        ({"sensor_delay": {"delay": 0.012}}, 0.5),
        ({}, 1.0),
    ],
)
def test_other_motions_of_one_arm_do_not(effects: dict, size: float) -> None:
    both = context(made(effects, 0, "a"), made(effects, 3, "b", size))
    assert contradiction(both, lambda _: None) is None


@pytest.mark.parametrize(("other", "agree"), [(0.01, True), (0.03, False)])
def test_what_one_set_of_values_explains_is_of_one_arm(other: float, agree: bool) -> None:
    """Whatever the values that one of them alone was bent to."""
    runs = [made({"ratio_error": {"relative": on(2, x)}}, k, "ab"[k]) for k, x in enumerate((0.01, other))]
    found = Hypothesis(ratio_error=Term("ratio_error", own={1: {"relative": 0.02}}))
    fitted = refit(context(runs[0]), found).hypothesis
    assert _agree(context(*runs), context(runs[0]), context(runs[1]), 1, fitted) == agree


def bent(centre: float, seed: int, name: str, zero: float = 0.0) -> Recording:
    """Small motions about an angle of an arm whose joint 2 goes by a parabola, with a zero [rad]."""
    made = recorded({}, 20.0, seed, name=name, size=0.1)
    ratio = SHORT.arm.ratio
    for key, position in ((key, made.series[key].position) for key in ("setpoints", "gearbox_states")):
        made = reshaped(made, key, position=position + centre / ratio)
    theta = made.series["joint_states"].position + centre
    theta[:, 1] += 0.5 * theta[:, 1] ** 2 + zero
    return reshaped(made, "joint_states", position=theta)


def test_what_one_run_says_beyond_where_it_went_is_no_evidence() -> None:
    apart = context(bent(-0.25, 0, "a"), bent(0.25, 1, "b"))
    assert contradiction(apart, lambda _: None) is None
    overlapping = context(bent(0.25, 0, "a"), bent(0.26, 1, "b", zero=-0.04))
    found = contradiction(overlapping, lambda _: None)
    assert found is not None
    assert found.joint == "joint_2"


def test_what_goes_by_no_angle_is_compared_wherever_the_other_went() -> None:
    worn = made(BACKLASH, 0, "a", 0.3)
    clean = made({}, 1, "b", 0.3)
    for key in ("setpoints", "gearbox_states"):
        clean = reshaped(clean, key, position=clean.series[key].position + 0.6 / SHORT.arm.ratio)
    clean = reshaped(clean, "joint_states", position=clean.series["joint_states"].position + 0.6)
    assert contradiction(context(worn, clean), lambda _: None) is not None


def test_what_has_no_name_is_not_carried_over_to_another_motion() -> None:
    """A curve over one motion of a wheel that is out of round in a way of its own holds there."""
    drawn = Hypothesis(
        unknown=Term("unknown", own={0: {}}, words={0: {"on": "position"}}),
        backlash=Term("backlash", own={1: {"half_width": 1e-3}}),
    )
    assert list(_lasting(drawn)) == ["backlash"]
