"""What a rest depends on."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, recorded
from test.diagnosis.search.looks import fitted
from trunk_ros.data.align import servo_span
from trunk_ros.data.motion_content import PLACES
from trunk_ros.diagnosis import diagnose
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence.cross_validation import Error
from trunk_ros.diagnosis.evidence.residual_dependence import accounted, goes_on, rests
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.diagnosis.verdict.answer import Unexplained
from trunk_ros.diagnosis.verdict.findings import _unexplained, left_over, without_a_name
from trunk_ros.levels import SLIGHT
from trunk_ros.model import load_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.servo_course import servo_course


@pytest.mark.parametrize("count", [20 * PLACES, 600, 6000])
def test_noise_depends_on_nothing(count: int) -> None:
    rng = np.random.default_rng(count)
    shares = [accounted(rng.normal(size=count), rng.normal(size=count)) for _ in range(200)]
    assert np.mean(np.array(shares) > SLIGHT) < 0.05


def test_coloured_noise_depends_on_nothing_that_moves_slowly() -> None:
    rng, pole = np.random.default_rng(0), 0.95
    over = 0
    for _ in range(100):
        noise, x = rng.normal(size=3000), np.sin(np.linspace(0, 20 * rng.uniform(0.5, 1), 3000))
        for k in range(1, len(noise)):
            noise[k] += pole * noise[k - 1]
        over += accounted(x, noise, pole) > SLIGHT
    assert over < 10


def test_what_depends_on_a_variable_is_found_with_its_share() -> None:
    rng = np.random.default_rng(1)
    x = rng.uniform(-1, 1, 4000)
    residual = np.sqrt(3.0) * x + rng.normal(size=4000)  # half of the power
    assert accounted(x, residual) == pytest.approx(0.5, abs=0.04)


def test_noise_that_comes_in_bursts_does_not_go_on_and_a_small_wave_does() -> None:
    rng = np.random.default_rng(6)
    often = 0
    for _ in range(200):
        noise = rng.normal(size=6000) * np.where((np.arange(6000) // 500) == 4, 10.0, 1.0)
        often += goes_on(noise[1:] * noise[:-1], 0.0, 0.05)
    assert often <= 2
    wave = rng.normal(size=6000) + np.sin(np.arange(6000) / 50.0)
    assert goes_on(wave[1:] * wave[:-1], 0.0, 0.05)


def test_what_is_left_of_a_large_misfit_is_not_said_as_none_of_it() -> None:
    rest = _unexplained("wire", ["position"], [("elbow", 3e-4, 14.0)])
    assert rest.share == 3e-4
    assert rest.statement.startswith(
        "elbow (wire): less than 0.1% of the residual's power, 14 times the noise, stays unexplained"
    )
    assert "0.1% of the" in _unexplained("wire", [], [("elbow", 1e-3, 14.0)]).statement


def test_of_a_servo_whose_loop_was_found_first_the_rest_is_a_share_of_what_that_leaves() -> None:
    t = np.arange(0.0, 20.0, 0.01)
    asked = JointSeries(t, ("wrist",), np.sin(t)[:, None])
    wanders = 0.02 * np.sin(9.0 * t + 3.0 * np.sin(1.7 * t))
    wanders += np.random.default_rng(0).normal(0.0, 1e-4, len(t))
    went = servo_course(asked, t, load_model("direct").for_joints(("wrist",)))
    series = {"setpoints": asked, "gearbox_states": replace(went, position=went.position + wanders[:, None])}
    told = diagnose([Recording("made", 0, 20.0, series)], model="direct", experiments=False)
    (rest,) = told.unexplained
    assert "% of what remains once the servo's loop is identified, " in rest.statement
    stated = replace(told.model, effects={})
    again = diagnose([Recording("made", 0, 20.0, series)], model=stated, experiments=False)
    assert "% of the residual's power, " in again.unexplained[0].statement


def test_what_is_left_is_said_with_its_stage_and_size() -> None:
    now = fitted("rough")
    (rest,) = left_over(now.context, now.hypothesis)
    assert (rest.stage, rest.joints) == ("wire", ["joint_2"])
    said = re.fullmatch(
        r"joint_2 \(wire\): 100\.0% of the residual's power, ([\d.]+) times the noise, stays unexplained"
        r" and depends on position.*\.",
        rest.statement,
    )
    assert said is not None
    left = np.sqrt(now.rest(1) / now.context.count(1))
    assert float(said[1]) == pytest.approx(left, rel=0.05)


def test_what_has_no_name_is_told_by_its_share() -> None:
    """Beside a share of 70 % it had been "physics that no name and no smooth curve fits"."""
    rests = [Unexplained("wire", ["elbow"], "posture", 0.7, ["position", "speed", "time"], "")]
    (told,) = without_a_name(rests, [])
    said = "elbow: 70% of the residual fits no effect of the library and no smooth curve; it depends on "
    assert told.statement == f"{said}position, speed and time."


def test_a_zero_makes_no_rest_look_small() -> None:
    now = fitted("rough")
    (view,) = now.context.views
    moved = replace(view, span=replace(view.span, target=view.span.target + 0.3 * view.span.valid))
    zero = Hypothesis(zero_offset=Term("zero_offset", own={c: {"offset": 0.3} for c in range(5)}))
    (rest,) = left_over(now.context.viewing([moved]), zero)
    assert rest.share > 0.99
    assert "% of the residual's power beside a constant, which is explained, " in rest.statement


@pytest.mark.parametrize(("times", "said"), [(0.9, 0), (1.2, 1)])
def test_what_is_less_than_the_noise_is_not_said_to_be_left(
    times: float, said: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = fitted("rough")
    monkeypatch.setattr("trunk_ros.diagnosis.verdict.findings.rests", lambda *_: {1: times**2})
    assert len(left_over(now.context, now.hypothesis)) == said


def _off(by: str) -> Context:
    """What servos leave that are late by 1 ms, or have a small wave on top."""
    made = recorded(seconds=20.0, nominal=SHORT)
    motors = made.series["gearbox_states"]
    wave = motors.position + 3e-4 * np.sin(2.0 * np.pi * 1.1 * motors.stamp)[:, None]
    late = np.column_stack([np.interp(motors.stamp - 1e-3, motors.stamp, q) for q in motors.position.T])
    position = {"wave": wave, "late": late}[by]
    series = {**made.series, "gearbox_states": replace(motors, position=position, velocity=None)}
    return first_look(ServoStage([servo_span(replace(made, series=series), SHORT)], SHORT))


@pytest.mark.parametrize(("by", "said"), [("wave", {0, 1, 2}), ("late", set())])
def test_of_what_a_servo_leaves_only_a_lag_is_how_its_loop_is_described(by: str, said: set[int]) -> None:
    """A wave as small as what 1 ms makes of the motion had been taken for that, and was not said."""
    assert rests(_off(by), Hypothesis()).keys() == said


@pytest.mark.parametrize(("by", "said"), [("wave", {0, 1, 2}), ("late", set())])
def test_nor_is_a_lag_said_to_be_left_of_blocks_beside_what_was_found(by: str, said: set[int]) -> None:
    context = _off(by)
    found = Hypothesis(servo_offset=Term("servo_offset", own={c: {"offset": 0.0} for c in range(3)}))
    errors = {}
    for c in context.columns:
        left, noise = float(np.std(context.residual(0, found, c))), context.noise[c].std
        errors[c] = Error(left, 0.0, left, 0.0, noise, left, sure=left)
    assert rests(context, found, errors).keys() == said
