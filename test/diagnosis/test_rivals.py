"""A rival is judged by all that it predicts: where it moves a joint, what that joint pulls at moves too."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import NOISE, diagnose, of_the_wires, on, recorded
from trunk_ros.chain import Chain
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.evidence.evidence import TIED, Evidence, likely, one_evidence
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import hypothesis_of
from trunk_ros.diagnosis.search.fit import refit
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.diagnosis.tip.findings import EITHER
from trunk_ros.effects import confused, registry
from trunk_ros.model import load_model
from trunk_ros.recording.recording import JointSeries, Recording

LATE = {"sensor_delay": {"delay": 0.02}}
COUPLED = {"joint_coupling": {"gain": on(5, 0.1), "source": ["", "", "", "", "joint_2"]}}


def judged(
    effects: dict[str, dict[str, Any]], name: str = "sensor_delay", exact: bool = True, **how: Any
) -> Evidence:
    """Evidence for an effect in a recording of these, found as they are; ``exact``: formulas may be off by
    nothing.
    """
    nominal = load_model("trunk")
    stage = WireStage([wire_span(recorded(effects, 20.0, **how), nominal)], nominal)
    truth = hypothesis_of(effects, "wire", len(stage.joints))
    context = first_look(stage) if exact else begun(first_look(stage)).context
    context = context.seen_with(truth).weighed(truth)
    return one_evidence(refit(context, truth), name)


def test_a_name_is_as_sure_as_its_best_rival_lets_it_be() -> None:
    margins = (-1.0, -0.3, 0.0, 0.3, 2.0)
    sure = [likely(100.0, 5e3, [500.0, 100.0 * margin]) for margin in margins]
    assert sure == sorted(sure)
    assert sure[2] == pytest.approx(TIED), "one that does as well"
    assert sure[0] < 0.2
    assert sure[-1] == likely(100.0, 5e3, [])
    assert likely(100.0, 100.0, [0.0]) < 0.6, "little gain"
    assert likely(100.0, 5e3, [0.0], EITHER) == pytest.approx(EITHER)


def test_a_lag_of_all_joints_is_a_late_sensor_where_none_pulls_at_another() -> None:
    assert judged(LATE).equivalents == ["viscous_lag"]


def test_a_joint_that_lags_pulls_late_where_a_sensor_that_is_late_does_not() -> None:
    found = judged({**LATE, **COUPLED})
    assert found.equivalents == []
    assert found.rivals["viscous_lag"] > 1000.0
    assert found.confidence == pytest.approx(0.95)


def test_what_joints_share_does_not_bend_to_rule_out_a_rival() -> None:
    """The delay alone had stood for a part of the wider bands, and was then off where `backlash` stood."""
    found = judged({"sensor_delay": {"delay": 0.004}, "tension_error": {"factor": 1.5}}, "tension_error")
    assert "backlash" in found.equivalents
    assert found.confidence < 0.95


@pytest.mark.parametrize(("off", "same"), [(0.02, True), (0.3, False)])
def test_dead_bands_that_are_all_wider_by_nearly_one_factor_may_be_the_tension(
    off: float, same: bool
) -> None:
    factor = 1.0 + 3.0 * (1.0 + off * np.array([1.0, -1.0, 1.0, -1.0, 1.0]))
    wide = (factor - 1.0) * load_model("trunk").arm.dead_band
    assert (
        "tension_error" in judged({"backlash": {"half_width": wide}}, "backlash", exact=False).equivalents
    ) == same


def test_a_zero_that_is_off_may_be_a_coupling_of_a_joint_that_stood_before_what_says_more() -> None:
    """Joint 2 goes somewhere and stays there, within the dead band of joint 3, which then moves."""
    model = load_model("trunk")
    stamp = np.arange(6000) / 100
    went = np.zeros((len(stamp), 5))
    went[:, 1] = 0.3 * np.clip((stamp - 2.0) / 10.0, 0.0, 1.0) / model.arm.ratio[1]
    went[:, 2] = 0.3 * np.sin(0.9 * np.maximum(stamp - 15.0, 0.0)) / model.arm.ratio[2]
    coupled = {"joint_coupling": {"gain": on(3, 1e-3), "source": ["", "", "joint_2", "", ""]}}
    shown, _ = Chain(replace(model, effects=coupled), "wire").run(went, stamp)
    shown += NOISE * np.random.default_rng(3).standard_normal(shown.shape)
    series = {
        "gearbox_states": JointSeries(stamp, model.arm.joints, went),
        "joint_states": JointSeries(stamp, model.arm.joints, shown),
    }
    (found,) = diagnose([Recording("made", 0, 60.0, series)]).findings
    names = [found.effect, *found.equivalents]
    assert {"zero_offset", "joint_coupling"} <= {*names[:3]}


@pytest.mark.parametrize(("slow", "told"), [(0.02, False), (1.0, True)])
def test_a_lag_of_one_joint_may_be_a_late_sensor_where_the_others_hardly_move(
    slow: float, told: bool
) -> None:
    lag = {"viscous_lag": {"time_constant": on(2, 0.002)}}
    found = judged(lag, "viscous_lag", seed=1, size=np.where(on(2, 1.0), 1.0, slow))
    assert ("sensor_delay" not in found.equivalents) == told


@pytest.mark.parametrize(("size", "told"), [(0.4, True), (2.0, False)])
def test_a_joint_that_sags_may_be_one_of_another_ratio_that_is_coupled_unless_it_goes_far(
    size: float, told: bool
) -> None:
    both = np.array([size, size, 0.0, 0.0, 0.0])
    found = judged({"load_elasticity": {"compliance": on(2, 0.02)}}, "load_elasticity", seed=1, size=both)
    assert (["joint_coupling", "ratio_error"] in found.equivalents) == told


def stretch(whole: Recording, begin: float, end: float) -> Recording:
    """What was recorded from ``begin`` to ``end`` [s]."""
    return replace(whole, series={key: each.between(begin, end) for key, each in whole.series.items()})


@pytest.mark.parametrize(("begin", "end"), [(1.5, 4.0), (4.5, 6.0), (7.0, 8.5), (7.0, 9.5)])
def test_a_dead_band_is_not_ruled_out_by_a_motion_that_shows_no_reversal(begin: float, end: float) -> None:
    whole = recorded({"backlash": {"half_width": on(5, 1.6e-3)}}, 12.0, seed=3)
    (found,) = diagnose(stretch(of_the_wires(whole), begin, end)).findings
    assert "backlash" in [found.effect, *found.equivalents]
    assert found.confidence < 0.9


def test_what_looks_like_another_effect_does_so_from_both_sides() -> None:
    assert "backlash" in confused("stribeck_friction")
    for name in registry():
        assert all(name in confused(other) for other in confused(name))
