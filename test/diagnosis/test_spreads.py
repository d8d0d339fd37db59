"""Stated standard deviations hold what makes values wrong, not the noise of single samples alone."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from test.diagnosis.arms import on, recorded
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.evidence.spreads import _pulled, _Seen, _still_to_go, spreads
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Free, Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects import effect
from trunk_ros.model import load_model
from trunk_ros.recording.recording import Recording

TRUNK = load_model("trunk")


def fitted(made: Recording, term: Term) -> Fit:
    """What the wires of a recording say of an effect."""
    context = first_look(WireStage([wire_span(made, TRUNK)], TRUNK, made.units))
    return refit(context, Hypothesis({term.effect: term}))


def off(seed: int, hold: int) -> tuple[float, float]:
    """By what a ratio is off beside errors that last for so many samples, and its standard deviation."""
    made = recorded({"ratio_error": {"relative": on(1, 0.02)}}, 40.0, seed=seed)
    states = made.series["joint_states"]
    rng = np.random.default_rng(seed)
    held = np.repeat(rng.normal(0.0, 2e-4, len(states.stamp) // hold + 1), hold)[: len(states.stamp)]
    wrong = replace(states, position=states.position + held[:, None])
    made = replace(made, series={**made.series, "joint_states": wrong})
    state = fitted(made, Term("ratio_error", own={0: {"relative": 0.0195}}))
    value = state.hypothesis["ratio_error"].own[0]["relative"]
    return value - 0.02, spreads(state)["ratio_error", "relative", 0]


def test_errors_that_last_count_once() -> None:
    short, long = (np.array([off(seed, hold) for seed in range(6)]) for hold in (1, 150))
    for errors, stds in (short.T, long.T):
        assert 0.2 < np.sqrt(np.mean((errors / stds) ** 2)) < 1.6
    assert np.median(long[:, 1]) > 4.0 * np.median(short[:, 1])


def test_what_is_stated_is_as_uncertain_as_the_recording_leaves_it() -> None:
    stated = TRUNK.arm.compliance
    hidden = {"load_elasticity": {"compliance": 1.1 * stated, "payload": 0.05}}
    own = {c: {"compliance": float(stated[c])} for c in range(5)}
    free = Term("load_elasticity", "weight", {"payload": 0.07}, own)
    state = fitted(recorded(hidden, 40.0), replace(free, given=frozenset({"compliance"})))
    std = spreads(state)
    found = state.hypothesis["load_elasticity"].shared["payload"]
    assert abs(found - 0.05) > 5e-3, "the payload made good what is stated wrongly"
    assert abs(found - 0.05) < 3.0 * std["load_elasticity", "payload", None]
    for c in range(5):
        assert 0.1 * stated[c] < 3.0 * std["load_elasticity", "compliance", c] < stated[c]


def test_what_only_two_values_together_do_is_told_of_neither() -> None:
    seen = _Seen(np.zeros(2), *(power * np.ones((2, 2)) for power in (1e4, 1e4, 4e4)), np.zeros(2))
    assert np.all(_pulled(seen) > 1e3)
    apart = _Seen(np.zeros(2), *(power * np.eye(2) for power in (1e4, 1e4, 4e4)), np.zeros(2))
    np.testing.assert_allclose(_pulled(apart), 0.02, rtol=1e-6)


def test_a_fit_would_go_on_no_further_than_to_a_bound() -> None:
    give = effect("hard_stop").own_parameters("upper")[1]
    fit = cast(Any, SimpleNamespace(free=[Free("hard_stop", give, 0)], scale=np.array([0.1])))
    for slope, most in ((1e6, -0.01), (-1e6, 0.94)):
        seen = _Seen(np.array([slope]), *np.full((3, 1, 1), 1e4), np.zeros(1))
        np.testing.assert_allclose(_still_to_go(fit, np.array([0.01]), seen), most)
