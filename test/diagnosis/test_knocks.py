"""A joint at rest that is shaken within its dead band says nothing of its wire; one that slips does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.diagnose import diagnose
from trunk_ros.diagnosis.disturbances.knocks import knocks_told
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import Recording

STAMP = np.arange(9000) * 0.01
KNOCKED, NOISE = 2, 1e-4
TURN = 9.0  # s: for as long each joint moves, one after the other, twice


@pytest.fixture(scope="module")
def model() -> Model:
    """The nominal one."""
    return load_model("trunk")


def one_after_the_other(model: Model) -> Array:
    """(n, 5) rad of the gearbox."""
    path = np.zeros((len(STAMP), 5))
    for turn in range(10):
        inside = (turn * TURN <= STAMP) & ((turn + 1) * TURN > STAMP)
        t = (STAMP[inside] - turn * TURN) / TURN
        path[inside, turn % 5] = 0.5 * np.sin(4 * np.pi * t) * (1.0 - t) + 0.3 * t**2 * (1 + turn // 5)
        path[(turn + 1) * TURN <= STAMP, turn % 5] = path[inside, turn % 5][-1]
    return path / model.arm.ratio


def recorded(model: Model, off: Array, noise: float = NOISE) -> Recording:
    """A run of the nominal arm on which ``off`` (n,) rad was added to the joint that is knocked."""
    path = one_after_the_other(model)
    joint = Chain(model, "wire").run(path, STAMP, None, np.gradient(path, STAMP, axis=0))[0]
    joint[:, KNOCKED] += off
    joint += noise * np.random.default_rng(4).standard_normal(joint.shape)
    return Recording.from_arrays(STAMP, motor=path, joint=joint, joints=list(model.arm.joints), unit="rad")


def knocks(recording: Recording, model: Model) -> list[tuple[int, float]]:
    """Columns and moments [s] that a first look tells."""
    (view,) = first_look(WireStage([wire_span(recording, model)], model)).views
    return list(view.span.knocks)


def at_rest(begin: float, end: float) -> Array:
    """(n,) 1 from one moment [s] to another."""
    return ((begin <= STAMP) & (end > STAMP)).astype(float)


def test_a_knock_is_seen_at_its_moment_and_is_no_finding(model: Model) -> None:
    moved = 5e-4 * at_rest(31.0, 63.0) - 3e-4 * at_rest(75.0, 99.0)  # it goes on at 63 s
    recording = recorded(model, moved)
    assert [c for c, _ in knocks(recording, model)] == [KNOCKED, KNOCKED]
    assert [at for _, at in knocks(recording, model)] == pytest.approx([31.0, 75.0], abs=0.02)
    result = diagnose(recording, model=model, experiments=False)
    assert not result.findings
    assert not result.unexplained
    (said,) = [one for one in _observed(result) if one["kind"] == "knocks"]
    assert said["joints"] == (model.arm.joints[KNOCKED],)
    assert said["value"] == pytest.approx(5e-4, rel=0.1)


def test_what_is_still_off_when_the_joint_moves_again_has_slipped(model: Model) -> None:
    result = diagnose(recorded(model, 2e-3 * at_rest(31.0, 99.0)), model=model, experiments=False)
    (finding,) = result.findings
    values = finding.parameters[model.arm.joints[KNOCKED]]
    assert finding.effect == "wire_slip"
    assert values["step"]["value"] == pytest.approx(2e-3, rel=0.02)
    assert values["onset"]["value"] == pytest.approx(31.0, abs=0.1)
    assert not any(one["kind"] == "knocks" for one in _observed(result))


def test_what_a_hypothesis_says_happened_is_no_knock(model: Model) -> None:
    """A slip that friction holds back moves a joint less than it will when that goes on: its own throw."""
    off = 2e-3 * at_rest(63.0, 99.0) + 1e-3 * at_rest(31.0, 63.0)
    context = first_look(WireStage([wire_span(recorded(model, off), model)], model))
    slip = Hypothesis(wire_slip=Term("wire_slip", own={KNOCKED: {"step": 2e-3, "onset": 31.0}}))
    assert [*knocks_told(context, Hypothesis(), 0)]
    assert not [*knocks_told(context, slip, 0)]


def test_a_knock_of_a_joint_that_slides_is_said_in_millimetres(model: Model) -> None:
    recording = recorded(model, 5e-4 * at_rest(31.0, 63.0))
    stage = WireStage([wire_span(recording, model)], model, {model.arm.joints[KNOCKED]: "m"})
    (said,) = knocks_told(first_look(stage), Hypothesis(), 0)
    assert said.unit == "m"
    assert "1 times, by up to 0.5 mm." in said.statement


@pytest.mark.parametrize("noise", [1e-4, 3e-5, 1e-5, 3e-6])
def test_a_knock_is_seen_by_sensors_of_any_noise(model: Model, noise: float) -> None:
    half_way = np.clip((STAMP - 31.0) / 0.02 + 0.5, 0.0, 1.0)  # a reading lies in between
    seen = knocks(recorded(model, 5e-4 * half_way * (STAMP < 63.0), noise), model)
    assert [at for _, at in seen] == pytest.approx([31.0], abs=0.05)


@pytest.mark.parametrize("gain", [1e-3, 3e-3, 1e-2])
def test_what_goes_by_another_joint_is_no_knock(model: Model, gain: float) -> None:
    follows = gain * one_after_the_other(model)[:, 3] * model.arm.ratio[3]
    assert not knocks(recorded(model, follows), model)


def test_between_two_stops_no_knock_is_told(model: Model) -> None:
    whole = recorded(model, 5e-4 * at_rest(31.0, 63.0))
    few = {key: one.rows(np.arange(0, len(one.stamp), 200)) for key, one in whole.series.items()}
    assert not knocks(replace(whole, series=few), model)


def test_no_more_than_the_dead_band_is_a_knock(model: Model) -> None:
    """A wire that slips in steps has slipped, however small they are."""
    band = 2.0 * float(model.arm.dead_band[KNOCKED])
    off = 0.7 * band * sum(at_rest(at, 63.0) for at in (31.0, 40.0, 50.0))
    context = first_look(WireStage([wire_span(recorded(model, off), model)], model))
    left = context.residual(0, Hypothesis(), KNOCKED)[(STAMP > 51.0) & (STAMP < 60.0)]
    assert left.mean() == pytest.approx(2.1 * band - band, rel=0.02)


def _observed(result: Diagnosis) -> list[dict[str, object]]:
    return [one for said in result.quality.values() for one in said["observed"]]
