"""Errors on samples that the fit did not see: what is judged has no say in its own prediction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import recorded, reshaped
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.curves import KNOTS, Place, redrawn, with_curve
from trunk_ros.diagnosis.evidence.cross_validation import BLOCKS, held_out
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import costed
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.wire.unknown import Unknown
from trunk_ros.model import load_model
from trunk_ros.recording.recording import Recording

JOINT = 2
BEAM = Hypothesis(
    link_resonance=Term(
        "link_resonance", "beam", own={JOINT: {"frequency": 4.0, "damping": 0.02, "share": 0.3}}
    )
)


def curve_over(variable: str, low: float, high: float) -> Hypothesis:
    """A curve of nothing yet."""
    return with_curve(Hypothesis(), Place(Unknown.id, variable, low, high), JOINT, np.zeros(KNOTS))


def with_added(added: Array) -> Recording:
    """A good arm with something (n,) added to what one joint shows."""
    whole = recorded()
    position = whole.series["joint_states"].position.copy()
    position[:, JOINT] += added
    return reshaped(whole, "joint_states", position=position)


def looked_at(recording: Recording) -> Context:
    """The wires."""
    model = load_model("trunk")
    return first_look(WireStage([wire_span(recording, model)], model))


def wild(stamp: Array) -> Array:
    """As much as a curve over time can follow, in no block like in the one before, rad."""
    knots = np.random.default_rng(3).normal(size=KNOTS) * 2e-3
    return np.interp(stamp, np.linspace(0.0, stamp[-1], KNOTS), knots)


def test_a_curve_is_not_judged_on_the_samples_that_it_was_drawn_through() -> None:
    stamp = recorded().series["joint_states"].stamp
    context = looked_at(with_added(wild(stamp)))
    drawn = redrawn(context, curve_over("time", 0.0, float(stamp[-1])), JOINT)
    seen = float(np.std(context.residual(0, drawn, JOINT)[context.views[0].span.valid[:, JOINT]]))
    assert seen < 3e-4
    assert held_out(costed(context, drawn))[JOINT].after > 2.0 * seen


@pytest.mark.parametrize("hypothesis", [curve_over("position", -0.4, 0.4), BEAM], ids=["curve", "beam"])
def test_what_is_judged_does_not_change_its_own_prediction(hypothesis: Hypothesis) -> None:
    """The judged blocks shown otherwise are off by just that, before the folds are put together."""
    said = []
    for shown in (0.0, 5e-3):
        bent = 1e-3 * np.sin(recorded().series["gearbox_states"].position[:, JOINT])
        context = looked_at(with_added(bent))
        span = context.views[0].span
        fold = np.arange(len(span.rows)) * BLOCKS // len(span.rows) % 2 == 0
        target = span.target + shown * fold[:, None]
        views = (replace(context.views[0], span=replace(span, target=target)),)
        said.append(held_out_of(replace(context, views=views), hypothesis))
    np.testing.assert_allclose(said[1], said[0], atol=1e-9)


@pytest.mark.parametrize("zeros", [(0.0, 0.0), (2e-3, -2e-3)])
def test_several_recordings_tell_by_how_much_zeros_differ(zeros: tuple[float, ...]) -> None:
    model = load_model("trunk")
    spans = [wire_span(with_added(np.full(len(stamps()), zero)), model) for zero in zeros]
    error = held_out(costed(first_look(WireStage(spans, model)), Hypothesis()))[JOINT]
    assert error.zero == pytest.approx(zeros[0], abs=3e-4)
    assert error.usual < 3e-4  # what varies besides


def stamps() -> Array:
    """Of the joints."""
    return recorded().series["joint_states"].stamp


def held_out_of(context: Context, hypothesis: Hypothesis) -> Array:
    """What the first fold's samples are predicted to be."""
    from trunk_ros.diagnosis.evidence.cross_validation import _unseen

    (errors,) = dict(_unseen(costed(context, hypothesis), 0))[JOINT]
    span = context.views[0].span
    fold = np.arange(len(errors)) * BLOCKS // len(errors) % 2 == 0
    chosen = fold & span.valid[:, JOINT]
    return np.asarray((span.target[:, JOINT] - errors)[chosen])
