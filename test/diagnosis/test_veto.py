"""What does not help on blocks that a fit has not seen goes; what does stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import recorded, reshaped
from test.diagnosis.search.looks import ARMS, context, drawn_beside_a_ratio, fitted
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.curves import followed
from trunk_ros.diagnosis.evidence import rivals, veto
from trunk_ros.diagnosis.evidence.evidence import Evidence, evidence, one_evidence
from trunk_ros.diagnosis.evidence.unseen import unrepeated, unseen
from trunk_ros.diagnosis.evidence.veto import believed, harmless
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search.credible import unshown
from trunk_ros.diagnosis.search.fit import Fit, costed, refit
from trunk_ros.diagnosis.search.moves.drop import dropped
from trunk_ros.diagnosis.search.score import beats
from trunk_ros.effects import effect
from trunk_ros.model import load_model

BACKLASH = Term("backlash", own={2: {"half_width": 1.5e-3}})
RIPPLE = Term(
    "transmission_ripple", "two_harmonics",
    own={4: {"amplitude": 1e-6, "cycles_per_rev": 40.0, "phase": 0.3, "harmonic": 0.1, "harmonic_phase": 0}},
)  # fmt: skip

SMALL = Term(
    "transmission_ripple", "sine", own={2: {"amplitude": 3e-5, "cycles_per_rev": 20.0, "phase": 0.5}}
)


def test_what_is_at_work_helps_on_blocks_that_were_not_seen() -> None:
    now = fitted("backlash", BACKLASH)
    assert harmless(now).hypothesis["backlash"].columns == [2]
    with_it, without = (unseen(now.context, h, [2]).sum(axis=1) for h in (now.hypothesis, Hypothesis()))
    assert np.all(without > 2.0 * with_it)


@pytest.mark.parametrize(("named", "kept"), [(True, ["backlash"]), (False, [])])
def test_what_has_no_name_goes_where_it_harms_the_run_itself(
    monkeypatch: pytest.MonkeyPatch, named: bool, kept: list[str]
) -> None:
    """Of noise that remembers, innovations hide what is slow."""
    now = fitted("backlash", BACKLASH)
    change = np.stack([np.full(10, -20.0), np.full(10, 50.0)])
    monkeypatch.setattr(veto, "unseen", lambda _, h, *asked: 100.0 + change * len(h))
    monkeypatch.setattr(effect("backlash"), "named", named)
    assert list(harmless(now).hypothesis) == kept


def test_a_name_that_is_more_likely_wrong_than_right_is_judged_as_what_has_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A lag that noise made likely left a run three times as far off as a constant alone."""
    now = fitted("backlash", BACKLASH)
    change = np.stack([np.full(10, -20.0), np.full(10, 50.0)])
    monkeypatch.setattr(veto, "unseen", lambda _, h, *asked: 100.0 + change * len(h))
    assert list(believed(now, now)[0].hypothesis) == ["backlash"]
    doubted = replace(one_evidence(now, "backlash"), confidence=0.4)
    monkeypatch.setattr(veto, "evidence", lambda part, *_: dict.fromkeys(part.hypothesis, doubted))
    assert list(believed(now, now)[0].hypothesis) == []


def test_what_chance_suggests_goes_joint_by_joint() -> None:
    now = fitted("backlash", BACKLASH, RIPPLE)
    kept = harmless(now).hypothesis
    assert list(kept) == ["backlash"]


def test_a_curve_takes_over_what_went_beside_it() -> None:
    """It is judged so on blocks that were not seen, and so it has to be left."""
    now = drawn_beside_a_ratio()
    without = now.hypothesis.without("ratio_error")
    left = followed(costed(now.context, without), [1])
    assert left.cost[1] < 1.02 * now.cost[1] < 0.5 * costed(now.context, without).cost[1]
    assert harmless(now).cost[1] < 1.02 * now.cost[1]


def test_what_the_model_knows_is_not_questioned() -> None:
    known = context("clean")
    wrong = Hypothesis(ratio_error=Term("ratio_error", own={1: {"relative": 1e-7}}))
    believed = costed(known, wrong)
    believed.context.stage.known["ratio_error"] = wrong["ratio_error"]
    try:
        assert list(harmless(believed).hypothesis) == ["ratio_error"]
    finally:
        del believed.context.stage.known["ratio_error"]
    assert np.isfinite(believed.total)


