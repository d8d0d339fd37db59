"""Banks take the sources that help on blocks that they were not fitted to, and no others."""

from __future__ import annotations

import numpy as np
import pytest

from test.effects.example import arm_of
from trunk_ros.data.motion_content import passes_again
from trunk_ros.diagnosis.discrepancy.bank_weights import CUTS, FOLDS, Cuts, Source, Sums, chosen_of
from trunk_ros.diagnosis.discrepancy.banked import clearly
from trunk_ros.effects.bank import Bank
from trunk_ros.effects.drags import Drags
from trunk_ros.effects.wire.coupling_curve import CouplingCurve
from trunk_ros.effects.wire.coupling_drag import CouplingDrag
from trunk_ros.effects.wire.unknown_loops import UnknownLoops
from trunk_ros.effects.wire.unknown_memory import UnknownMemory
from trunk_ros.effects.wire.unknown_settling import UnknownSettling
from trunk_ros.errors import ModelError
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.encoder import between_counts, noises
from trunk_ros.recording.signal.resample import resample

RNG = np.random.default_rng(4)
MOTIONS = {name: np.repeat(RNG.uniform(-1.0, 1.0, 100), 10) for name in ("a", "b", "c")}


def sources() -> list[Source]:
    """A curve and a drag of three motions each."""
    out = []
    for kind in (CouplingCurve, CouplingDrag):
        for name, motion in MOTIONS.items():
            low, high = kind.range_of(motion)
            out.append(Source(kind, name, low, high, 100.0 * kind.shapes(motion, low, high)))
    return out


def test_what_a_curve_and_a_drag_made_is_found_in_them() -> None:
    found = sources()
    rest = found[0].design @ np.sin(np.arange(8.0)) + found[4].design @ np.linspace(0.1, 0.4, 8)
    rest = rest + RNG.normal(size=len(rest))
    chosen = chosen_of(Sums.of(found, rest, Cuts.of([len(rest)])), found, 1.0)
    assert {(found[k].kind, found[k].word) for k in chosen} == {(CouplingCurve, "a"), (CouplingDrag, "b")}
    unseen = Sums.of(found, rest, Cuts.of([len(rest)])).tried(chosen, 1.0).unseen
    assert unseen == pytest.approx(1.0, abs=0.2)


def test_nothing_is_found_in_noise() -> None:
    found, rest = sources(), RNG.normal(size=1000)
    assert chosen_of(Sums.of(found, rest, Cuts.of([len(rest)])), found, 1.0) == []
    assert Sums.of(found, rest, Cuts.of([len(rest)])).tried([], 1.0).unseen == pytest.approx(np.mean(rest**2))


def test_a_drag_is_bounded_by_its_reach() -> None:
    far = np.linspace(0.0, 50.0, 200)
    assert np.abs(Drags.shapes(far, 0.1, 0.7)).max() == pytest.approx(0.7)


def test_a_source_that_there_is_not_is_refused_with_a_choice() -> None:
    effects = {"coupling_curve": {"weight_1_1": np.array([0.1, 0.0]), "source": ["joint_9", ""]}}
    with pytest.raises(ModelError, match="choose from joint_2"):
        Model(arm_of(2), effects).bound("wire")
    assert UnknownMemory.choices(("a", "b"), "a") == ["a", "a+b", "a-b"]


def test_commands_of_a_recording_that_stops_to_measure_are_exact() -> None:
    stamp = np.cumsum(RNG.uniform(0.4, 1.0, 400))
    series = JointSeries(stamp, ("a",), RNG.uniform(-1.0, 1.0, (400, 1)))
    assert noises(series)[0] == 0.0
    assert between_counts(series) is series
    for late in (-0.1, 0.1):  # whichever topic was read first at a stop
        read, _ = resample(series, stamp + late)
        assert np.array_equal(read, series.position)


def bent_friction(s: np.ndarray) -> np.ndarray:
    """(n,) of a wire whose friction grows with the bend of its guide: one play of a width that is known."""
    held = Drags.shapes(s, 0.1, 0.1000001)[:, 0]
    return 0.3 * held * (1.0 + 0.8 * np.sin(2.0 * s))


def swept(seed: int, rows: int = 3000) -> np.ndarray:
    """(rows,) rad of a joint that turns back at many postures."""
    rng, time = np.random.default_rng(seed), np.linspace(0.0, 60.0, rows)
    tones = [rng.uniform(0.2, 0.4) * np.sin(rate * time + rng.uniform(0.0, 6.0)) for rate in (0.3, 0.9, 2.1)]
    return np.asarray(np.sum(tones, axis=0))


def test_loops_that_change_with_the_posture_are_found_where_plays_of_one_shape_fail() -> None:
    s = swept(1)
    found = []
    for kind in (UnknownMemory, UnknownLoops):
        low, high = kind.range_of(s)
        found.append(Source(kind, "a", low, high, 1e4 * kind.shapes(s, low, high)))
    rest = 1e4 * bent_friction(s) + RNG.normal(size=len(s))
    sums = Sums.of(found, rest, Cuts.of([len(rest)]))
    assert sums.tried([1], 1.0).unseen < 0.2 * sums.tried([0], 1.0).unseen
    assert 1 in chosen_of(sums, found, 1.0)


