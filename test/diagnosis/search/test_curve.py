"""When a curve without a name takes the place of names."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from test.diagnosis.arms import NOISE, TRUNK, recorded, reshaped
from test.diagnosis.search.looks import best_of
from trunk_ros.chain import Chain
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.discrepancy.curves import Place, ends, with_curve
from trunk_ros.diagnosis.discrepancy.memory import in_banks, source_of
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.fit import Fit, costed, refit
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.moves import CURVE
from trunk_ros.diagnosis.search.moves.curve import _is_clear
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.bank import WEIGHTS
from trunk_ros.effects.curve import KNOTS
from trunk_ros.effects.wire.coupling_curve import CouplingCurve
from trunk_ros.levels import LITTLE
from trunk_ros.recording.recording import Recording


def _worn() -> Recording:
    """The encoder disc of joint 4 has waves, and joint 3 moves nearly as joint 4 does."""
    made = recorded(seconds=40.0, size=1.6)
    gearbox, stamp = made.series["gearbox_states"].position.copy(), made.series["gearbox_states"].stamp
    gearbox[:, 2] = 0.1 * gearbox[:, 1] - 1.3 * gearbox[:, 3]
    angles = Chain(TRUNK, "wire").run(gearbox, stamp)[0]
    angles[:, 3] += 1.2e-3 * np.sin(5.0 * angles[:, 3]) + 0.7e-3 * np.sin(11.0 * angles[:, 3] + 1.0)
    angles += NOISE * np.random.default_rng(2).standard_normal(angles.shape)
    made = reshaped(made, "gearbox_states", position=gearbox, velocity=np.gradient(gearbox, stamp, axis=0))
    return reshaped(made, "joint_states", position=angles)


@cache
def _bent() -> Fit:
    """What a curve over joint 3 leaves of that."""
    first = begun(first_look(WireStage([wire_span(_worn(), TRUNK)], TRUNK)))
    source = source_of(first.context, 3, CouplingCurve, "joint_3")
    assert source is not None
    bent = in_banks(Hypothesis(), 3, [source], [np.zeros(WEIGHTS)])
    bent["coupling_curve"].given = frozenset()
    return refit(first.context, bent)


def test_a_curve_of_the_joint_itself_wins_over_one_of_a_joint_that_moves_nearly_alike() -> None:
    """Neither has a form to be off by: what explains more is said."""
    now = _bent()
    assert now.rest(3) < LITTLE * now.context.misfit[3]
    drawn = best_of(CURVE, now)
    assert drawn is not None
    assert drawn.hypothesis["unknown"].words == {3: {"on": "position"}}


@pytest.mark.parametrize(("gone", "clear"), [("coupling_curve", True), ("ratio_error", False)])
def test_a_formula_is_not_replaced_since_a_curve_stands_beside_it(gone: str, clear: bool) -> None:
    bent = _bent()
    ratio = {"ratio_error": Term("ratio_error", own={3: {"relative": 1e-4}})}
    now = replace(bent, hypothesis=Hypothesis({**bent.hypothesis, **ratio}))
    own = Place("unknown", "position", *ends(now.context, 3, "position"))
    there = with_curve(now.hypothesis.without(gone), own, 3, np.zeros(KNOTS))
    trial = replace(now, hypothesis=there, cost=now.cost | {3: now.cost[3] - 1.0})
    assert _is_clear(now, trial, 3, ["coupling_curve", "ratio_error"]) == clear


def test_curves_take_the_place_of_what_two_joints_show_only_together() -> None:
    """Radii that grow with the angle. One joint shows its names only beside the other: that they begin at the
    end of the recording.
    """
    made = recorded(seconds=40.0, size=1.6)
    angles = made.series["joint_states"].position.copy()
    angles[:, :2] += np.array([0.1, -0.15]) * angles[:, :2] ** 3
    made = reshaped(made, "joint_states", position=angles)
    first = begun(first_look(WireStage([wire_span(made, TRUNK)], TRUNK)))
    begins = {0: 15.0, 1: 39.5}
    names = {
        name: Term(name, form, own={c: {value: 1e-3, "from": at} for c, at in begins.items()})
        for name, form, value in (
            ("ratio_error", "", "relative"),
            ("load_elasticity", "weight", "compliance"),
        )
    }
    now = costed(first.context, Hypothesis(names))
    assert not any(hidden(now.context, term) for term in now.hypothesis.values())
    assert hidden(now.context, now.hypothesis.without("ratio_error", 0)["ratio_error"]) == [1]
    drawn = best_of(CURVE, now)
    assert drawn is not None
    assert drawn.hypothesis["unknown"].columns == [0, 1]