def test_a_name_that_an_excerpt_shows_nothing_of_is_judged_on_the_whole() -> None:
    """Of a recording with a sample a second the excerpt may have none that counts."""
    now = fitted("backlash", BACKLASH)
    unseen_part = replace(
        now, cost={}, context=now.context.only([np.zeros(len(now.context.views[0].span.rows), dtype=bool)])
    )
    state, _, found = believed(now, unseen_part)
    assert list(state.hypothesis) == ["backlash"]
    assert found["backlash"].confidence > 0.7


def test_a_name_that_gains_less_than_an_effect_has_to_is_not_said() -> None:
    """A ripple that was taken for half of what it is worth while a dead band had no name yet."""
    beside = fitted("backlash", SMALL)
    own = fitted("rippled", SMALL)
    assert one_evidence(beside, "transmission_ripple").gain_share < 1.0
    assert one_evidence(own, "transmission_ripple").gain_share > 1.0
    assert "transmission_ripple" not in believed(beside, beside)[0].hypothesis
    state, part, found = believed(own, own)
    assert state is part is own
    assert list(found) == ["transmission_ripple"]


def test_a_rival_that_is_better_takes_the_place_of_a_name() -> None:
    """Which a search that ended early may have left."""
    wrong = fitted(
        "backlash", Term("stribeck_friction", "gaussian", own={2: {"amplitude": 1e-3, "velocity": 0.05}})
    )
    assert list(wrong.hypothesis) == ["stribeck_friction"]
    state, part, found = believed(wrong, wrong)
    assert state is part
    assert list(state.hypothesis) == list(found) == ["backlash"]
    assert beats(state, wrong)


def test_one_name_on_all_joints_takes_the_place_of_two_that_explain_less() -> None:
    """A tension and more on some joints say as little of five dead bands, in fewer values."""
    wide = {c: {"half_width": 1e-4} for c in (0, 1)}
    tension = Term("tension_error", shared={"factor": 1.3}, own={c: {} for c in range(5)})
    two = fitted("all looser", Term("backlash", own=wide), tension)
    assert set(two.hypothesis) == {"backlash", "tension_error"}
    state, _, found = believed(two, two)
    assert list(state.hypothesis) == list(found) == ["backlash"]
    assert state.hypothesis["backlash"].columns == [0, 1, 2, 3, 4]
    assert state.total < two.total


def test_what_the_motion_hides_on_all_joints_is_no_rival(monkeypatch: pytest.MonkeyPatch) -> None:
    now = fitted("backlash", BACKLASH)
    assert evidence(now)["backlash"].rivals
    monkeypatch.setattr(rivals, "hidden", lambda context, term: term.columns)
    alone = evidence(now)["backlash"]
    assert not alone.rivals
    assert not alone.fitted
    assert not any(isinstance(said, str) for said in alone.equivalents)


@pytest.mark.parametrize("other", ["backlash", "clean"])
def test_a_rival_has_to_tell_recordings_that_it_was_not_fitted_to(other: str) -> None:
    """What one of two recordings shows and the other does not is ahead on both together."""
    model = load_model("trunk")
    spans = [wire_span(recorded(ARMS[arm], 40.0, seed=k), model) for k, arm in enumerate(("backlash", other))]
    two = context("backlash").over(spans)
    nothing, rival = (refit(two, Hypothesis({t.effect: t for t in terms})) for terms in ((), (BACKLASH,)))
    assert beats(rival, nothing)
    found = unrepeated(nothing, {"backlash": rival.hypothesis})
    assert list(found) == ([] if other == "backlash" else ["backlash"])


