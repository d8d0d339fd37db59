"""What every effect promises, for all that discovery finds and in all their forms."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from test.effects.example import (
    CASES,
    COMPENSABLE,
    WIRE,
    alike,
    arm_of,
    input_of,
    model_of,
    motion,
    run,
    stamps,
    values_of,
    words_of,
)
from trunk_ros.chain import Chain, State
from trunk_ros.compiled import Array
from trunk_ros.effects import registry
from trunk_ros.effects.bank import Bank
from trunk_ros.effects.effect import Effect
from trunk_ros.model import Model

NOISE_FLOOR = 1e-5  # rad
KNOCKED = 1e-4  # rad: a wire that crosses its dead band at once pulls the link by its damping
AGREED = 1e-6  # rad: what each block may be off by, where joints see each other
REGIMES = {"always", "posture", "reversal", "hold", "low_speed", "high_speed", "time"}
OF_TIME = {
    "thermal_drift", "wire_slip", "friction_wear", "friction_warming", "unknown_jumps", "unknown_slips",
    "unknown_drift", "unknown_waves",
}  # fmt: skip
every_effect = pytest.mark.parametrize(("name", "form"), CASES)


@cache
def plain(stage: str) -> Array:
    """What 12 s of motion become in a stage without effects."""
    stamp = stamps(12, 100)
    return run(Model(arm_of(5)), stage, motion(stamp), stamp)


@every_effect
def test_it_states_what_it_is(name: str, form: str) -> None:
    kind = registry()[name]
    assert kind.__doc__, "the formula is in the docstring"
    assert kind.__doc__ != Effect.__doc__
    assert kind.signature.endswith(".")
    assert len(kind.source) > 20
    assert kind.regime in REGIMES
    assert kind.own_parameters(form), "an effect has parameters"
    for other, how in kind.confused_with:
        assert other in registry()
        assert how


@every_effect
def test_its_parameters_have_unit_bounds_and_meaning(name: str, form: str) -> None:
    for p in registry()[name].parameters:
        assert p.unit
        assert p.meaning
        assert p.bounds[0] <= p.null <= p.bounds[1] or p.unit == "1"
        assert p.bounds[0] <= p.typical <= p.bounds[1]
        assert all(p.bounds[0] <= start <= p.bounds[1] for start in p.scan)
        assert p.scale == "linear" or p.bounds[0] > 0.0, "a logarithm needs a positive bound"


@every_effect
def test_at_its_null_it_changes_nothing(name: str, form: str) -> None:
    kind = registry()[name]
    stamp, theta = stamps(12, 100), motion(stamps(12, 100))
    lead = kind.own_parameters(form)[0]
    values = values_of(name, form, 5)
    with_lead_at_null = {**values, lead.name: lead.null if lead.shared else np.full(5, lead.null)}
    if name in ("wire_slack", "wire_stiffening"):
        with_lead_at_null |= {"compliance": np.zeros(5), "payload": 0.0}
    if kind.own_parameters(form)[0].name == "low":
        with_lead_at_null |= {p.name: np.zeros(5) for p in kind.parameters[2:]}
    with_lead_at_null |= {
        more: np.zeros(5) for more in ("gain_2", "gain_3", "drag", "rubbing", "bend") if more in values
    }
    if kind.stage == "arm":  # a shift has no leading direction
        nulls = {p.name: p.null if p.shared else np.full(5, p.null) for p in kind.parameters}
        with_lead_at_null |= {name: null for name, null in nulls.items() if name in values}
    if issubclass(kind, Bank):
        with_lead_at_null |= {p.name: np.zeros(5) for p in kind.parameters if p.name.startswith("weight")}
    with_it = run(Model(arm_of(5), {name: with_lead_at_null}), kind.stage, theta, stamp)
    alike(with_it, plain(kind.stage), 1e-12)
    assert Model.from_parameters(Model(arm_of(5), {name: dict(kind.null())}).parameters()).effects == {}


@every_effect
def test_it_does_something(name: str, form: str) -> None:
    stamp, theta = stamps(12, 100), motion(stamps(12, 100))
    stage = registry()[name].stage
    change = run(model_of(name, form), stage, theta, stamp) - plain(stage)
    assert np.sqrt(np.mean(change**2)) > NOISE_FLOOR


@every_effect
def test_rest_stays_at_rest(name: str, form: str) -> None:
    """Whatever the posture; what depends on time alone is looked at after it is over."""
    if name in OF_TIME or form == "flow":
        pytest.skip("moves with time, in motion or not")
    stamp = stamps(6, 100)
    rest = np.broadcast_to(motion(np.array([9.0])), (len(stamp), 5))
    out = run(model_of(name, form), registry()[name].stage, rest, stamp)
    settled = len(out) // 2 if registry()[name].stage == "servo" else 0
    assert np.ptp(out[settled:], axis=0) == pytest.approx(0.0, abs=1e-9)


@every_effect
def test_values_within_bounds_are_so_in_plain_words(name: str, form: str) -> None:
    """Else a model is written that is not read."""
    kind, rng = registry()[name], np.random.default_rng(1)
    own = {p.name: p for p in kind.own_parameters(form)}
    for _ in range(100):
        drawn = {n: float(rng.choice([*p.bounds, rng.uniform(*p.bounds)])) for n, p in own.items()}
        for n, value in kind.plain(drawn).items():
            assert own[n].bounds[0] <= value <= own[n].bounds[1], n


@every_effect
@settings(max_examples=5, deadline=None)
@given(data=st.data())
def test_it_is_finite_over_its_bounds(name: str, form: str, data: Any) -> None:
    kind = registry()[name]
    values: dict[str, Any] = {"form": form} if form else {}
    own = kind.own_parameters(form)
    if issubclass(kind, Bank):  # more numbers than hypothesis draws
        rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
        values |= {p.name: rng.choice([*p.bounds, 0.0, rng.uniform(*p.bounds)], 5) for p in own}
    else:
        drawn = {p.name: [data.draw(st.floats(*p.bounds)) for _ in range(1 if p.shared else 5)] for p in own}
        values |= {p.name: drawn[p.name][0] if p.shared else np.array(drawn[p.name]) for p in own}
    if "low" in values:
        values |= {"low": np.minimum(values["low"], values["high"]) - 1e-3}
    model = Model(arm_of(5), {name: values | words_of(kind, 5)})
    stamp = np.cumsum(np.array(data.draw(st.lists(st.floats(1e-6, 3.0), min_size=20, max_size=20))))
    theta = motion(stamp, amplitude=1.0)
    assert np.isfinite(run(model, kind.stage, theta, stamp)).all()
    if (name, form) in COMPENSABLE:
        assert np.isfinite(Chain(model, "wire").invert(theta, stamp)[0]).all()


def in_blocks(chain: Chain, backward: bool, signal: Any, stamp: Any, cuts: list[int]) -> Any:
    """A signal passed through a chain in blocks."""
    state: State | None = None
    parts = []
    for begin, end in pairwise([0, *cuts, len(stamp)]):
        way = chain.invert if backward else chain.run
        part, state = way(signal[begin:end], stamp[begin:end], state)
        parts.append(part)
    return np.concatenate(parts)


@every_effect
@settings(max_examples=2, deadline=None)
@given(cuts=st.sets(st.integers(1, 499), min_size=1, max_size=8), jitter=st.integers(0, 2**31))
def test_block_by_block_equals_all_at_once(name: str, form: str, cuts: set[int], jitter: int) -> None:
    if name == "speed_feedforward" or form == "each_setpoint":
        pytest.skip("the first setpoints do not tell their pace: in pieces see test_servo")
    stage, model = registry()[name].stage, model_of(name, form)
    stamp = 0.012 * (np.arange(500) + np.random.default_rng(jitter).uniform(-0.4, 0.4, 500))
    x = input_of(
        model, stage, motion(stamp + 1.0)
    )  # under way: a start below what passes agree to has no direction
    for backward in (False, True) if (name, form) in COMPENSABLE else (False,):
        whole = in_blocks(Chain(model, stage), backward, x, stamp, [])
        got = in_blocks(Chain(model, stage), backward, x, stamp, sorted(cuts))
        alike(got, whole, AGREED * (1 + len(cuts)))


@pytest.mark.parametrize(("name", "form"), COMPENSABLE)
@pytest.mark.parametrize("joints", [1, 7])
def test_what_its_inverse_asks_for_gives_what_was_wanted(name: str, form: str, joints: int) -> None:
    if name == "stribeck_friction" and form != "film":
        pytest.skip("its own test below")
    model = model_of(name, form, joints)
    stamp = stamps(16, 100)
    wanted = motion(stamp, joints, amplitude=0.17)
    chain = Chain(model, "wire")
    gearbox, _ = chain.invert(wanted, stamp)
    speed = np.diff(wanted, axis=0, prepend=wanted[:1]) * 100.0 / model.arm.ratio
    got, _ = chain.run(gearbox, stamp, velocity=speed)
    gives = 2.0 if name == "wire_slack" else 1.0  # half as stiff, it is pulled twice as far
    floor = gives * KNOCKED if form == "held" else NOISE_FLOOR
    alike(got, wanted, floor)


@pytest.mark.parametrize("form", ["exponential", "gaussian", "hyperbolic"])
def test_friction_that_falls_with_the_motors_speed_is_overcome_but_where_it_turns(form: str) -> None:
    """A joint leaps as its motor turns back and friction falls: no motion of the motor holds it."""
    model = model_of("stribeck_friction", form)
    stamp = stamps(16, 100)
    wanted = motion(stamp, amplitude=0.17)
    chain = Chain(model, "wire")
    got, _ = chain.run(chain.invert(wanted, stamp)[0], stamp)
    off = np.abs(got - wanted)[100:]
    assert np.quantile(off, 0.9) < 1e-6
    assert np.mean(off > 1e-4) < 0.05


@pytest.mark.parametrize("form", ["exponential", "gaussian", "hyperbolic"])
@pytest.mark.parametrize("amplitude", [3e-3, 2.5e-2])
@pytest.mark.parametrize("rate", [100, 1000])
def test_friction_that_falls_steeply_is_overcome_at_any_rate(form: str, amplitude: float, rate: int) -> None:
    sticks = {"amplitude": np.full(5, amplitude), "velocity": np.full(5, 0.05), "form": form}
    model = Model(arm_of(5), {"stribeck_friction": sticks})
    stamp = stamps(8, rate)
    wanted = motion(stamp, amplitude=0.17)
    chain = Chain(model, "wire")
    got, _ = chain.run(chain.invert(wanted, stamp)[0], stamp)
    off = np.abs(got - wanted)[rate:]
    assert np.quantile(off, 0.9) < 1e-6


@every_effect
@pytest.mark.parametrize("joints", [1, 2, 5, 7])
def test_any_number_of_joints_will_do(name: str, form: str, joints: int) -> None:
    stamp = stamps(4, 100)
    out = run(model_of(name, form, joints), registry()[name].stage, motion(stamp, joints), stamp)
    assert out.shape == (len(stamp), 7 if registry()[name].stage == "arm" else joints)


def close(difference: Array, floor: float) -> bool:
    """Whether a difference is below a floor, and below ten of it where the joint starts or stops at once."""
    off = np.abs(difference)
    return bool(np.quantile(off, 0.99) < floor and off.max() < 10 * floor)


@pytest.mark.parametrize(("name", "form"), WIRE)
def test_the_sampling_rate_does_not_matter(name: str, form: str) -> None:
    if form == "proportional":
        pytest.skip("the speed of a joint that starts at once is what two samples make of it")
    fine, coarse = stamps(20, 500), stamps(20, 100)
    often, seldom = (run(model_of(name, form), "wire", motion(t, pace=0.4), t) for t in (fine, coarse))
    moments = {
        "wire_slip": 8.0,
        **dict.fromkeys(("unknown_jumps", "unknown_slips"), 0.003 + 0.8 * np.arange(25.0)),
    }
    jump = (
        np.min(np.abs(np.subtract.outer(coarse, moments.get(name, np.inf))).reshape(len(coarse), -1), axis=1)
        < 0.03
    )
    assert close((often[::5] - seldom)[~jump], NOISE_FLOOR)


@pytest.mark.parametrize(("name", "form"), [case for case in CASES if registry()[case[0]].stage == "servo"])
def test_the_servo_does_not_care_how_often_it_is_looked_at(name: str, form: str) -> None:
    coarse = stamps(10, 100)
    fine = stamps(10, 500)
    setpoint = motion(coarse) / 0.625
    held = setpoint[np.searchsorted(coarse, fine + 1e-9, side="right") - 1]
    model = model_of(name, form)
    often, seldom = (Chain(model, "servo").run(x, t)[0] for x, t in ((held, fine), (setpoint, coarse)))
    looked_up = 4.0 if "on" in registry()[name].texts else 1.0  # a curve is, once a sample
    alike(often[::5], seldom, looked_up * NOISE_FLOOR)


@pytest.mark.parametrize(("name", "form"), WIRE)
def test_uneven_stamps_and_a_gap_give_the_same_curve(name: str, form: str) -> None:
    """Half of the samples are lost, and all of them for a second in which the arm goes straight on."""
    stamp = stamps(16, 200)
    theta = motion(stamp, pace=0.4)
    gap = (stamp > 9.0) & (stamp < 10.0)
    ends = np.flatnonzero((stamp == 9.0) | (stamp == 10.0))
    for column in theta.T:
        column[gap] = np.interp(stamp[gap], stamp[ends], column[ends])
    kept = (np.random.default_rng(3).random(len(stamp)) < 0.5) & ~gap
    kept[[0, *ends, -1]] = True
    model = model_of(name, form)
    difference = run(model, "wire", theta[kept], stamp[kept]) - run(model, "wire", theta, stamp)[kept]
    sudden = np.abs(stamp[kept] - (8.0 if name == "wire_slip" else 10.0)) < 0.1
    shaken = 5.0 if form in registry()[name].shaking else 1.0  # four links that swing shake the lightest one
    assert close(difference[~sudden], 3 * shaken * NOISE_FLOOR)


def test_two_effects_with_memory_never_share_a_place() -> None:
    """But for those that set the friction element, where they only add to its width."""
    stamp = stamps(1, 100)
    places: dict[tuple[str, int], str] = {}
    for name, form in CASES:
        stage = registry()[name].stage
        _, state = Chain(model_of(name, form), stage).run(motion(stamp), stamp)
        if state.blocks.get(name) is not None and registry()[name].place != Effect.CORE:
            assert places.setdefault((stage, registry()[name].place), name) == name
    assert len(places) >= 4
