"""Wires that stretch before the friction: what the load moves while the joint sticks, and the dead band."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.effects.wire.sagging import Sagging
from trunk_ros.effects.wire.wire_slack import WireSlack
from trunk_ros.effects.wire.wire_stiffening import WireStiffening
from trunk_ros.model import Model, load_model

ARM = load_model("trunk").arm
STAMP = np.arange(0.0, 20.0, 0.01)


def loaded(moment: float) -> Now:
    """One joint under a load [N m]."""
    one = np.zeros((1, 1))
    return Now(np.zeros(1), np.zeros(1), one, one, one + moment, one, one, ("joint_1",), np.ones(1))


def shown(upstream: float, others: float) -> Array:
    """(n,) joint 1 at rest, whose load swings as joint 2 moves by ``others`` rad."""
    model = Model(ARM, {"load_elasticity": {"compliance": np.full(5, 0.05), "upstream": upstream}})
    gearbox = np.zeros((len(STAMP), 5))
    gearbox[:, 1] = others * np.sin(STAMP) / ARM.ratio[1]
    return np.asarray(Chain(model, "wire").run(gearbox, STAMP)[0][:, 0])


def test_a_load_that_changes_within_the_dead_band_shows_only_what_lies_behind_the_friction() -> None:
    behind, both, before = (float(np.ptp(shown(share, 0.02))) for share in (0.0, 0.5, 1.0))
    assert behind > 1e-4
    assert both == pytest.approx(behind / 2.0, rel=0.02)
    assert before == pytest.approx(0.0, abs=1e-9)


BENT = [
    (WireStiffening, "moment", "tangent"),
    (WireStiffening, "moment", "secant"),
    (WireStiffening, "moment", "smooth"),
    (WireSlack, "threshold", "sharp"),
]


def bent(kind: type[Sagging], bend: str, form: str) -> Sagging:
    """A wire of 0.03 rad/(N m) that bends at 0.1 N m."""
    return kind({bend: np.array([0.1]), "compliance": np.array([0.03])}, {}, form)


@pytest.mark.parametrize(("kind", "bend", "form"), BENT)
def test_a_joint_that_sticks_rests_wherever_friction_and_load_balance_the_wire(
    kind: type[Sagging], bend: str, form: str
) -> None:
    friction, moment, block = 0.04, 0.07, bent(kind, bend, form)
    core = Core(width=np.array([[0.03 * friction]]))
    block.adjust(core, loaded(moment))
    least, most = (float(block.sag(np.array([[moment + f]]))[0, 0]) for f in (-friction, friction))
    behind = float(block.sag(np.array([[moment]]))[0, 0] + np.asarray(core.middle)[0, 0])
    half = float(core.width[0, 0])
    assert (behind - half, behind + half) == pytest.approx((least, most))


@pytest.mark.parametrize(("kind", "bend", "form"), BENT)
def test_a_dead_band_that_a_stiff_wire_cannot_hold_is_not_its_own(
    kind: type[Sagging], bend: str, form: str
) -> None:
    for compliance in (0.0, 1e-9, 1e-6):
        block = kind({bend: np.array([0.1]), "compliance": np.array([compliance])}, {}, form)
        core = Core(width=np.array([[0.01]]))
        block.adjust(core, loaded(0.07))
        assert float(core.width[0, 0]) == pytest.approx(0.01, rel=1e-3)


@pytest.mark.parametrize(("kind", "bend", "form"), BENT)
def test_a_small_dead_band_follows_the_stiffness(kind: type[Sagging], bend: str, form: str) -> None:
    small, step = np.array([[1e-7]]), 1e-6
    for moment in (0.0, 0.07, 0.2):
        block, core = bent(kind, bend, form), Core(width=small)
        block.adjust(core, loaded(moment))
        ends = (block.sag(np.array([[moment + off]])) for off in (step, -step))
        slope = float(np.subtract(*ends)[0, 0]) / (2.0 * step) / 0.03
        assert float(core.width[0, 0] / small[0, 0]) == pytest.approx(slope, rel=1e-3)
        assert abs(float(np.asarray(core.middle)[0, 0])) < 1e-9


@pytest.mark.parametrize(("kind", "bend", "form"), BENT)
def test_each_look_has_its_own_load_also_in_an_array_that_is_used_again(
    kind: type[Sagging], bend: str, form: str
) -> None:
    block, now, still = bent(kind, bend, form), loaded(0.07), np.zeros((1, 1))
    first, _ = block.run(still, now, None)
    now.load[:] = -0.2
    second, _ = block.run(still, replace(now), None)
    assert (float(first[0, 0]), float(second[0, 0])) == pytest.approx(
        tuple(float(block.sag(np.array([[moment]]))[0, 0]) for moment in (0.07, -0.2))
    )


@pytest.mark.parametrize("second", [{}, {"share_2": np.full(5, 0.4), "time_constant_2": 3.0}])
@pytest.mark.parametrize("rubbing", [0.0, 0.5, 2.0])
def test_a_wire_that_creeps_before_the_friction_gives_way_under_it_while_the_joint_is_held(
    rubbing: float, second: dict[str, Any]
) -> None:
    creep = {"gain": np.zeros(5), "rubbing": np.full(5, rubbing), "time_constant": 1.0, **second}
    creep["form"] = "upstream_two_modes" if second else "upstream"
    stamp = np.arange(0.0, 20.0, 1e-3)
    there_and_back = np.interp(stamp, [0.0, 0.02, 19.0, 19.1], [0.0, 0.1, 0.1, 0.099])
    gearbox = there_and_back[:, None] / ARM.ratio
    shown, _ = Chain(Model(ARM, {"viscoelastic_creep": creep}), "wire").run(gearbox, stamp)
    needed = 0.1 - there_and_back[shown[:, 0] > shown[18900, 0] - 1e-9][-1]
    assert needed == pytest.approx(ARM.dead_band[0] * (1.0 + 1.0 / (1.0 + rubbing)), rel=0.1)
