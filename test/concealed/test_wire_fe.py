"""Claims about the finite-element wire: what is known of capstan drives comes out of springs and contacts."""

from __future__ import annotations

import numpy as np
import pytest

from test.concealed.nominal import COMPLIANCE, HALF_WIDTH, RATIO, Array, nominal_wire
from test.concealed.trajectory import draw_reference
from test.concealed.wire_case import draw_wire_case, nominal_pair
from test.concealed.wire_fe import chain_of, joint_angle, nodes_of, pair_of, tensions_of

THERE_AND_BACK = np.concatenate([np.linspace(0, 0.02, 300), np.linspace(0.02, -0.02, 2000)])
WRAP = 0.10 * 0.9774 + 0.08 * 0.4189


def _follows(shear: float) -> tuple[Array, Array]:
    """Travel after a reversal, and the slope of the joint against the wheel on it."""
    angle = joint_angle(pair_of(4, 20.0, shear=shear), THERE_AND_BACK / RATIO)
    return 0.02 - THERE_AND_BACK[301:], np.diff(angle[300:]) / np.diff(THERE_AND_BACK[300:])


def test_the_capstan_ratio_emerges_in_full_slip() -> None:
    pair = pair_of(2, 5.0)
    pull = tensions_of(pair, nodes_of(pair, np.linspace(0, 0.05, 200)))[-1]
    joint = chain_of(pair).middle
    assert pull[joint - 1] / pull[0] == pytest.approx(np.exp(WRAP), rel=1e-6)
    assert pull[-1] / pull[joint] == pytest.approx(np.exp(WRAP), rel=1e-6)


def test_after_a_reversal_the_wire_slips_from_the_wheel_on_while_the_joint_stands() -> None:
    pair = pair_of(4, 20.0)
    nodes = nodes_of(pair, THERE_AND_BACK / RATIO)
    places = nodes + RATIO * (0.016 * THERE_AND_BACK / RATIO)[:, None]
    early, joint = slice(299, 299 + 60), chain_of(pair).middle
    moved = np.abs(np.diff(places[early], axis=0)).sum(axis=0)[:joint]
    assert moved[1] > 100 * moved[joint - 1] + 1e-9
    assert (np.diff(moved[1:joint]) <= 1e-12).all()


def test_the_dead_band_is_proportional_to_the_pretension() -> None:
    ends = [joint_angle(pair_of(3, pull), THERE_AND_BACK / RATIO)[-1] for pull in (5.0, 20.0)]
    assert ends[1] + 0.02 == pytest.approx(4 * (ends[0] + 0.02), rel=1e-6)


def test_bare_wire_reverses_sharply_and_a_soft_coating_rounds_it() -> None:
    travel, bare = _follows(1e12)
    _, soft = _follows(3e7)
    full = travel[np.argmax(bare > 0.99)]
    assert bare[travel < 0.95 * full].max() < 0.01
    assert 0.05 < soft[travel < 0.5 * full].mean() < 0.9
    assert travel[np.argmax(soft > 0.99)] > full


def test_the_loop_closes_and_small_motions_are_swallowed() -> None:
    t = np.linspace(0, 6 * np.pi, 1500)
    angle = joint_angle(pair_of(1, 20.0), 2e-4 * np.sin(t) / RATIO)
    assert np.ptp(angle) < 1e-9
    wide = joint_angle(pair_of(1, 20.0), 0.01 * np.sin(t) / RATIO)
    np.testing.assert_allclose(wide[500:1000], wide[1000:], atol=1e-4)


def test_a_load_stretches_both_wires_of_the_pair() -> None:
    tau = np.linspace(0, 0.01, 200)
    given = joint_angle(pair_of(0, 30.0), np.zeros(200), tau)[-1]
    assert 0 < given < 0.5 * COMPLIANCE[0] * tau[-1] * 1.01


@pytest.mark.parametrize("joint", [0, 4])
def test_with_the_right_pretension_the_elements_are_the_nominal_play(joint: int) -> None:
    phi = (
        draw_reference(np.random.default_rng(joint), "mixed", np.arange(3000, dtype=np.float64) * 0.01)
        / RATIO
    )
    angle = joint_angle(nominal_pair(joint), phi[:, joint])
    assert np.abs(angle - nominal_wire(phi)[:, joint])[300:].max() < 0.02 * HALF_WIDTH[joint]


def test_concealed_wires_say_what_is_wrong_with_them() -> None:
    case = draw_wire_case(3, level=(5.0, 5.0))
    assert [one["effect"] for one in case.truth] == ["presliding_hysteresis"]
    assert case.truth[0]["strength"] == pytest.approx(5.0, rel=0.5)
