"""What happens at once to a joint that rests throws it within its dead band, and is one event."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.concealed.everyday import draw_motion
from test.concealed.masses import run_masses
from test.concealed.masses_arm import Arm, having
from test.concealed.nominal import JOINTS, RATIO
from test.concealed.sensing import Sensing, record
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.data.surroundings import View
from trunk_ros.diagnosis.diagnoser import Diagnoser
from trunk_ros.diagnosis.disturbances.thrown import rests, thrown
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.levels import PART
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording

RELATIVE = 0.02


@pytest.fixture(scope="module")
def model() -> Model:
    """The nominal one."""
    return load_model("trunk")


@pytest.fixture(scope="module")
def happened() -> tuple[Recording, float]:
    """An arm of masses on wires, one of which gets another ratio while its joint rests, and when [s]."""
    rng, stamp = np.random.default_rng(3), np.arange(4000) * 0.01
    reference = draw_motion(rng, "resting", stamp)
    at = _middle_of_a_rest(stamp, reference[:, 3])
    motion = run_masses(
        [(0.0, Arm()), (at, having(Arm(), (3,), wheel=1.0 + RELATIVE))],
        np.repeat(reference / RATIO, 5, axis=0),
    )
    run = record(rng, "resting", reference, reference / RATIO, motion, Sensing())
    begin = min(int(topic["stamp"][0]) for topic in run.topics.values())
    series = {
        key: JointSeries((topic["stamp"] - begin) * 1e-9, JOINTS, topic["position"])
        for key, topic in run.topics.items()
    }
    return Recording("made", begin, 40.0, series), at


def _middle_of_a_rest(stamp: Array, path: Array) -> float:
    """The middle of the longest rest of a joint (n,) away from its zero, of those in mid-run."""
    ends = np.flatnonzero(np.diff(path) != 0.0)
    middle = (stamp[ends[:-1]] + stamp[ends[1:]]) / 2
    inside = (middle > 10.0) & (middle < 28.0) & (np.abs(path[ends[:-1] + 1]) > 0.05)
    return float(middle[np.argmax(np.diff(stamp[ends]) * inside)])


def moved(view: View, hypothesis: Hypothesis, column: int, predicted: Array) -> Array:
    """(n,) rad that throws add to what is ``predicted`` (n,)."""
    return thrown(view, column, rests(view, hypothesis, column), predicted) - predicted


def test_a_ratio_that_changes_while_a_joint_rests_is_one_effect(
    happened: tuple[Recording, float], model: Model
) -> None:
    recording, at = happened
    result = Diagnoser([recording], model, None, lambda _: None, experiments=False).run()
    (finding,), (event,) = result.findings, result.events
    assert (finding.effect, finding.joints) == ("ratio_error", ["joint_4"])
    assert finding.parameters["joint_4"]["relative"]["value"] == pytest.approx(RELATIVE, rel=0.03)
    assert event.begin == pytest.approx(at, abs=0.05)


def test_a_throw_ends_where_the_joint_moves_and_goes_no_further_than_its_dead_band(
    happened: tuple[Recording, float], model: Model
) -> None:
    recording, at = happened
    context = first_look(WireStage([wire_span(recording, model)], model))
    view, column = context.views[0], 3
    term = Term("ratio_error", "", {}, {column: {"relative": RELATIVE, "from": at}})
    there = Hypothesis({term.effect: term})
    predicted = context.predict(0, there, column)
    more = moved(view, there, column, predicted)
    (rest,) = rests(view, there, column)
    still = slice(rest["begin"], rest["end"])
    path = view.span.gearbox[view.span.rows[rest["first"] - 1 :], column] * model.arm.ratio[column]
    way = np.maximum.accumulate(np.abs(path[1:] - path[0]))
    stamp, band = view.span.stamp, 2.0 * model.arm.dead_band[column]
    assert not more[stamp < at - 0.1].any()
    assert 2e-4 < np.abs(more[still]).mean() < band
    assert rest["end"] == rest["first"] + int(np.argmax(way > PART * band / 2.0))
    moves = rest["first"] + int(np.argmax(way > band))
    assert not more[moves:].any()
    knocked = moved(view, Hypothesis(), column, predicted)  # it jumps, whatever made it
    assert [at for c, at in view.span.knocks if c == column] == pytest.approx([at], abs=0.05)
    assert not knocked[stamp < at - 0.1].any()
    view = replace(view, span=replace(view.span, knocks=()))
    assert not moved(view, Hypothesis(), column, predicted).any()
    motor = Hypothesis(servo_bandwidth=Term("servo_bandwidth", own={column: {"relative": 0.1, "from": at}}))
    assert not len(rests(view, motor, column))  # motors lie in no band
    left = [(view.span.target[:, column] - p)[still].mean() for p in (predicted, predicted + more)]
    assert abs(left[1]) < 0.1 * abs(left[0])


def test_within_its_dead_band_a_joint_is_thrown_either_way(model: Model) -> None:
    """A slip that friction holds back moves nothing by itself, yet what is measured may jump."""
    half, column, at = float(model.arm.dead_band[3]), 3, 10.0
    stamp = np.arange(2000) * 0.01
    angle = np.zeros((2000, 5))
    angle[:, column] = 0.3 * np.sin(np.clip(stamp - 15.0, 0.0, None))
    true = angle - 0.4 * half * (stamp > at)[:, None] * (np.arange(5) == column)
    series = {
        "gearbox_states": JointSeries(stamp, JOINTS, angle / RATIO),
        "joint_states": JointSeries(
            stamp, JOINTS, true + np.random.default_rng(1).normal(0, 1e-5, true.shape)
        ),
    }
    context = first_look(WireStage([wire_span(Recording("made", 0, 20.0, series), model)], model))
    view = context.views[0]
    slip = Hypothesis({"wire_slip": Term("wire_slip", own={column: {"step": -0.9 * half, "onset": at}})})
    predicted = context.predict(0, slip, column)
    more = moved(view, slip, column, predicted)[(stamp > at + 0.1) & (stamp < 14.9)]
    assert more == pytest.approx(np.full(len(more), -0.4 * half), rel=0.05)
