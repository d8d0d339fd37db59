"""A joint that never comes back shows nothing of memory: what no name explains there is a curve."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from test.diagnosis.arms import diagnose
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis import Diagnosis
from trunk_ros.diagnosis.discrepancy.banked import with_banks
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.prospects import HIDDEN, HOLDS, ONE_WAY, prospects
from trunk_ros.diagnosis.search.fit import refit
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.model import load_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.simulate import simulate

STANDS, ROWS, NOISE = 20, 400, 5e-4
MOVED = 0.03  # rad


def pushed(zero: float = 0.0, seed: int = 0, back: bool = False) -> tuple[Recording, np.ndarray]:
    """A joint pushed, and let ``back``, which gives way to the load along a bent line, read once a second;
    what it truly does.
    """
    rng, stamp = np.random.default_rng(seed), np.arange(float(ROWS))
    asked = np.repeat(np.linspace(0.0, 1.0, ROWS // STANDS), STANDS)
    asked = 1.0 - np.abs(2.0 * asked - 1.0) if back else asked
    load = -8.0 * np.maximum(asked - 0.3, 0.0) ** 1.5
    bent = 0.006 * np.exp(-(((asked - 0.25) / 0.1) ** 2)) - 0.004 * np.tanh((asked - 0.7) / 0.05)
    true = zero + asked - 0.05 * load + bent
    series = {
        "gearbox_states": JointSeries(stamp, ("slide",), asked[:, None], effort=load[:, None]),
        "joint_states": JointSeries(stamp, ("slide",), (true + NOISE * rng.normal(size=ROWS))[:, None]),
    }
    return Recording("push", 0, float(stamp[-1]), series), true


def with_what_no_name_explains(back: bool) -> Hypothesis:
    """Beside a wire that stretches."""
    model = load_model("direct")
    context = begun(first_look(WireStage([wire_span(pushed(back=back)[0], model)], model))).context
    soft = Hypothesis(load_elasticity=Term("load_elasticity", "weight", own={0: {"compliance": 0.05}}))
    return with_banks(refit(context, soft)).hypothesis


def test_a_joint_that_never_comes_back_has_a_curve_beside_its_names_and_no_memory() -> None:
    one_way = with_what_no_name_explains(back=False)
    assert set(one_way) == {"load_elasticity", "unknown"}
    assert one_way["unknown"].words[0]["on"] == "position"
    assert "unknown" not in with_what_no_name_explains(back=True)


def test_what_no_motion_can_show_is_said_with_the_reason() -> None:
    wires = next(one for one in prospects(pushed()[0], load_model("direct")) if one.stage == "wire")
    assert {"backlash", "wire_slip", "thermal_drift"} <= set(wires.unseen[ONE_WAY])
    assert "wire_stiffening" in wires.unseen[HIDDEN]
    assert not set(wires.effects) & {name for names in wires.unseen.values() for name in names}


def test_one_that_rests_for_long_shows_what_creeps_and_how_loud_its_own_sensor_is() -> None:
    """Pressure that steps and holds, by a gauge that scatters, moves a muscle by 1e-4 of its number."""
    stamp, rng = np.arange(0.0, 60.0, 0.1), np.random.default_rng(2)
    pressure = np.interp(stamp, [0.0, 5.0, 6.0], [0.0, 0.0, 250.0])
    crept = 1.0 - np.exp(-np.maximum(stamp - 6.0, 0.0) / 15.0)
    moved = 1e-4 * pressure * (1.0 + 0.3 * crept) + 1e-5 * rng.normal(size=stamp.shape)
    series = {
        "gearbox_states": JointSeries(
            stamp, ("a",), (pressure + 0.1 * rng.normal(size=stamp.shape))[:, None]
        ),
        "joint_states": JointSeries(stamp, ("a",), moved[:, None]),
    }
    held = Recording("hold", 0, float(stamp[-1]), series)
    wires = next(one for one in prospects(held, load_model("direct")) if one.stage == "wire")
    assert "viscoelastic_creep" in wires.effects
    assert "backlash" in wires.unseen[HOLDS]
    assert wires.joints["a"] < 5e-5


def test_one_that_rests_on_its_way_shows_that_its_wire_slipped() -> None:
    """A step in its zero on the way between two rests is no ratio."""
    stamp, rng = np.arange(0.0, 40.0, 0.02), np.random.default_rng(3)
    motor = np.interp(stamp, [0.0, 2.0, 3.0, 19.0, 21.0], [0.0, 0.0, 0.1, 0.1, 0.8])
    true = motor - 3e-3 * (stamp >= 20.2) + 2e-4 * rng.normal(size=stamp.shape)
    series = {
        "gearbox_states": JointSeries(stamp, ("a",), motor[:, None]),
        "joint_states": JointSeries(stamp, ("a",), true[:, None]),
    }
    result = diagnose([Recording("slip", 0, float(stamp[-1]), series)], model="direct")
    assert [finding.effect for finding in result.findings] == ["wire_slip"]
    assert result.findings[0].parameters["a"]["step"]["value"] == pytest.approx(-3e-3, rel=0.02)


@cache
def found() -> Diagnosis:
    return diagnose([pushed()[0]], model="direct")


def test_another_run_may_have_another_zero() -> None:
    recording, true = pushed(MOVED, seed=1)
    predicted = simulate(recording, found().model).series["joint_states"].position[:, 0]
    off = np.asarray(true - predicted)[recording.series["joint_states"].stamp >= 5.0]
    assert float(np.sqrt(np.mean(off**2))) < 0.1 * MOVED


def test_the_usual_error_is_that_of_most_of_the_recording() -> None:
    """At its ends a fit that has not seen them goes astray."""
    model = found().model
    assert model.error[0] < found().stages["wire"]["joints"]["slide"]["rmse_after"]
    assert model.error[0] > NOISE
