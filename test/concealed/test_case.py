"""Claims about drawn cases: strength, reproducibility, recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from test.concealed.bag import write_bag
from test.concealed.case import draw_case, turn
from test.concealed.catalogue import CATALOGUE
from test.concealed.generate import generate, kind_of
from test.concealed.hidden import KNOWN, REGIME, UNKNOWN
from test.concealed.nominal import nominal_wire
from test.concealed.removed import read_angles
from test.concealed.sensing import Sensing

FIXED = ("load_elasticity", "wire_slack", "wire_stiffening")


def test_every_effect_has_a_draw_and_a_regime() -> None:
    assert set(CATALOGUE) == set(REGIME) == {*KNOWN, *UNKNOWN}


@pytest.mark.parametrize("effect", [e for e in CATALOGUE if e not in FIXED])
def test_an_effect_has_the_strength_that_was_asked_for(effect: str) -> None:
    told = draw_case(11, effects=[effect], level=(6.0, 6.0), train="mixed").truth[0]
    assert told["effect"] == effect
    assert told["strength"] == pytest.approx(6.0, rel=0.1)


@pytest.mark.parametrize("effect", FIXED)
def test_a_wire_that_gives_way_shows_well_above_the_noise(effect: str) -> None:
    assert draw_case(12, effects=[effect]).truth[0]["strength"] > 1.0


def test_effects_of_a_case_keep_their_strength_beside_each_other() -> None:
    case = draw_case(5, count=3, level=(2.0, 20.0))
    assert len(case.truth) == 3
    assert all(one["strength"] > 1.4 for one in case.truth)


def test_a_clean_arm_leaves_white_noise_of_the_drawn_size() -> None:
    case = draw_case(3, count=0, sensing=Sensing(noise=1e-4))
    left = (case.train.topics["joint_states"]["position"] - case.train.theta_clean)[300:]
    seen = case.train.topics["gearbox_states"]["position"]
    np.testing.assert_allclose(left.std(axis=0), 1e-4, rtol=0.05)
    assert abs(np.corrcoef(left[1:, 0], left[:-1, 0])[0, 1]) < 0.05
    assert np.abs(nominal_wire(seen) - case.train.theta_clean).max() < 4e-5  # an encoder count
    assert case.truth == []


def test_the_same_seed_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        generate(range(4, 5), tmp_path / name, seconds=20.0)
    for file in ("train/train.mcap", "test/test.mcap", "truth.json"):
        one, other = ((tmp_path / name / "case_0004" / file).read_bytes() for name in ("a", "b"))
        assert one == other


def test_two_seeds_give_two_arms() -> None:
    a, b = (draw_case(seed, count=1).train.theta_clean for seed in (20, 21))
    assert not np.array_equal(a, b)


def test_a_written_bag_reads_back_as_it_was(tmp_path: Path) -> None:
    case = draw_case(8, count=1, sensing=Sensing(phase=2))
    write_bag(case.train, tmp_path / "train")
    for name, topic in (("joint_states", "joint_states"), ("gearbox_states", "trunk/gearbox_states")):
        back = read_angles(tmp_path / "train", topic)
        np.testing.assert_array_equal(back.angle, case.train.topics[name]["position"])
        np.testing.assert_array_equal(back.stamp, case.train.topics[name]["stamp"])


def test_every_effect_has_its_turn_in_as_many_seeds() -> None:
    assert sorted(turn(seed, KNOWN) for seed in range(27, 54)) == sorted(KNOWN)
    assert sorted(turn(seed, UNKNOWN) for seed in range(13)) == sorted(UNKNOWN)


def test_hard_cases_turn_the_knobs() -> None:
    noise = [draw_case(seed, count=0, hard=True, seconds=10.0).noise for seed in range(40)]
    for knob in ("colour", "bursts", "joint_counts", "clock_ppm", "compensator", "still", "phase"):
        assert 0 < sum(bool(one[knob]) for one in noise) < 40, knob
    assert {one["joint_every"] for one in noise} == {1, 4}


def test_a_lost_burst_takes_its_truth_with_it() -> None:
    run = draw_case(2, count=0, sensing=Sensing(bursts=6)).train
    assert len(run.theta_clean) == len(run.topics["joint_states"]["stamp"]) < 6000


def test_the_mixture_holds_every_kind() -> None:
    assert {kind_of(seed) for seed in range(20)} == {"singles", "pairs", "triples", "clean", "unknown"}
