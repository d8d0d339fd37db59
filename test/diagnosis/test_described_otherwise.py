"""Servos that a model describes wrongly are told by the number that is another one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import diagnose
from test.diagnosis.test_nominal_servo import NOISE, PLAIN, _left, _stated, recorded_servos
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.simulate import simulate


@pytest.mark.parametrize(
    ("servo", "stated", "effect", "parameter", "value"),
    [
        ({"tau_v": (0.03,) * 3}, {}, "velocity_loop", "relative", 0.5),
        pytest.param({"tau_v": (0.012,) * 3}, {}, "velocity_loop", "relative", -0.4, marks=pytest.mark.long),
        ({"delay": (0.01,) * 3}, {"delay": 0.024}, "servo_delay", "delay", -0.014),
        ({"v_max": (0.9,) * 3}, {"v_max": 0.5}, "velocity_saturation", "v_max", 0.9),
    ],
)
def test_it_is_told_by_its_number(
    servo: dict[str, tuple[float, float, float]],
    stated: dict[str, float],
    effect: str,
    parameter: str,
    value: float,
) -> None:
    found = diagnose(recorded_servos(PLAIN | servo, after=0.0), model=_stated(**stated))
    (finding,) = found.findings
    assert (finding.effect, found.verdict) == (effect, "explained")
    assert finding.parameters["arm"][parameter]["value"] == pytest.approx(value, rel=0.03)
    assert _left(found.model, recorded_servos(PLAIN | servo, seed=2, after=0.0)).max() < 3e-4


@pytest.mark.parametrize(("is_fed", "stated"), [(0.8, 0.0), (0.0, 1.0)])
def test_a_share_of_speed_that_the_model_has_otherwise_is_told(is_fed: float, stated: float) -> None:
    """It had been a delay of 1/Kp, or unknown."""
    made = [recorded_servos(PLAIN, seed, after=0.0) for seed in (1, 2)]
    driven, other = (
        replace(run, series=run.series | {"gearbox_states": _moved(run, _stated(feedforward=is_fed))})
        for run in made
    )
    found = diagnose(driven, model=_stated(feedforward=stated))
    (finding,) = found.findings
    assert (finding.effect, found.verdict) == ("speed_feedforward", "explained")
    assert finding.parameters["arm"]["share"]["value"] == pytest.approx(is_fed - stated, abs=0.02)
    assert _left(found.model, other).max() < 3e-4


def _moved(run: Recording, model: Model) -> JointSeries:
    """What the servos of a model make of the setpoints of a recording, with its noise."""
    shown, rng = run.series["gearbox_states"], np.random.default_rng(3)
    went = simulate(run, model, source="setpoints").series["gearbox_states"]
    position = np.column_stack([np.interp(shown.stamp, went.stamp, p) for p in went.position.T])
    return replace(shown, position=position + NOISE * rng.standard_normal(position.shape))


def test_a_velocity_loop_goes_beside_a_gain() -> None:
    servo = {"kp": (15.0,) * 3, "tau_v": (0.03,) * 3}
    found = diagnose(recorded_servos(PLAIN | servo, after=0.0), model=_stated())
    assert {f.effect for f in found.findings} == {"servo_bandwidth", "velocity_loop"}
    assert found.model.number("kp") == pytest.approx(15.0, rel=0.01)
    assert found.model.number("tau_v") == pytest.approx(0.03, rel=0.03)


def test_a_delay_that_is_not_there_is_taken_away() -> None:
    found = diagnose(recorded_servos(PLAIN, after=0.0), model=_stated(delay=0.02))
    assert found.model.number("delay") == pytest.approx(0.0, abs=1e-3)
