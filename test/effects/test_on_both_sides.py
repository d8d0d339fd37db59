"""Wires that stretch before the friction: what the load moves while the joint sticks, and the dead band."""

from __future__ import annotations

import numpy as np
import pytest

from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Now
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


def test_a_wire_that_hardens_narrows_the_dead_band_and_a_slack_one_widens_it() -> None:
    def width(kind: type[WireStiffening | WireSlack], bend: str, form: str, moment: float) -> float:
        block = kind({bend: np.array([0.1]), "compliance": np.array([0.03])}, {}, form)
        return float(block.softening(loaded(moment))[0, 0])

    for form in WireStiffening.forms:
        assert width(WireStiffening, "moment", form, 0.0) == 1.0
        assert width(WireStiffening, "moment", form, 0.1) == pytest.approx(0.5, abs=0.01)
        step = 1e-6  # the softening is the slope of the sag
        block = WireStiffening({"moment": np.array([0.1]), "compliance": np.array([0.03])}, {}, form)
        slope = (block.sag(loaded(0.07 + step)) - block.sag(loaded(0.07))) / step / 0.03
        assert width(WireStiffening, "moment", form, 0.07) == pytest.approx(float(slope[0, 0]), rel=1e-3)
    assert width(WireSlack, "threshold", "sharp", 0.0) == pytest.approx(1.0, abs=1e-6)
    assert width(WireSlack, "threshold", "sharp", 0.2) == pytest.approx(2.0, abs=1e-6)
