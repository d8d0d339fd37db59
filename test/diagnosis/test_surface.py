"""What two motors do to a joint at once, by a smooth map without memory, is a surface over both."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from test.effects.example import arm_of
from trunk_ros.diagnosis.discrepancy.bank_weights import Cuts, Source, Sums, chosen_of
from trunk_ros.diagnosis.hypothesis import Term
from trunk_ros.diagnosis.verdict import bank_words
from trunk_ros.effects.bank import Bank, motion
from trunk_ros.effects.wire.coupling_curve import CouplingCurve
from trunk_ros.effects.wire.unknown_loops import UnknownLoops
from trunk_ros.effects.wire.unknown_memory import UnknownMemory
from trunk_ros.effects.wire.unknown_surface import ORDERS, UnknownSurface
from trunk_ros.errors import ModelError
from trunk_ros.model import Model

RNG = np.random.default_rng(7)
NOISE = 1e-4
TIME = np.linspace(0.0, 120.0, 4000)
OWN, OTHER = 0.5 * np.sin(1.1 * TIME) + 0.2 * np.sin(2.9 * TIME), 0.6 * np.sin(0.37 * TIME + 1.0)
BOTH = np.column_stack([OWN, OTHER])
MOTIONS: tuple[tuple[type[Bank], str, np.ndarray], ...] = (
    (CouplingCurve, "b", OTHER),
    (UnknownMemory, "a", OWN),
    (UnknownMemory, "a+b", OWN + OTHER),
    (UnknownLoops, "a", OWN),
    (UnknownSurface, "a*b", BOTH),
)


def bent(both: np.ndarray) -> np.ndarray:
    """(n,) rad by which a section bends that two tendons pull: a smooth map of both."""
    return np.asarray(0.02 * np.sin(2.0 * both[:, 0]) * np.cos(1.5 * both[:, 1] + 0.4))


def offered(rest: np.ndarray) -> tuple[Sums, list[Source]]:
    """All that may stand for a residual (n,) rad, on rows of unit noise."""
    found = []
    for kind, word, s in MOTIONS:
        low, high = kind.range_of(s)
        found.append(Source(kind, word, low, high, kind.shapes(s, low, high) / NOISE))
    rest = rest / NOISE + RNG.normal(size=len(rest))
    return Sums.of(found, rest, Cuts.of([len(rest)])), found


def test_what_two_motors_do_at_once_is_a_surface_and_no_memory() -> None:
    sums, found = offered(bent(BOTH))
    chosen = chosen_of(sums, found, 1.0)
    assert [found[k].kind for k in chosen] == [UnknownSurface]
    assert sums.tried(chosen, 1.0).unseen == pytest.approx(1.0, abs=0.2)


def test_what_remembers_is_no_surface() -> None:
    held = np.zeros(len(OWN))
    low, high = UnknownLoops.range_of(OWN)
    weights = np.zeros(UnknownLoops.weights)
    weights[6] = 0.004
    UnknownLoops.add(OWN, UnknownLoops.ready(low, high, weights), None, held)
    sums, found = offered(held)
    assert UnknownSurface not in {found[k].kind for k in chosen_of(sums, found, 1.0)}


def test_of_one_motion_alone_a_curve_is_enough() -> None:
    sums, found = offered(0.005 * np.sin(1.5 * OTHER))
    assert [found[k].kind for k in chosen_of(sums, found, 1.0)] == [CouplingCurve]


def test_high_orders_of_a_smooth_map_are_small() -> None:
    sums, found = offered(bent(BOTH))
    surface = next(k for k, source in enumerate(found) if source.kind is UnknownSurface)
    weights, total = sums.weights([surface], 1.0), np.sum(ORDERS, axis=1)
    sizes = [float(np.sqrt(np.mean(weights[total == k] ** 2))) for k in (1, 7)]
    assert sizes[1] < 0.1 * sizes[0]


def test_it_is_held_at_the_edge_of_what_was_seen() -> None:
    weights = RNG.normal(size=UnknownSurface.weights)
    ready, out = UnknownSurface.ready((-1.0, 0.0), (1.0, 2.0), weights), np.zeros(2)
    UnknownSurface.add(np.array([[1.0, 0.0], [9.0, -3.0]]), ready, None, out)
    assert out[1] == pytest.approx(out[0])


def test_its_steepest_slope_bounds_what_the_joint_follows_itself() -> None:
    weights, (low, high) = RNG.normal(size=UnknownSurface.weights), UnknownSurface.range_of(BOTH)
    steepest = UnknownSurface.steepness(low, high, weights)
    for other in np.linspace(low[1], high[1], 9):
        own = np.linspace(low[0], high[0], 500)
        along = UnknownSurface.shapes(np.column_stack([own, np.full(500, other)]), low, high) @ weights
        assert np.abs(np.diff(along) / np.diff(own)).max() < 1.02 * steepest


def test_it_is_over_the_joint_itself_and_another_one() -> None:
    assert UnknownSurface.choices(("a", "b", "c"), "b") == ["b*a", "b*c"]
    effects = {"unknown_surface": {"weight_1_1": np.array([0.1, 0.0]), "source": ["joint_2*joint_1", ""]}}
    with pytest.raises(ModelError, match=r"choose from joint_1\*joint_2"):
        Model(arm_of(2), effects).bound("wire")
    now: Any = SimpleNamespace(wires=BOTH, joints=("a", "b"))
    assert np.array_equal(motion("a*b", now), BOTH)


def test_the_verdict_draws_it_over_both_joints() -> None:
    low, high = UnknownSurface.range_of(BOTH)
    weights = RNG.normal(size=UnknownSurface.weights)
    own = UnknownSurface.said(1, low, high, weights)
    term = Term("unknown_surface", own={0: own}, words={0: {"source": "a*b"}})
    stage = SimpleNamespace(unit=lambda _: "rad", units={})
    told = bank_words.told(
        SimpleNamespace(joints=("a", "b"), stage=stage),  # type: ignore[arg-type]
        UnknownSurface,
        term,
    )
    drawn = told["joints"]["a"]
    assert (told["on"], drawn["with"]) == ("position", "b")
    at = np.array([[drawn["x"][3], drawn["with_x"][5]]])
    assert drawn["y"][3, 5] == pytest.approx(float((UnknownSurface.shapes(at, low, high) @ weights)[0]))
    assert bank_words.varies_with(term) == ["a", "b"]
    assert "surface" in bank_words.statement(UnknownSurface, term, "a")


def test_a_sum_or_difference_that_joints_name_the_other_way_round_is_told_once() -> None:
    """A page had listed joint_2+joint_3 and joint_3+joint_2 as two things that a differential depends on."""
    words = {
        0: {"source": "a+b", "source_2": "a-b"},
        1: {"source": "b+a", "source_2": "b-a", "source_3": "b"},
    }
    term = Term("unknown_memory", own={0: {}, 1: {}}, words=words)
    assert bank_words.varies_with(term) == ["a+b", "a-b", "b"]
