"""A real tendon in a sheath, where its recordings lie beside the project: dead bands, nothing of speed."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import diagnose
from test.diagnosis.real import QUASI_STATIC, diagnosed, marks, named, read, value

SHEATH = "tendon-sheath"
HALF = "50%"  # shows as much of what repeats itself
LONG = ("test0224", "aurora_ff")

pytestmark = [*marks(SHEATH), pytest.mark.long]


@pytest.mark.parametrize(
    ("name", "mapping"),
    [
        ("test0224", "tendon-sheath"),
        ("aurora_ff", "tendon-sheath-feedforward"),
        ("sheath_000deg", "tendon-sheath"),
        ("sheath_240deg", "tendon-sheath"),
    ],
)
def test_a_slow_swing_of_the_tendon_sheath_shows_a_dead_band_and_nothing_of_speed(
    name: str, mapping: str
) -> None:
    """Of sheaths that are bent, the straightest and the most bent one; the next test has one between."""
    result = diagnosed(SHEATH, name, mapping, HALF if name in LONG else None)
    assert "backlash" in named(result)
    assert not QUASI_STATIC & named(result)


def test_a_bent_sheath_has_a_wider_dead_band_and_moves_its_end_less_than_a_straight_one() -> None:
    straight = diagnosed(SHEATH, "sheath_000deg", SHEATH)
    run = read(SHEATH, "sheath_180deg", SHEATH)
    bent = diagnose([run], model=straight.model)
    assert "backlash" in named(bent)
    assert not QUASI_STATIC & named(bent)
    (before, std_before), (after, std_after) = (
        value(result, "backlash", "bend", "half_width") for result in (straight, bent)
    )
    assert after - before > 3.0 * np.hypot(std_before, std_after)
    shown = [result.model.predict(run).series["joint_states"].position for result in (straight, bent)]
    assert np.ptp(shown[1]) < 0.9 * np.ptp(shown[0])  # by its ratio, or by the rounding of its reversals
