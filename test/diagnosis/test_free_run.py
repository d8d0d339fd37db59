"""A servo is judged by what its model does when it runs by itself, without the shaft's measured angle."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, of_the_servos, recorded
from trunk_ros.data.align import servo_span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence import veto
from trunk_ros.diagnosis.evidence.cross_validation import held_out
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.free_run import free_run
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import costed
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.effects.curve import HIGH, KNOTS, LOW, ON, VALUES
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.simulate import simulate

DROOP = {"load_droop": {"gain": 0.3}}
EVERYWHERE: dict[int, dict[str, float]] = {column: {} for column in range(3)}


@cache
def run(hidden: bool) -> Recording:
    return of_the_servos(recorded(DROOP if hidden else {}, 12.0, nominal=SHORT))


@cache
def looked(hidden: bool) -> Context:
    return first_look(ServoStage([servo_span(run(hidden), SHORT)], SHORT))


def droop() -> Hypothesis:
    return Hypothesis(load_droop=Term("load_droop", shared={"gain": 0.3}, own=EVERYWHERE))


def curve(slope: float) -> Hypothesis:
    """Over the first joint's position: it pushes the shaft on the more, the further it is from the middle."""
    term = Term(
        "unknown_servo",
        own={
            0: {LOW: -0.2, HIGH: 0.2}
            | {p.name: v for p, v in zip(VALUES, slope * np.linspace(-0.2, 0.2, KNOTS), strict=True)}
        },
        words={0: {ON: "position"}},
    )
    return Hypothesis(unknown_servo=term)


def simulated(recording: Recording, hypothesis: Hypothesis) -> np.ndarray:
    model = Model(SHORT.arm, hypothesis.model_effects(3))
    return simulate(recording, model, "setpoints").series["gearbox_states"].position


@pytest.mark.parametrize("hypothesis", [droop(), curve(0.4), curve(-0.5)])
def test_it_is_what_simulate_gives(hypothesis):
    context, recording = looked(hidden=True), run(hidden=True)
    free = free_run(context, hypothesis)
    for column in range(3):
        valid = context.views[0].span.valid[:, column]
        said = free.predict(0, hypothesis, column)
        assert said[valid] == pytest.approx(simulated(recording, hypothesis)[valid, column], abs=2e-6)


def test_what_sees_no_shaft_is_as_it_was():
    context = looked(hidden=True)
    late = Hypothesis(servo_delay=Term("servo_delay", shared={"delay": 0.01}, own=EVERYWHERE))
    for hypothesis in (Hypothesis(), late):
        assert free_run(context, hypothesis).views is context.views


def test_a_curve_that_runs_away_is_seen_to():
    """Led by the shaft's measured angle it stays where that is."""
    context, away = looked(hidden=False), curve(1.05)
    led, free = (c.whitened(away, 0) for c in (context, free_run(context, away)))
    assert np.mean(free**2) > 4.0 * np.mean(led**2)


def test_errors_are_those_of_runs():
    state = costed(looked(hidden=True), droop())
    errors = held_out(state)
    off = simulated(run(hidden=True), state.hypothesis) - run(hidden=True).series["gearbox_states"].position
    for column, error in errors.items():
        valid = state.context.views[0].span.valid[:, column]
        assert error.after == pytest.approx(np.sqrt(np.mean(off[valid, column] ** 2)), rel=0.1)


def test_what_has_no_name_goes_where_most_of_what_it_has_not_seen_is_worse(monkeypatch):
    """What has a name goes where it does harm for sure: it may show in a few blocks only."""
    worse = np.array([40.0, -30.0, 35.0, -40.0, 30.0, 35.0, -35.0, 40.0, 25.0, -90.0])
    monkeypatch.setattr(
        veto, "unseen", lambda _, hypothesis, *asked: np.tile(100.0 + worse * len(hypothesis), (2, 1))
    )
    assert list(veto.harmless(costed(looked(hidden=True), droop())).hypothesis) == ["load_droop"]
    assert list(veto.harmless(costed(looked(hidden=True), curve(0.01))).hypothesis) == []


def test_one_block_beyond_all_that_a_curve_has_seen_takes_it_from_no_model(monkeypatch):
    worse = np.array([-10.0] * 9 + [95.0])
    monkeypatch.setattr(
        veto, "unseen", lambda _, hypothesis, *asked: np.tile(100.0 + worse * len(hypothesis), (2, 1))
    )
    (kept,) = veto.harmless(costed(looked(hidden=True), curve(0.01))).hypothesis
    assert kept == next(iter(curve(0.01)))


def test_what_a_diagnosis_says_of_a_servo_is_what_its_model_leaves():
    found = diagnose([run(hidden=True)], SHORT)
    measured = run(hidden=True).series["gearbox_states"]
    assert [f.effect for f in found.findings] == ["load_droop"]
    left = simulate(run(hidden=True), found.model, "setpoints").series["gearbox_states"].position
    late = measured.stamp > 1.0
    for column, said in enumerate(found.stages["servo"]["joints"].values()):
        rms = np.sqrt(np.mean((left - measured.position)[late, column] ** 2))
        assert said["rmse_after"] == pytest.approx(rms, rel=0.3, abs=5e-6)