def test_a_rival_takes_a_place_beside_the_names_of_now() -> None:
    """One that was kept since another name was dropped, and one came."""
    wrong = Term("stribeck_friction", "gaussian", own={2: {"amplitude": 1e-3, "velocity": 0.05}})
    ratio = Term("ratio_error", own={1: {"relative": 1e-6}})
    now, before = fitted("backlash", wrong, ratio), Hypothesis(backlash=BACKLASH, transmission_ripple=RIPPLE)
    kept = Evidence({2: 1.0}, 1.0, 1.0, rivals={"backlash": -1.0}, fitted={"backlash": before})
    better = veto._better(now, {"stribeck_friction": kept})
    assert better is not None
    assert {n: term.columns for n, term in better.hypothesis.items()} == {"ratio_error": [1], "backlash": [2]}


def test_a_name_gains_more_than_a_rival_does_beyond_it() -> None:
    gained = Evidence({2: 300.0}, 100.0, 1.0)
    behind = replace(gained, rivals={"backlash": 50.0, "wire_slip": -200.0})
    ahead = replace(gained, rivals={"backlash": 50.0, "wire_slip": -2000.0})
    assert gained.gain_share == 3.0
    assert behind.gain_share == 1.5
    assert ahead.gain_share < 1.0


def test_what_did_not_change_is_not_fitted_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """One ripple after the other goes; the dead band of another joint stays what it is."""
    asked: list[tuple[str, ...]] = []

    def noted(context: Context, hypothesis: Hypothesis, columns: list[int], whole: bool) -> np.ndarray:
        asked.append((*map(str, columns), *(str(hypothesis.key(c)) for c in columns)))
        return unseen(context, hypothesis, columns, whole)

    now = fitted("backlash", BACKLASH, RIPPLE)
    monkeypatch.setattr(veto, "unseen", noted)
    assert list(harmless(now).hypothesis) == ["backlash"]
    assert len(asked) == len(set(asked)) == 4


def test_evidence_is_gathered_anew_for_what_a_change_touched(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[list[str]] = []

    def noted(state: Fit, whole: Fit, work: Work, before: dict[str, Evidence]) -> dict[str, Evidence]:
        asked.append([name for name in state.hypothesis if name not in before])
        return evidence(state, whole, work, before)

    beside = fitted("backlash", BACKLASH, Term("ratio_error", own={4: {"relative": 1e-6}}))
    monkeypatch.setattr(veto, "evidence", noted)
    assert list(believed(beside, beside)[0].hypothesis) == ["backlash"]
    first, *later = asked
    assert first == ["backlash", "ratio_error"]
    assert later
    assert not any("backlash" in names for names in later)


def test_evidence_counts_as_work_of_the_diagnosis() -> None:
    now = fitted("backlash", BACKLASH)
    counted = replace(now, context=replace(now.context, work=Work()))
    believed(counted, counted)
    assert counted.context.work.done > 0
    assert not counted.context.work.over


def test_a_name_that_is_bent_to_a_curve_once_another_one_is_gone_goes_as_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside a slip that was none it was a ripple; alone it was a third of a period, at 95 %."""
    model, made = load_model("trunk"), recorded(None, 40.0)
    shown = made.series["joint_states"]
    angle = shown.position[:, 2]
    bent = shown.position + np.outer(0.02 * np.sin(1.2 * angle / np.ptp(angle) + 0.4), np.arange(5) == 2)
    there = context("clean").over([wire_span(reshaped(made, "joint_states", position=bent), model)])
    turns = np.ptp(made.series["gearbox_states"].position[:, 2]) / (2.0 * np.pi)
    wave = {"amplitude": 2e-4, "cycles_per_rev": 1.8 / turns, "phase": 0.4}
    slip = Term("wire_slip", own={2: {"onset": 20.0, "step": 5e-3}})
    ripple = Term("transmission_ripple", "sine", own={2: wave})
    now = costed(there, Hypothesis(wire_slip=slip, transmission_ripple=ripple))
    assert unshown(now.context, now.hypothesis) == 0
    alone = dropped(now, "wire_slip", 2)
    assert unshown(alone.context, alone.hypothesis) == 1
    harmful, worst = iter([("wire_slip", 2)]), veto._worst
    monkeypatch.setattr(veto, "_worst", lambda *asked: next(harmful, None) or worst(*asked))
    kept = harmless(now)
    assert "transmission_ripple" not in kept.hypothesis
    assert kept.cost[2] < 0.1 * now.cost[2]
