"""What a link rings after nobody saw its motor: as far as was measured, at a price, and no physics for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.data.test_align import kept
from test.diagnosis.arms import TRUNK, diagnose, of_the_wires, recorded
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import costed
from trunk_ros.diagnosis.search.score import FURTHER, chance, priced
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.signal.gaps import unseen

JOINT, FREQUENCY, DAMPING = 3, 4.3, 0.03
UNSEEN = ((8.03, 9.53), (16.01, 17.31))


def _ringing(joint: int | None = JOINT) -> Hypothesis:
    own = {} if joint is None else {joint: {"frequency": FREQUENCY, "damping": DAMPING}}
    return Hypothesis({"link_resonance": Term("link_resonance", "relative", {}, own)} if own else {})


@pytest.fixture(scope="module")
def whole() -> Recording:
    """A wrist that swings on its wire, with a dead band of its own."""
    numbers = {"frequency": [1e6] * 5, "damping": [0.1] * 5}
    numbers["frequency"][JOINT], numbers["damping"][JOINT] = FREQUENCY, DAMPING
    wide = [0.0, 0.0, 0.0, 5e-4, 0.0]
    effects = {"link_resonance": {"form": "relative", **numbers}, "backlash": {"half_width": wide}}
    return recorded(effects, seconds=30.0, size=2.0)


def _lost(recording: Recording) -> Recording:
    stamp = recording.series["gearbox_states"].stamp
    seen = ~np.any([(stamp > begin) & (stamp < end) for begin, end in UNSEEN], axis=0)
    return kept(recording, {"gearbox_states": seen, "setpoints": seen})


@pytest.fixture(scope="module")
def lossy(whole: Recording) -> Recording:
    """The same, with messages of its motors lost twice for more than a second."""
    return _lost(whole)


def _context(recording: Recording) -> Context:
    return first_look(WireStage([wire_span(recording, TRUNK)], TRUNK))


def test_what_rings_after_messages_were_lost_is_neither_slip_nor_friction(lossy: Recording) -> None:
    found = {f.effect: f for f in diagnose(of_the_wires(lossy)).findings}
    assert found.keys() == {"link_resonance", "backlash"}
    assert all(list(f.joints) == ["joint_4"] for f in found.values())
    told = found["link_resonance"].parameters["joint_4"]
    assert told["frequency"]["value"] == pytest.approx(FREQUENCY, rel=2e-3)
    assert told["damping"]["value"] == pytest.approx(DAMPING, rel=0.1)


def test_a_swing_of_its_own_begins_where_motors_are_seen_again(lossy: Recording) -> None:
    context = _context(lossy)
    lost = context.views[0].span.lost[JOINT]
    assert lost == pytest.approx(np.array(UNSEEN), abs=0.03)
    swung = context.stage.swings(context, 0, _ringing(), JOINT)
    assert np.all(swung > 100.0 * context.noise[JOINT].std ** 2)
    assert len(context.stage.swings(context, 0, _ringing(None), JOINT)) == 0


def test_without_a_loss_no_swing_is_free(whole: Recording) -> None:
    context = _context(whole)
    assert context.views[0].span.lost[JOINT].shape == (0, 2)
    assert len(context.stage.swings(context, 0, _ringing(), JOINT)) == 0


def test_who_is_unseen_for_less_than_half_a_swing_sets_no_link_going(lossy: Recording) -> None:
    context = _context(lossy)
    slow = Term("link_resonance", "relative", {}, {JOINT: {"frequency": 0.35, "damping": DAMPING}})
    assert len(context.stage.swings(context, 0, Hypothesis({"link_resonance": slow}), JOINT)) == 1


def test_a_swing_that_is_noise_costs_what_it_gains_and_another_one_two_values(
    lossy: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    context = _context(lossy)
    fit = costed(context, _ringing())
    prices = []
    for gains in ([0.0, 0.0], [5.0, 0.0], [1e4, 5.0]):
        squares = np.array(gains) * context.noise[JOINT].std ** 2
        on_joint = {JOINT: squares}
        monkeypatch.setattr(WireStage, "swings", lambda *at, one=on_joint: one.get(at[4], np.empty(0)))
        prices.append(priced(replace(fit)))
    likely = chance(context, JOINT)
    assert prices[1] - prices[0] == pytest.approx(5.0 / likely)
    assert prices[2] - prices[1] == pytest.approx(2.0 * FURTHER * likely)


def test_an_arm_that_does_not_ring_is_told_from_one_that_would(lossy: Recording) -> None:
    rings, stands = _context(lossy), _context(_lost(recorded(seconds=30.0, size=2.0)))
    better = [priced(costed(c, Hypothesis())) - priced(costed(c, _ringing())) for c in (rings, stands)]
    assert better[0] > 1000.0
    assert better[1] < 0.0


def test_motors_are_unseen_where_joints_are_as_well(whole: Recording) -> None:
    stamp = whole.series["gearbox_states"].stamp
    there = (stamp < 8.0) | (stamp > 9.0)
    series = kept(whole, {"gearbox_states": there, "joint_states": there}).series["gearbox_states"]
    assert unseen(series)[JOINT] == pytest.approx(np.array([[7.99, 9.01]]), abs=0.011)
