"""Banks take the sources that help on blocks that they were not fitted to, and no others."""

from __future__ import annotations

import numpy as np
import pytest

from test.effects.example import arm_of
from trunk_ros.diagnosis.discrepancy.memory import CUTS, Source, Sums, chosen_of
from trunk_ros.effects.bank import choices
from trunk_ros.effects.drags import Drags
from trunk_ros.effects.wire.coupling_curve import CouplingCurve
from trunk_ros.effects.wire.coupling_drag import CouplingDrag
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
    chosen = chosen_of(Sums.of(found, rest), found, 1.0)
    assert {(found[k].kind, found[k].word) for k in chosen} == {(CouplingCurve, "a"), (CouplingDrag, "b")}
    assert Sums.of(found, rest).unseen(chosen, 1.0).mean() == pytest.approx(1.0, abs=0.2)


def test_nothing_is_found_in_noise() -> None:
    found, rest = sources(), RNG.normal(size=1000)
    assert chosen_of(Sums.of(found, rest), found, 1.0) == []
    assert len(Sums.of(found, rest).unseen([], 1.0)) == CUTS


def test_a_drag_is_bounded_by_its_reach() -> None:
    far = np.linspace(0.0, 50.0, 200)
    assert np.abs(Drags.shapes(far, 0.1, 0.7)).max() == pytest.approx(0.7)


def test_a_source_that_there_is_not_is_refused_with_a_choice() -> None:
    effects = {"coupling_curve": {"weight_1_1": np.array([0.1, 0.0]), "source": ["joint_9", ""]}}
    with pytest.raises(ModelError, match="choose from joint_2"):
        Model(arm_of(2), effects).bound("wire")
    assert choices(("a", "b"), "a", own=True) == ["a", "a+b", "a-b"]


def test_commands_of_a_recording_that_stops_to_measure_are_exact() -> None:
    stamp = np.cumsum(RNG.uniform(0.4, 1.0, 400))
    series = JointSeries(stamp, ("a",), RNG.uniform(-1.0, 1.0, (400, 1)))
    assert noises(series)[0] == 0.0
    assert between_counts(series) is series
    held, _ = resample(series, stamp[:-1] + 0.3)
    assert np.array_equal(held, series.position[:-1])
