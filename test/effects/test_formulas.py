"""Each effect against its formula in docs/effects.md, written once more in plain Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from test.effects.example import alike, arm_of, motion, stamps
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects import registry
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.model import Model

ARM = arm_of(3, dead_band=0.0)
STAMP = stamps(20, 200)
THETA = motion(STAMP, 3)
PHI = THETA / 0.625
TAU = ARM.load(THETA)
SPEED = np.diff(THETA, axis=0, prepend=THETA[:1]) * 200.0


def wire(effect: str, dead_band: float = 0.0, **values: Any) -> Array:
    """Joint readings (n, 3) of the wire with one effect."""
    spread = {k: np.full(3, v) if isinstance(v, float) and k not in SHARED else v for k, v in values.items()}
    return Chain(Model(arm_of(3, dead_band), {effect: spread}), "wire").run(PHI, STAMP)[0]


SHARED = {"factor", "payload", "delay", "share"}


def play(u: Array, width: Any) -> Array:
    """theta[k] = clip(theta[k-1], u[k] - w, u[k] + w), from the centre."""
    widths = np.broadcast_to(width, u.shape)
    theta, out = u[0], []
    for row, w in zip(u, widths, strict=True):
        theta = np.clip(theta, row - w, row + w)
        out.append(theta)
    return np.array(out)


STATIC: dict[str, tuple[dict[str, Any], Callable[[], Array]]] = {
    "ratio_error": ({"relative": 0.02}, lambda: 0.625 * 1.02 * PHI),
    "transmission_ripple": (
        {"amplitude": 1e-3, "cycles_per_rev": 9.0, "phase": 0.4},
        lambda: THETA + 1e-3 * np.sin(9.0 * PHI + 0.4),
    ),
    "wire_slip": ({"onset": 5.0, "step": 2e-3}, lambda: THETA + 2e-3 * (STAMP > 5.0)[:, None]),
    "zero_offset": ({"offset": 3e-3}, lambda: THETA + 3e-3),
    "hard_stop": ({"upper": 0.1, "lower": -0.12}, lambda: np.clip(THETA, -0.12, 0.1)),
    "backlash": ({"half_width": 2e-3}, lambda: play(THETA, 2e-3)),
    "friction_wear": ({"rate": 1e-4}, lambda: play(THETA, 1e-4 * STAMP[:, None])),
}


@pytest.mark.parametrize("name", STATIC)
def test_what_depends_on_angle_and_time_follows_its_formula(name: str) -> None:
    values, expected = STATIC[name]
    still = np.abs(STAMP - 5.0) > 0.02 if name == "wire_slip" else np.ones(len(STAMP), dtype=bool)
    assert wire(name, **values)[still] == pytest.approx(expected()[still], abs=1e-12)


@pytest.mark.parametrize(
    ("values", "drift"),
    [
        ({"amplitude": 2e-3, "time_constant": 8.0}, 2e-3 * (1.0 - np.exp(-STAMP / 8.0))),
        ({"rate": 1e-4, "form": "straight"}, 1e-4 * STAMP),
    ],
)
def test_a_drift_is_exponential_or_straight(values: dict[str, Any], drift: Array) -> None:
    alike(wire("thermal_drift", **values), THETA + drift[:, None], 1e-12)


def test_a_drift_with_travel_goes_by_the_way_to_and_fro() -> None:
    way = np.concatenate([np.zeros((1, 3)), np.cumsum(np.abs(np.diff(THETA, axis=0)), axis=0)])
    got = wire("thermal_drift", rate=1e-4, speed=0.1, form="travel")
    alike(got, THETA + 1e-3 * way, 1e-5)


def test_a_heated_drift_lags_behind_the_speed_and_cools_in_pauses() -> None:
    heat, step = np.zeros_like(THETA), 1.0 - np.exp(-np.diff(STAMP) / 2.0)
    power = np.abs(np.diff(THETA, axis=0)) / np.diff(STAMP)[:, None] / 0.1
    for k in range(1, len(STAMP)):
        heat[k] = heat[k - 1] + step[k - 1] * (power[k - 1] - heat[k - 1])
    got = wire("thermal_drift", amplitude=1e-3, time_constant=2.0, speed=0.1, form="heated")
    alike(got, THETA + 1e-3 * heat, 2e-5)


def test_creep_by_a_power_law_is_a_sum_of_creeps_whose_shares_go_with_a_power_of_their_time() -> None:
    ages = np.geomspace(0.4, 300.0, 9)
    share = ages**0.3 / np.sum(ages**0.3)
    each = [
        wire("viscoelastic_creep", gain=0.1 * s, time_constant=t) for s, t in zip(share, ages, strict=True)
    ]
    got = wire("viscoelastic_creep", gain=0.1, exponent=0.3, form="power_law")
    alike(got, THETA + sum(one - THETA for one in each), 1e-12)


def test_a_coupling_adds_gain_times_the_sources_true_angle() -> None:
    got = wire("joint_coupling", gain=np.array([0.0, 0.1, 0.05]), source=["", "joint_1", "joint_2"])
    assert got[:, 1] == pytest.approx(THETA[:, 1] + 0.1 * got[:, 0], abs=1e-7)
    assert got[:, 2] == pytest.approx(THETA[:, 2] + 0.05 * got[:, 1], abs=1e-7)


def test_the_posture_of_another_joint_scales_what_the_motor_moves() -> None:
    got = wire("posture_ratio", gain=np.array([0.0, 0.2, -0.1]), source=["", "joint_1", "joint_2"])
    assert got[:, 1] == pytest.approx(THETA[:, 1] * (1.0 + 0.2 * got[:, 0]), abs=1e-7)
    assert got[:, 2] == pytest.approx(THETA[:, 2] * (1.0 - 0.1 * got[:, 1]), abs=1e-7)


@pytest.mark.parametrize("form", ["bent", "turned"])
def test_the_dead_band_grows_with_the_bend_of_the_joints_that_the_wire_passes(form: str) -> None:
    got = wire(
        "wrap_friction", dead_band=5e-4, form=form, gain=np.array([0.0, 0.01, 0.02]),
        gain_2=np.array([0.0, 0.0, -0.005]), source=["", "joint_1", "joint_1"], source_2=["", "", "joint_2"],
    )  # fmt: skip
    bend = np.abs(got) if form == "bent" else got
    width = np.maximum(
        5e-4 + np.stack([0 * bend[:, 0], 0.01 * bend[:, 0], 0.02 * bend[:, 0] - 0.005 * bend[:, 1]], 1), 0.0
    )
    alike(got, play(THETA, width), 1e-7)


def test_joints_may_drag_each_other() -> None:
    got = wire("joint_coupling", gain=np.array([0.0, 0.3, 0.25]), source=["", "joint_3", "joint_2"])
    assert got[:, 1] == pytest.approx(THETA[:, 1] + 0.3 * got[:, 2], abs=1e-7)
    assert got[:, 2] == pytest.approx(THETA[:, 2] + 0.25 * got[:, 1], abs=1e-7)


def test_a_motor_may_turn_another_joint_by_what_its_own_does_not_follow() -> None:
    gain, source = np.array([0.0, 0.3, 0.0]), ["", "joint_3", ""]
    got = wire("joint_coupling", dead_band=2e-3, form="motors", gain=gain, source=source)
    alike(got[:, 1], play(THETA[:, 1:2] + 0.3 * THETA[:, 2:], 2e-3)[:, 0], 1e-7)


def test_a_tension_error_scales_the_nominal_dead_band() -> None:
    alike(wire("tension_error", dead_band=2e-3, factor=1.5), play(THETA, 3e-3), 1e-12)
    alike(wire("narrow_band", dead_band=2e-3, less=0.25), play(THETA, 1.5e-3), 1e-12)


def test_friction_grows_with_the_load() -> None:
    got = wire("load_dependent_friction", dead_band=1e-3, gain=0.01)
    alike(got, play(THETA, 1e-3 + 0.01 * np.abs(ARM.load(got))), 1e-7)


@pytest.mark.parametrize(
    ("form", "fade"),
    [
        ("exponential", lambda x: np.exp(-x)),
        ("gaussian", lambda x: np.exp(-(x**2))),
        ("hyperbolic", lambda x: 1 / (1 + x**2)),
    ],
)
def test_friction_is_wider_at_low_speed(form: str, fade: Callable[[Array], Array]) -> None:
    got = wire("stribeck_friction", dead_band=1e-3, form=form, amplitude=2e-3, velocity=0.1)
    alike(got, play(THETA, 1e-3 + 2e-3 * fade(np.abs(SPEED) / 0.1)), 1e-12)


def test_a_film_of_oil_sees_the_whole_dead_band_by_whatever_name() -> None:
    film = {"stribeck_friction": {"form": "film", "amplitude": np.full(3, 2e-3), "velocity": np.full(3, 0.1),
                                  "memory": np.full(3, 0.05)}}  # fmt: skip
    arm = arm_of(3, 1e-3)
    wider = {"backlash": {"half_width": np.full(3, 3e-3)}}, {"tension_error": {"factor": 4.0}}
    one, other = (Chain(Model(arm, {**film, **more}), "wire").run(PHI, STAMP)[0] for more in wider)
    np.testing.assert_allclose(one, other, atol=1e-12)


def test_friction_of_a_film_falls_with_the_speed_that_the_joint_has_had_of_late() -> None:
    got = wire("stribeck_friction", dead_band=1e-3, form="film", amplitude=2e-3, velocity=0.1, memory=0.05)
    theta, late, more, last = THETA[0].copy(), np.zeros(3), [], THETA[0]
    for u in THETA:
        for part in (0.5, 1.0) if more else (1.0,):  # of 5 ms
            extra = 2e-3 * np.exp(-((late / 0.1) ** 2))
            asked, before = last + part * (u - last), theta
            theta = np.clip(theta, asked - 1e-3 - extra, asked + 1e-3 + extra)
            if more:
                late = late + (np.abs(theta - before) / 2.5e-3 - late) * (1.0 - np.exp(-2.5e-3 / 0.05))
        more.append(extra)
        last = u
    alike(got, play(THETA, 1e-3 + np.array(more)), 1e-12)


def test_a_load_stretches_the_wire_along_with_a_payload() -> None:
    got = wire("load_elasticity", compliance=0.05, payload=0.1)
    tau = ARM.load(got) + 0.1 * ARM.lever(got)
    alike(got, THETA + 0.05 * tau, 1e-7)


def test_a_slack_wire_is_twice_as_soft_past_its_threshold() -> None:
    got = wire("wire_slack", threshold=0.03, compliance=0.05)
    tau = ARM.load(got)
    excess = np.sign(tau) * np.maximum(np.abs(tau) - 0.03, 0.0)
    alike(got, THETA + 0.05 * (tau + excess), 1e-7)


def test_what_goes_slack_little_by_little_does_so_within_its_softness() -> None:
    got = wire("wire_slack", form="smooth", threshold=0.03, compliance=0.05, softness=0.004)
    tau = ARM.load(got)
    beyond, before = (np.logaddexp(0.0, (size - 0.03) / 0.004) for size in (np.abs(tau), 0.0))
    excess = 0.004 * np.sign(tau) * (beyond - before)
    alike(got, THETA + 0.05 * (tau + excess), 1e-7)


@pytest.mark.parametrize("form", ["tangent", "secant", "smooth"])
def test_a_stiffening_wires_compliance_has_halved_at_the_moment(form: str) -> None:
    arm = arm_of(1, dead_band=0.0)
    model = Model(
        arm, {"wire_stiffening": {"form": form, "moment": np.full(1, 0.1), "compliance": np.full(1, 1e-4)}}
    )
    theta = np.linspace(0.0, 0.7, 701)[:, None]
    sag = (Chain(model, "wire").run(theta / 0.625, np.arange(701.0))[0] - theta)[:, 0] / 1e-4
    tau = arm.load(theta)[:, 0]
    at = int(np.argmin(np.abs(tau - 0.1)))
    assert np.gradient(sag, tau)[at] == pytest.approx(0.5, abs=0.01)
    assert np.gradient(sag, tau)[1] == pytest.approx(1.0, abs=0.02)


def euler(rate: Callable[[Array, int], Array], start: Array, steps: int = 40) -> Array:
    """States (n, ...) of dx/dt = rate(x, fine row) by many small steps, at the rows of STAMP."""
    x, out = start.copy(), [start.copy()]
    for row in range((len(STAMP) - 1) * steps):
        x = x + rate(x, row) / (200.0 * steps)
        if (row + 1) % steps == 0:
            out.append(x.copy())
    return np.array(out)


def finely(signal: Array) -> Array:
    """A signal (n, 3) at STAMP at each of the small steps."""
    between = np.arange((len(STAMP) - 1) * 40 + 1) / 8000.0
    return np.column_stack([np.interp(between, STAMP, c) for c in signal.T])


FINE = finely(THETA)


def test_a_lag_is_a_first_order_low_pass() -> None:
    expected = euler(lambda x, row: (FINE[row] - x) / 0.05, THETA[0])
    alike(wire("viscous_lag", time_constant=0.05), expected, 2e-5)


def test_a_creep_gives_back_a_share_of_the_slow_position() -> None:
    low = euler(lambda x, row: (FINE[row] - x) / 2.0, THETA[0])
    got = wire("viscoelastic_creep", gain=0.05, time_constant=np.full(3, 2.0))
    alike(got, THETA - 0.05 * low, 2e-5)


def test_a_wire_that_creeps_under_weight_goes_by_the_slow_load() -> None:
    got = wire("viscoelastic_creep", compliance=0.05, time_constant=np.full(3, 2.0), form="load")
    load = finely(ARM.load(got))
    low = euler(lambda x, row: (load[row] - x) / 2.0, load[0])
    alike(got, THETA + 0.05 * low, 2e-5)


def test_what_flows_under_weight_goes_by_the_sum_of_the_load() -> None:
    got = wire("viscoelastic_creep", flow=0.05, form="flow")
    load = finely(ARM.load(got))
    alike(got, THETA + 0.05 * euler(lambda _, row: load[row], np.zeros(3)), 2e-5)


def test_a_link_swings_as_a_damped_oscillator() -> None:
    omega = 2 * np.pi * 3.0

    def rate(x: Array, row: int) -> Array:
        return np.array([x[1], omega**2 * (FINE[row] - x[0]) - 2 * 0.1 * omega * x[1]])

    expected = euler(rate, np.array([THETA[0], np.zeros(3)]))[:, 0]
    got = wire("link_resonance", frequency=3.0, damping=0.1)
    assert got == pytest.approx(expected, abs=2e-3 * np.abs(got - THETA).max() + 1e-4)


@pytest.mark.parametrize("swinging", [[1], [2], [0, 2], [0, 1, 2]])
def test_links_swing_as_their_masses_shake_each_other(swinging: list[int]) -> None:
    """Against Lagrange's equations with Coriolis' forces, which the effect leaves out."""
    damping, still = 0.15, np.zeros((1, 3))
    frequency = np.array([3.0, 3.5, 4.0])
    straight = [-ARM.inertia(still, still, row[None])[0, j] for j, row in enumerate(np.eye(3))]
    omega = 2 * np.pi * frequency[swinging]
    hold = np.array(straight)[swinging] * omega**2
    damp = 2 * damping * hold / omega
    some = slice(1600)  # 8 s
    wires = CubicSpline(STAMP, THETA)

    def rate(t: float, state: Array) -> Array:
        q, speed, acceleration = wires(t), wires(t, 1), wires(t, 2)
        x, ramp = q[swinging], speed[swinging]
        q[swinging], speed[swinging] = np.split(state, 2)
        acceleration[swinging] = 0.0
        moment = ARM.inertia(q[None], speed[None], acceleration[None])[0, swinging]
        mass = np.array([-ARM.inertia(q[None], still, row[None])[0] for row in np.eye(3)])
        pull = moment - hold * (q[swinging] - x) - damp * (speed[swinging] - ramp)
        return np.concatenate([speed[swinging], np.linalg.solve(mass[np.ix_(swinging, swinging)], pull)])

    start = np.concatenate([THETA[0, swinging], np.zeros(len(swinging))])
    stamp, expected = STAMP[some], THETA[some].copy()
    expected[:, swinging] = (
        solve_ivp(rate, stamp[[0, -1]], start, t_eval=stamp, rtol=1e-5, atol=1e-7).y[: len(swinging)].T
    )
    values = {
        "frequency": np.where(np.isin(range(3), swinging), frequency, 1e6),
        "damping": np.full(3, damping),
    }
    model = Model(ARM, {"link_resonance": {"form": "links", **values}})
    got, own = Chain(model, "wire").run(PHI[some], stamp)[0], expected - THETA[some]
    assert np.ptp(own, axis=0)[swinging].min() > 2e-3
    assert got == pytest.approx(expected, abs=0.05 * np.abs(own).max())


def test_without_masses_only_the_joint_itself_swings() -> None:
    bare = replace(ARM, link_mass=np.empty(0))
    one = {"frequency": np.full(3, 3.0), "damping": np.full(3, 0.1)}
    links, relative = (
        Chain(Model(bare, {"link_resonance": {"form": form, **one}}), "wire").run(PHI, STAMP)[0]
        for form in ("links", "relative")
    )
    np.testing.assert_array_equal(links, relative)


def test_a_late_sensor_shows_the_past() -> None:
    past = np.column_stack([np.interp(STAMP - 0.013, STAMP, column) for column in THETA.T])
    alike(wire("sensor_delay", delay=0.013), past, 2e-5)


def test_a_sensor_that_averages_shows_the_mean_of_what_was_last() -> None:
    window, ahead = 0.052, THETA[:1] - np.zeros((200, 1))  # where each joint had stood
    fine = np.arange(-0.2, STAMP[-1] + 2e-4, 1e-4)
    past = np.concatenate([STAMP[0] - 1.0 + 4e-3 * np.arange(200), STAMP])
    wanted = []
    for column in np.vstack([ahead, THETA]).T:
        area = np.cumsum(np.interp(fine, past, column)) * 1e-4
        wanted.append((np.interp(STAMP, fine, area) - np.interp(STAMP - window, fine, area)) / window)
    got = wire("sensor_delay", form="averaged", delay=window / 2, share=1.0)
    alike(got, np.column_stack(wanted), 5e-5)


@pytest.mark.parametrize("form", ["spread", "bouc_wen", "bouc_wen_2", "dahl"])
def test_a_rounded_loop_lags_by_half_its_width_once_it_slides(form: str) -> None:
    up = np.concatenate([np.linspace(0, 0.5, 500), np.linspace(0.5, 0, 500)])[:, None]
    model = Model(arm_of(1, 1e-3), {"presliding_hysteresis": {"form": form, "width": np.full(1, 4e-3)}})
    got = Chain(model, "wire").run(up / 0.625, np.arange(1000.0))[0]
    assert (up - got)[499, 0] == pytest.approx(1e-3 + 2e-3, abs=1e-5)
    assert (up - got)[-1, 0] == pytest.approx(-1e-3 - 2e-3, abs=1e-5)


def test_bristles_on_an_elastic_wire_are_the_law_of_dahl() -> None:
    """Integrated in small steps: the wire's stretch z grows by (W - sign z)/bend with the joint's way."""
    half_width, bend, stamp = 3e-3, 8e-4, np.arange(4000.0) * 1e-3
    u = 0.01 * np.sin(2 * np.pi * stamp) * (1.0 + 0.5 * np.sin(0.9 * stamp))
    model = Model(
        arm_of(1, 1e-3),
        {"presliding_hysteresis": {"form": "bristles", "width": half_width - 1e-3, "bend": bend}},
    )
    got = Chain(model, "wire").run(u[:, None] / 0.625, stamp)[0][:, 0]
    z, theta = 0.0, [u[0]]
    for moved in np.diff(u):
        for _ in range(200):
            stiff = (half_width - np.sign(moved) * z) / bend
            z += moved / 200 * stiff / (1.0 + stiff)
        theta.append(theta[-1] + moved - (z - (u[len(theta) - 1] - theta[-1])))
    assert np.ptp(u - np.array(theta)) > 5.5e-3
    assert got == pytest.approx(np.array(theta), abs=3e-6)


def test_plays_spread_over_a_width_slide_fully_after_twice_that_travel() -> None:
    """The definition of ``width``; at half of the travel half of the plays have turned."""
    down = np.concatenate([np.linspace(0, 0.5, 500), 0.5 - np.linspace(0, 0.02, 2001)[1:]])[:, None]
    model = Model(arm_of(1, 1e-3), {"presliding_hysteresis": {"form": "spread", "width": np.full(1, 4e-3)}})
    got = Chain(model, "wire").run(down / 0.625, np.arange(2500.0))[0][500:, 0]
    travel = 0.5 - down[500:, 0]
    slope = np.gradient(got, -travel)
    assert slope[travel < 1.9e-3] == pytest.approx(0.0, abs=1e-9), "twice w: the dead band"
    assert slope[np.abs(travel - 6e-3) < 2e-4].mean() == pytest.approx(0.5, abs=0.06)
    assert slope[travel > 10.2e-3] == pytest.approx(1.0, abs=1e-9), "twice w + width"


def test_wear_with_travel_goes_on_where_it_stood_and_stops_with_the_joint() -> None:
    """The same growth by the way slid, in blocks and over another motion; nothing while it stands."""
    wear = {"friction_wear": {"form": "travel", "rate": np.full(1, 1e-4), "speed": np.full(1, 0.05)}}
    chain = Chain(Model(arm_of(1, 0.0), wear), "wire")
    stamp = np.arange(3001) * 0.01
    theta = 0.2 * np.sin(np.minimum(stamp, 20.0))[:, None]
    width = 1e-4 * np.concatenate([[0.0], np.cumsum(np.abs(np.diff(theta[:, 0])))]) / 0.05
    whole, _ = chain.run(theta / 0.625, stamp)
    alike(whole, play(theta, width[:, None]), 1e-12)
    first, state = chain.run(theta[:1234] / 0.625, stamp[:1234])
    second, _ = chain.run(theta[1234:] / 0.625, stamp[1234:], state)
    alike(np.concatenate([first, second]), whole, 1e-12)
    assert np.ptp(width[2000:]) == pytest.approx(0.0, abs=1e-12)


def test_wear_with_travel_is_held_live_at_the_end_of_the_fitted_recording() -> None:
    wear = {"friction_wear": {"form": "travel", "rate": np.full(1, 1e-4), "speed": np.full(1, 0.05)}}
    live = Chain(Model(arm_of(1, 0.0), wear, duration=50.0), "wire", hold_time=True)
    stamp = np.arange(200) * 0.01
    theta = 0.2 * np.sin(stamp)[:, None]
    got, _ = live.run(theta / 0.625, stamp)
    assert got == pytest.approx(play(theta, np.full((200, 1), 5e-3)), abs=1e-12)


def test_a_play_of_many_columns_is_that_of_each() -> None:
    u = np.random.default_rng(3).normal(size=(20, 500))
    many, _ = SharpPlay().run(u, np.full((1, 500), 0.3), np.zeros(500))
    alone = [
        SharpPlay().run(u[:, c : c + 1], np.full((1, 1), 0.3), np.zeros(1))[0][:, 0] for c in (0, 99, 499)
    ]
    np.testing.assert_array_equal(many[:, [0, 99, 499]].T, alone)
    begun, _ = SharpPlay().run(u, np.full((1, 500), 0.3), None)
    np.testing.assert_array_equal(begun[0], u[0])


def test_of_two_waves_the_larger_comes_first_and_is_the_same() -> None:
    names = ("amplitude", "cycles_per_rev", "phase", "harmonic", "harmonic_phase", "cycles_per_rev_2")
    given = dict(zip(names, (-4e-4, 3.0, 0.5, 1.7, 1.2, 7.4), strict=True))
    plain = registry()["transmission_ripple"].plain(given)
    assert (plain["cycles_per_rev"], plain["cycles_per_rev_2"]) == (7.4, 3.0)
    assert 0.0 < plain["harmonic"] < 1.0
    assert plain["amplitude"] == pytest.approx(6.8e-4)
    same = [wire("transmission_ripple", **values, form="two_orders") for values in (given, plain)]
    assert same[1] == pytest.approx(same[0], abs=1e-12)
