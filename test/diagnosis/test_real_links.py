"""Real tips and links that give way, where their recordings lie beside the project."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.real import QUASI_STATIC, REAL, diagnosed, marks, named, value

TIP, LINK = "tip-compliance", "flexible-link"

pytestmark = marks(LINK)


@pytest.mark.parametrize("name", ["z-0.105_28", "z-0.105_59", "z-0.205_20", "z-0.205_57"])
def test_the_compliance_of_the_tip_is_that_of_a_straight_line_over_the_measured_force(name: str) -> None:
    result = diagnosed(TIP, name, TIP)
    table = np.genfromtxt(REAL / TIP / f"{name}.csv", delimiter=",", names=True)
    off = table["tip_optical_z_m"] - table["tip_encoder_z_m"]
    compliance, std = value(result, "load_elasticity", "tip_z", "compliance")
    assert compliance == pytest.approx(np.polyfit(table["force_z"], off, 1)[0], rel=0.02)
    assert 0.0 < std < 0.05 * compliance
    assert not QUASI_STATIC & named(result)


@pytest.mark.long
def test_the_flexible_arm_rings_as_it_swings_while_the_hub_stands() -> None:
    result = diagnosed(LINK, "flexarm_K1_6", LINK, until="72%")  # until the hub moves again
    table = np.genfromtxt(REAL / LINK / "flexarm_K1_6.csv", delimiter=",", names=True)
    free = np.convolve(table["tip_deflection_m"], np.ones(51) / 51, "same")[3000:7200]
    ups = np.flatnonzero((free[:-1] < 0.0) & (free[1:] >= 0.0))
    seconds = (ups[-1] - ups[0]) / 1000.0
    counted = (len(ups) - 1) / seconds
    assert value(result, "link_resonance", "arm", "frequency")[0] == pytest.approx(counted, rel=0.08)
    assert value(result, "link_resonance", "arm", "damping")[0] < 0.03


def test_the_rigid_arm_does_not_ring() -> None:
    assert not named(diagnosed(LINK, "rigidarm_K1_6", LINK))
