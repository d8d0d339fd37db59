"""Claims about the arm in MuJoCo: known mechanics come out of tendons, masses and friction."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test.concealed.hidden import KNOWN
from test.concealed.mujoco_arm import STIFF, Build, Ran, run_mujoco
from test.concealed.mujoco_case import KINDS, draw_mujoco_case
from test.concealed.nominal import (
    COMPLIANCE,
    COUNT,
    HALF_WIDTH,
    RATIO,
    STEP,
    Array,
    load,
    nominal_wire,
    play,
    tip,
)
from test.concealed.servo import run_servo
from test.concealed.trajectory import draw_reference

NOISE = 6e-5  # rad, the least that sensors have
SETTLED = 1500


@pytest.fixture(scope="module")
def servo() -> tuple[Array, Array]:
    """Wheel angle and speed of twelve seconds of mixed motion."""
    t = np.arange(1200, dtype=np.float64) * 0.01
    return run_servo((), draw_reference(np.random.default_rng(1), "mixed", t) / RATIO, 0.0)


def _left(ran: Ran, said: Array) -> float:
    return float(np.sqrt(((ran.theta - said)[SETTLED:] ** 2).mean()))


def _slid(u: Array, width: Array) -> Array:
    both = np.broadcast_to(width, u.shape).copy()
    out: Array = play(u, both, both, u[0].copy())
    return out


def test_dry_friction_on_a_stiff_wire_is_the_nominal_play(servo: tuple[Array, Array]) -> None:
    ran = run_mujoco(Build(), *servo)
    assert _left(ran, nominal_wire(ran.phi)) < 0.4 * NOISE
    assert np.abs(ran.phi - servo[0]).max() < 3e-4  # while the motor starts at full jerk


def test_play_in_a_wire_and_harder_friction_widen_the_dead_band(servo: tuple[Array, Array]) -> None:
    for b, width in (
        (Build(gap=np.full(COUNT, 1e-3)), HALF_WIDTH + 1e-3),
        (Build(friction=np.full(COUNT, 4.0)), 4 * HALF_WIDTH),
    ):
        ran = run_mujoco(b, *servo)
        assert _left(ran, _slid(RATIO * ran.phi, width)) < 0.5 * NOISE


def test_a_soft_tendon_gives_way_to_the_weight_of_the_links_and_payload(servo: tuple[Array, Array]) -> None:
    ran = run_mujoco(Build(compliance=COMPLIANCE.copy(), payload=0.05, light=100.0), *servo)
    assert _left(ran, nominal_wire(ran.phi)) > 20 * NOISE
    assert _left(ran, nominal_wire(ran.phi) + COMPLIANCE * load(ran.theta, 0.05)) < 0.5 * NOISE


def test_a_pair_of_tendons_that_only_pull_gets_twice_as_soft_when_one_hangs(
    servo: tuple[Array, Array],
) -> None:
    slack, soft = np.full(COUNT, np.inf), STIFF.copy()
    slack[0], soft[0] = 0.02, COMPLIANCE[0]
    ran = run_mujoco(Build(compliance=soft, slack=slack, light=100.0), *servo)
    pull = load(ran.theta)[:, 0]
    given = COMPLIANCE[0] * (pull + np.sign(pull) * np.maximum(np.abs(pull) - 0.02, 0.0))
    said = nominal_wire(ran.phi)
    said[:, 0] += given
    assert np.abs(pull).max() > 0.03
    assert _left(ran, said) < 0.5 * NOISE


def test_a_mass_on_a_tendon_swings_at_the_root_of_stiffness_over_inertia() -> None:
    """The whole straight arm on a soft first wire, after a step of the wheel."""
    inertia = float((np.array([60, 55, 50, 45, 40]) * 1e-3 * (0.05 * (np.arange(5) + 0.5)) ** 2).sum())
    soft, settle = STIFF.copy(), np.full(COUNT, 1e-3)
    soft[0] = 1 / (inertia * (2 * np.pi * 5.0) ** 2)
    settle[0] = 2 * 0.05 / (2 * np.pi * 5.0)
    phi: Array = np.zeros((1500, COUNT))
    phi[250:, 0] = 0.05
    speed: Array = np.gradient(phi, STEP, axis=0)
    ran = run_mujoco(Build(compliance=soft, settle=settle, balanced=True), phi, speed)
    swing = ran.theta[400:, 0] - ran.theta[-200:, 0].mean()
    crossings = np.flatnonzero(np.diff(np.sign(swing[:500])) > 0)
    assert 1 / (np.diff(crossings).mean() * STEP) == pytest.approx(5.0, rel=0.05)


def test_a_stop_holds_the_joint_and_the_others_do_not_feel_it(servo: tuple[Array, Array]) -> None:
    stops, soft = np.tile([-9.0, 9.0], (COUNT, 1)), STIFF.copy()
    stops[2, 1], soft[2], settle = 0.1, COMPLIANCE[2], np.full(COUNT, 1e-3)
    settle[2] = 8e-3
    b = Build(stops=stops, compliance=soft, settle=settle, light=100.0, balanced=True)
    ran = run_mujoco(b, *servo)
    said = nominal_wire(ran.phi)
    assert said[:, 2].max() > 0.15
    assert ran.theta[:, 2].max() < 0.1 + 10 * NOISE
    free = [0, 1, 3, 4]
    assert np.sqrt(((ran.theta - said)[SETTLED:, free] ** 2).mean()) < NOISE


def test_a_build_that_the_engine_cannot_step_is_refused(
    servo: tuple[Array, Array], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RuntimeError, match="ran off"):
        run_mujoco(Build(compliance=STIFF / 1e6), *servo)
    assert not list(tmp_path.iterdir())


def test_the_tip_is_that_of_longer_links_on_a_tilted_base(servo: tuple[Array, Array]) -> None:
    error = np.array([0.0, 1e-3, 0.0, -5e-4, 0.0])
    ran = run_mujoco(replace(Build(), tilt=0.01, length=Build().length + error), *servo)
    leaning = ran.theta.copy()
    leaning[:, 0] += 0.01
    np.testing.assert_allclose(ran.tip, tip(leaning, error), atol=1e-9)


def test_every_kind_draws_effects_of_the_table_that_show() -> None:
    for seed in (1, 13):
        case = draw_mujoco_case(seed, seconds=15.0)
        assert case.truth
        assert all(one["effect"] in KNOWN and one["strength"] > 0.5 for one in case.truth)
    assert set(KINDS) - {"whole", "pair"} <= set(KNOWN)
    assert draw_mujoco_case(3, "clean", seconds=5.0).truth == []