def test_of_several_recordings_each_is_left_out_as_a_whole() -> None:
    cuts = Cuts.of([700, 900, 400])
    recording = np.repeat([0, 1, 2], [700, 900, 400])
    assert all(len(np.unique(recording[cuts.fold[cuts.number] == fold])) == 1 for fold in range(3))
    for counts in ([700], [700, 0]):
        alone = Cuts.of(counts)
        assert len(np.unique(alone.fold[alone.number])) == FOLDS


def test_a_line_goes_on_beyond_the_postures_that_were_seen_and_a_bend_does_not() -> None:
    weights = np.zeros(UnknownLoops.weights)
    alone = UnknownLoops.weights - UnknownLoops.groups[-1]
    weights[alone + 1 : alone + 3] = 0.1, 0.3  # a line, and a bend
    out = np.zeros(3)
    UnknownLoops.add(np.array([1.0, 1.5, 2.0]), UnknownLoops.ready(0.0, 1.0, weights), None, out)
    assert np.diff(out) == pytest.approx([0.1, 0.1])


def settled(rest: np.ndarray, s: np.ndarray) -> tuple[list[int], Sums, list[Source]]:
    """Which of loops that stay (0) and loops that fade (1) a residual over a motion (rows,) needs."""
    found = []
    for kind in (UnknownLoops, UnknownSettling):
        low, high = kind.range_of(s)
        found.append(Source(kind, "a", low, high, 1e4 * kind.shapes(s, low, high)))
    sums = Sums.of(found, 1e4 * rest + RNG.normal(size=len(s)), Cuts.of([len(rest)]))
    return chosen_of(sums, found, 1.0), sums, found


def test_a_loop_that_settles_from_swing_to_swing_is_told_and_goes_on_as_it_will() -> None:
    time = np.linspace(0.0, 25.0, 5000)
    s = 0.5 - 0.5 * np.cos(time)
    rest = bent_friction(s) * (1.0 - 0.4 * np.exp(-time / 6.0)) + 0.02 * np.exp(-time / 8.0)
    seen = 3500
    chosen, sums, found = settled(rest[:seen], s[:seen])
    assert chosen == [0, 1]
    errors = []
    for some in ([0], chosen):
        weights = np.split(sums.weights(some, 1.0), [found[0].kind.weights])
        said = sum(found[k].kind.shapes(s, 0.0, 1.0) @ w for k, w in zip(some, weights, strict=False))
        errors.append(float(np.sqrt(np.mean((rest - said)[seen:] ** 2))))
    assert errors[1] < 0.3 * errors[0]


def test_what_settles_is_shown_by_places_that_are_passed_again() -> None:
    time = np.linspace(0.0, 1.0, 1000)
    assert passes_again(np.cos(4.0 * np.pi * time))
    assert not passes_again(np.cos(2.6 * np.pi * time))
    assert not passes_again(time)
    assert not passes_again(np.zeros(100))
    ends = ((0.0, 0.5), (0.5, 0.5), (0.5, 1.0), (1.0, 0.5), (0.5, 0.5), (0.5, 0.0))
    once = np.concatenate([np.linspace(first, last, 500) for first, last in ends])
    assert not passes_again(once + 1e-4 * RNG.normal(size=len(once)))


def test_of_a_loop_that_stays_as_it_is_nothing_fades() -> None:
    s = swept(4)
    assert settled(bent_friction(s), s)[0] == [0]


@pytest.mark.parametrize("kind", [UnknownLoops, UnknownMemory, UnknownSettling])
def test_a_bank_is_the_sum_of_its_shapes(kind: type[Bank]) -> None:
    s = swept(3)
    low, high = kind.range_of(0.8 * s)
    weights, out = RNG.normal(size=kind.weights), np.zeros(len(s))
    kind.add(s, kind.ready(low, high, weights), None, out)
    np.testing.assert_allclose(kind.shapes(s, low, high) @ weights, out, atol=1e-9)


def test_no_play_of_a_bank_is_too_wide_to_slide() -> None:
    s = np.tile(np.concatenate([np.linspace(-1.0, 1.0, 200), np.linspace(1.0, -1.0, 200)]), 2)
    held = Drags.shapes(s, *Drags.range_of(s))
    assert (np.ptp(s[:, None] - held, axis=0) > 0.1 * np.ptp(s)).all()


def test_what_leaves_half_of_most_blocks_wins_though_those_that_were_right_get_worse() -> None:
    """Where names happen to be right there is little to lose: 30 times more of next to nothing."""
    power = np.where(np.arange(CUTS) % 3 == 0, 1.0, np.random.default_rng(1).uniform(50.0, 150.0, CUTS))
    banked = np.where(power > 1.0, 0.5 * power, 30.0)
    assert clearly(power, banked, 0.05)
    assert not clearly(banked, power, 0.05)


def test_one_block_that_gets_better_is_chance() -> None:
    power = np.where(np.arange(CUTS) == 7, 1000.0, 10.0)
    assert not clearly(power, np.minimum(power, 10.0), 0.05)
