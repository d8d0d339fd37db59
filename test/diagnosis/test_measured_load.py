"""A load that sensors measure, on an arm of which nothing is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import reshaped
from trunk_ros.data.align import wire_span
from trunk_ros.data.sensing import clocks_put_right
from trunk_ros.diagnosis import diagnose
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects import effect
from trunk_ros.effects.effect import Motion
from trunk_ros.model import load_model
from trunk_ros.recording.recording import JointSeries, Recording

BENDING = ("wire_stiffening", "wire_slack")


def loaded(swings: float = 0.09, with_the_speed: float = 0.0) -> Recording:
    """20 s of a joint with a load cell, another ratio and zero, and a wire that hardens."""
    t = np.arange(2000) / 100.0
    phi = 0.5 + 0.3 * np.sin(2 * np.pi * 0.11 * t) + 0.2 * np.sin(2 * np.pi * 0.31 * t)
    load = 0.1 + swings * np.sin(2 * np.pi * 0.07 * t) + with_the_speed * np.gradient(phi, t)
    theta = 0.9 * phi + 0.2 + 0.075 * np.log1p(load / 0.05)
    theta += 1e-4 * np.random.default_rng(0).normal(size=len(t))
    joints = ("jaw",)
    series = {
        "gearbox_states": JointSeries(t, joints, phi[:, None]),
        "joint_states": JointSeries(t, joints, theta[:, None], None, load[:, None]),
    }
    return Recording("loaded", 1_750_000_000_000_000_000, float(t[-1]), series)


def test_a_wire_that_hardens_under_a_measured_load_is_named_and_nothing_else_in_its_place() -> None:
    told = diagnose(loaded(), model="direct", experiments=False)
    found = {finding.effect for finding in told.findings}
    assert found == {"wire_stiffening", "ratio_error", "zero_offset"}


def test_a_wire_that_a_measured_load_stretches_ahead_of_the_motor_is_no_early_clock() -> None:
    model, made = load_model("direct"), loaded(swings=0.01, with_the_speed=0.05)
    assert not clocks_put_right(made, model).observed
    untold = reshaped(made, "joint_states", effort=None)
    assert [one.kind for one in clocks_put_right(untold, model).observed] == ["early"]


def test_what_a_wide_loop_shows_of_a_joint_has_its_load_at_the_same_times() -> None:
    """It had the whole recording's: a search of a wide loop under a measured load ended in an error."""
    made = reshaped(loaded(), "joint_states", stamp=np.arange(2000) / 100.0 + 0.003)
    model = load_model("direct").for_joints(("jaw",))
    context = replace(first_look(WireStage([wire_span(made, model)], model)), wide=frozenset({0}))
    now = context.shown(0)
    rows = int(context.views[0].span.valid[:, 0].sum())
    for each in ("stamp", "dt", "gearbox", "speed", "load", "angles", "wires", "speeds"):
        assert len(getattr(now, each)) == rows < len(context.views[0].span.grid), each
    whole = context.now(0, 0)
    np.testing.assert_array_equal(now.load, whole.load[np.isin(whole.stamp, now.stamp)])


@pytest.mark.parametrize("name", BENDING)
def test_the_measured_force_of_a_push_does_not_show_how_a_wire_bends(name: str) -> None:
    """It goes with the way of the joint: a curve of either says the same. Without masses none swings."""
    kind = effect(name)
    assert kind.forms_shown(Motion(one_way=True, masses=False)) == ()
    assert kind.forms_shown(Motion(masses=False)) == tuple(f for f in kind.forms if f not in kind.shaking)
    assert kind.forms_shown(Motion(one_way=True)) == kind.forms
