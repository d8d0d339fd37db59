"""Claims about the integrated arm: each piece turns into the lumped effect that docs/physics.md says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.concealed.draws import ALL
from test.concealed.hidden import KNOWN, Hidden
from test.concealed.masses import run_masses
from test.concealed.masses_arm import Arm, having, soft
from test.concealed.masses_case import _told, draw_masses_case
from test.concealed.masses_draw import MAKE, SIMPLE
from test.concealed.masses_events import EVENTS
from test.concealed.mujoco_draw import Wish
from test.concealed.nominal import COMPLIANCE, COUNT, HALF_WIDTH, KP, RATIO, STEP, TAU_V, Array, load, play
from test.concealed.servo import run_servo
from test.concealed.trajectory import draw_reference

NOISE = 6e-5  # rad, the least that sensors have
SETTLED = 1500


@pytest.fixture(scope="module")
def asked() -> Array:
    """Twelve seconds of mixed motion for the drives, at 2 ms."""
    t = np.arange(1200, dtype=np.float64) * 0.01
    return np.repeat(draw_reference(np.random.default_rng(1), "mixed", t) / RATIO, 5, axis=0)


def _off(arm: Arm, asked: Array, width: Array, sag: tuple[float, float], relative: float = 0.0) -> float:
    """Rms distance of the arm from a play with sag before and behind it, shares of the real compliance."""
    ran = run_masses([(0.0, arm)], asked)
    u = RATIO * (1 + relative) * ran.phi + sag[0] * COMPLIANCE * ran.tau
    wide = np.broadcast_to(width, u.shape).copy()
    said = play(u, wide, wide, u[0].copy()) + sag[1] * COMPLIANCE * ran.tau
    return float(np.sqrt(((ran.theta - said)[SETTLED:] ** 2).mean()))


def test_friction_on_a_stiff_wire_is_the_nominal_play_and_the_drive_is_the_nominal_servo(
    asked: Array,
) -> None:
    assert _off(Arm(), asked, HALF_WIDTH, (0.0, 0.0)) < 0.1 * NOISE
    phi, v = run_servo((), asked[::5], 0.0)
    ran = run_masses([(0.0, Arm())], asked)
    np.testing.assert_allclose(ran.phi, phi, atol=1e-12)
    np.testing.assert_allclose(ran.v, v, atol=1e-12)


@pytest.mark.parametrize("upstream", [0.0, 0.5, 1.0])
def test_sag_sits_before_the_stick_as_far_as_the_wire_lies_before_the_friction(
    asked: Array, upstream: float
) -> None:
    arm = soft(Arm(), ALL, COMPLIANCE, upstream)
    right = _off(arm, asked, HALF_WIDTH, (upstream, 1 - upstream))
    wrong = _off(arm, asked, HALF_WIDTH, (1 - upstream, upstream))
    assert right < 0.2 * NOISE
    assert upstream == 0.5 or wrong > 4 * right


def test_a_real_wire_under_a_carried_weight_is_the_nominal_arm_and_half_of_it_has_half_the_dead_band(
    asked: Array,
) -> None:
    rubs = soft(replace(Arm(), balanced=True), ALL, COMPLIANCE, 1.0)
    assert _off(rubs, asked, HALF_WIDTH, (0.0, 0.0)) < 0.1 * NOISE
    half = replace(rubs, before=rubs.before / 2, after=rubs.after / 2)  # as much friction on a stiffer wire
    assert _off(half, asked, HALF_WIDTH / 2, (0.0, 0.0)) < 0.1 * NOISE


def test_play_at_the_wheel_widens_the_dead_band_if_the_friction_is_behind_it(asked: Array) -> None:
    for base in (Arm(), soft(replace(Arm(), balanced=True), ALL, COMPLIANCE, 1.0)):
        arm = having(base, ALL, gap=1e-3)
        assert _off(arm, asked, HALF_WIDTH + 1e-3, (0.0, 0.0)) < 0.5 * NOISE


def test_grease_lags_by_drag_over_stiffness_and_a_wheel_is_a_ratio(asked: Array) -> None:
    lag = 0.01
    base = soft(replace(Arm(), balanced=True), ALL, COMPLIANCE, 0.0)
    slow, fast = (run_masses([(0.0, arm)], asked) for arm in (having(base, ALL, drag=lag / COMPLIANCE), base))
    speed = np.gradient(slow.theta, STEP, axis=0)
    left = (slow.theta + lag * speed - fast.theta)[SETTLED:]
    assert np.sqrt((left**2).mean()) < 0.1 * np.sqrt(((slow.theta - fast.theta)[SETTLED:] ** 2).mean())
    assert _off(having(Arm(), ALL, wheel=1.01), asked, HALF_WIDTH, (0.0, 0.0), 0.01) < 0.1 * NOISE


def test_a_mass_on_a_wire_swings_at_the_root_of_stiffness_over_inertia() -> None:
    inertia = float((np.array([60, 55, 50, 45, 40]) * 1e-3 * (0.05 * (np.arange(5) + 0.5)) ** 2).sum())
    gives = np.array([1 / (inertia * (2 * np.pi * 5.0) ** 2)])
    arm = soft(replace(Arm(), balanced=True, light=1.0), (0,), gives, 0.0)
    asked = np.zeros((2000, COUNT))
    asked[250:, 0] = 0.05
    swing = run_masses([(0.0, having(arm, (0,), damped=2e-3))], asked).theta[600:, 0]
    crossings = np.flatnonzero(np.diff(np.sign(swing - swing.mean())) > 0)
    assert 1 / (np.diff(crossings[:5]).mean() * STEP) == pytest.approx(5.0, rel=0.04)


def test_a_motor_without_integral_gives_way_to_the_load_by_its_inertia(asked: Array) -> None:
    gain, arm = 5e-3, soft(Arm(), ALL, COMPLIANCE, 1.0)
    stands = np.tile(asked[3000], (3000, 1))
    kept, pulled = (
        run_masses([(0.0, replace(arm, gives=gives))], stands) for gives in (0.0, gain * KP / (TAU_V * RATIO))
    )
    given, rubs = (pulled.phi - kept.phi)[-1], HALF_WIDTH / COMPLIANCE
    assert (np.abs(given / gain - pulled.tau[-1]) < 1.01 * rubs).all()  # friction holds no more than its own
    assert np.abs(given / gain).max() > 0.5 * np.abs(pulled.tau[-1]).max() > rubs.max()


def test_energy_of_a_swinging_arm_is_not_gained() -> None:
    """The whole arm on soft wires without friction, let go: each swing is smaller than the one before."""
    free = replace(soft(Arm(), ALL, COMPLIANCE, 0.0), capstan=np.zeros(COUNT), light=1.0)
    asked = np.zeros((4000, COUNT))
    asked[10:] = 0.3
    swing = np.abs(run_masses([(0.0, having(free, ALL, damped=1e-4))], asked).theta[500:, 0])
    parts = np.ptp(swing.reshape(5, -1), axis=1)
    assert (np.diff(parts) < 0).all()


def test_an_arm_that_changes_is_one_before_and_another_after(asked: Array) -> None:
    wide = having(Arm(), ALL, wheel=1.02)
    both = run_masses([(0.0, Arm()), (6.0, wide)], asked).theta
    before, after = (run_masses([(0.0, arm)], asked).theta for arm in (Arm(), wide))
    np.testing.assert_array_equal(both[:3000], before[:3000])
    assert np.abs(both - after)[4000:].max() < NOISE


def test_every_way_to_build_it_and_every_event_shows_and_is_told() -> None:
    assert {*MAKE, *SIMPLE} - {"whole"} <= set(KNOWN)
    for seed, kind in ((0, "masses"), (5, "everyday"), (1, "awkward"), *((n, "events") for n in (3, 5, 7))):
        case = draw_masses_case(seed, kind)
        assert case.truth
        assert all(one["known"] and one["strength"] > 0.5 for one in case.truth)
        assert (kind == "events") == ("from" in case.truth[0]["extra"])
    assert len(EVENTS) == 8


@pytest.mark.parametrize("event", [name for name in EVENTS if name not in ("payload_picked_up", "softens")])
def test_what_happens_does_so_in_the_midst_of_a_joints_motion(event: str) -> None:
    theta = np.zeros((6000, 5))
    theta[4500:5000, 3] = 0.3 * np.sin(np.linspace(0.0, 12.0, 500))  # joints move one by one
    rng = np.random.default_rng(2)
    moments = [EVENTS[event](rng, Wish((3,), 1e-3, NOISE, theta), 60.0).begin for _ in range(20)]
    assert 46.0 < min(moments) < max(moments) < 49.0


@pytest.mark.parametrize("seed", range(4))
def test_an_arm_of_which_nothing_is_hidden_is_the_nominal_one(seed: int) -> None:
    case = draw_masses_case(seed, "clean_masses")
    phi = case.test.topics["gearbox_states"]["position"]
    wide = np.broadcast_to(HALF_WIDTH, phi.shape).copy()
    u = RATIO * phi
    joint = case.test.topics["joint_states"]["stamp"] == case.test.topics["gearbox_states"]["stamp"]
    if joint.all():
        left = (play(u, wide, wide, u[0].copy()) - case.test.theta_clean)[300:]
        assert np.sqrt((left**2).mean()) < 0.4 * NOISE
    assert case.truth == []


def test_load_is_that_of_the_payload_of_the_moment(asked: Array) -> None:
    arm = soft(Arm(), ALL, COMPLIANCE, 0.0)
    ran = run_masses([(0.0, arm), (4.0, replace(arm, payload=0.1))], asked)
    np.testing.assert_allclose(ran.tau[1999], load(ran.theta[1999:2000])[0])
    np.testing.assert_allclose(ran.tau[2000], load(ran.theta[2000:2001], 0.1)[0])


def test_a_zero_is_told_as_it_reads_under_weight(asked: Array) -> None:
    zero = np.array([0.004])
    soft_, cut = soft(Arm(), ALL, COMPLIANCE, 1.0), having(soft(Arm(), ALL, COMPLIANCE, 1.0), (1,), zero=zero)
    hidden = Hidden("zero_offset", (1,), "rest_length", {"offset": zero}, ("offset",))
    told = _told(hidden, ([(0.0, cut)], [(0.0, soft_)]), asked, NOISE)
    assert told is not None
    assert 1.004 < told["parameters"]["joint_2"]["offset"] / zero[0] < 1.03, "the weight turns it further"


def test_a_gain_of_creep_is_told_as_the_share_that_creeps_back() -> None:
    wish = Wish((1,), 4e-3, NOISE, np.full((100, COUNT), 0.4))
    drawn = (MAKE["viscoelastic_creep"](np.random.default_rng(seed), wish)[0] for seed in range(9))
    change = next(one for one in drawn if one.hidden.form == "behind_the_friction")
    quick = replace(
        change.apply(Arm()), capstan=np.zeros(COUNT), joint=np.zeros(COUNT), late=np.full(COUNT, 0.3)
    )
    ran = run_masses([(0.0, quick)], np.full((2000, COUNT), 0.4 / RATIO))
    share = 1 - ran.theta[-1, 1] / (RATIO * ran.phi[-1, 1])
    assert share == pytest.approx(float(change.hidden.parameters["gain"][0]), rel=1e-3)
