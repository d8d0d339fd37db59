"""Moments of inertia of the chain, and the motion they are computed from."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from test.effects.example import alike, arm_of, motion, stamps
from trunk_ros.arm import Arm
from trunk_ros.chain import Chain, State
from trunk_ros.compiled import Array
from trunk_ros.derivatives import LAG, follow, smooth
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.resistance import swung

NOISE_FLOOR = 1e-5  # rad
AGREED = 1e-6  # rad: what blocks and ticks may differ by, where joints see each other
triples = arrays(float, 3, elements=st.floats(-3.0, 3.0))


def loaded(joints: int = 5, payload: float = 0.1) -> Arm:
    """An arm whose inertia counts."""
    return replace(arm_of(joints), payload=payload, load_from="weight_and_inertia")


def kinetic(arm: Arm, theta: Array, speed: Array) -> float:
    """Energy of motion [J], from where the masses are; speeds by a complex step."""
    moved = places(arm, theta + 1e-20j * speed).imag / 1e-20
    masses = np.append(arm.link_mass, arm.payload)
    return float(masses @ (moved**2).sum(axis=1) / 2)


def places(arm: Arm, theta: Any) -> Any:
    """(joints + 1, 2) m: middles of the links and the tip."""
    heading = np.cumsum(theta)
    ends = np.cumsum(np.column_stack([-np.sin(heading), np.cos(heading)]) * arm.link_length[:, None], axis=0)
    starts = np.vstack([np.zeros(2), ends[:-1]])
    return np.vstack([(starts + ends) / 2, ends[-1]])


def momentum(arm: Arm, theta: Array, speed: Array) -> Array:
    """dT/dq' (joints,)."""
    rows = np.eye(len(theta))
    return np.array([(kinetic(arm, theta, speed + h) - kinetic(arm, theta, speed - h)) / 2 for h in rows])


@settings(max_examples=30, deadline=None)
@given(theta=triples, speed=triples, acceleration=triples)
def test_inertia_is_what_lagranges_equations_ask_for(theta: Array, speed: Array, acceleration: Array) -> None:
    """-(d/dt dT/dq' - dT/dq), by differences of the energy alone."""
    arm, step = loaded(3), 1e-5
    after = momentum(arm, theta + step * speed, speed + step * acceleration)
    before = momentum(arm, theta - step * speed, speed - step * acceleration)
    rows = np.eye(3) * step
    pull = np.array([kinetic(arm, theta + h, speed) - kinetic(arm, theta - h, speed) for h in rows])
    expected = -(after - before - pull) / (2 * step)
    got = arm.inertia(theta[None], speed[None], acceleration[None])[0]
    assert got == pytest.approx(expected, abs=1e-7)


def test_the_work_against_weight_and_inertia_is_the_energy_of_the_arm() -> None:
    arm, stamp = loaded(4), np.arange(4001) * 1e-3
    theta = motion(stamp, 4, amplitude=1.0, pace=3.0)
    speed = np.gradient(theta, stamp, axis=0)
    moment = arm.load(theta) + arm.inertia(theta, speed, np.gradient(speed, stamp, axis=0))
    power = -(moment * speed).sum(axis=1)
    work = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * 1e-3)])
    masses = np.append(arm.link_mass, arm.payload)
    energy = np.array(
        [
            kinetic(arm, q, v) + arm.gravity * float(masses @ places(arm, q)[:, 1])
            for q, v in zip(theta[::50], speed[::50], strict=True)
        ]
    )
    assert np.ptp(energy) > 0.05
    assert work[::50] == pytest.approx(energy - energy[0], abs=2e-4 * np.ptp(energy))


def test_in_slow_motion_only_the_weight_is_left() -> None:
    """At a tenth of the pace a hundredth of the inertia."""
    arm = replace(loaded(), dead_band=np.zeros(5))
    sizes = []
    for slower in (1, 10):
        stamp = stamps(10 * slower, 100)
        theta = motion(stamp / slower)
        moment = swung(arm, stamp, theta / arm.ratio).load(arm, theta)
        sizes.append(np.abs(moment - arm.load(theta))[100:-100].max())
    assert sizes[1] < sizes[0] / 50.0
    still = np.zeros((1, 5))
    assert arm.inertia(np.ones((1, 5)), still, still) == pytest.approx(0.0)


def test_a_payload_adds_its_inertia_with_its_lever() -> None:
    stamp = stamps(6, 100)
    theta = motion(stamp)
    bare, loaded_ = loaded(payload=0.0), loaded(payload=0.25)
    known = [swung(arm, stamp, theta / arm.ratio) for arm in (bare, loaded_)]
    assert known[0].moment == pytest.approx(known[1].moment, abs=1e-12)
    more = known[1].load(loaded_, theta) - known[0].load(bare, theta)
    assert more == pytest.approx(0.25 * known[0].per_kilogram(bare, theta), abs=1e-12)


def uneven(seconds: float, seed: int = 1) -> Array:
    """Stamps at 100 Hz on average, up to 80 ms apart."""
    return np.concatenate(
        [[0.0], np.cumsum(np.random.default_rng(seed).exponential(0.01, int(seconds * 100)))]
    )


def test_a_parabola_between_uneven_stamps_has_its_own_derivatives() -> None:
    stamp = uneven(5)
    level, slope, bend = smooth(stamp, (3.0 + 2.0 * stamp - 5.0 * stamp**2)[:, None])
    assert level[:, 0] == pytest.approx(3.0 + 2.0 * stamp - 5.0 * stamp**2, abs=1e-9)
    assert slope[:, 0] == pytest.approx(2.0 - 10.0 * stamp, abs=1e-7)
    assert bend[:, 0] == pytest.approx(-10.0, abs=1e-6)


def test_noise_becomes_the_acceleration_that_the_formula_says() -> None:
    stamp = np.arange(20_000) * 0.01
    noise = np.random.default_rng(4).normal(size=(len(stamp), 1))
    _, _, bend = smooth(stamp, noise)
    assert bend.std() == pytest.approx(4.7 / (0.06**2 * np.sqrt(6)), rel=0.25)
    speed, acceleration = np.empty_like(noise), np.empty_like(noise)
    follow(noise, np.full(len(stamp), LAG), np.zeros((3, 1)), speed, acceleration)
    assert acceleration.std() == pytest.approx(0.6 / LAG**2, rel=0.25)


def test_live_the_acceleration_is_that_of_two_lags_ago() -> None:
    stamp = np.arange(2000) * 1e-3
    x = np.sin(5.0 * stamp)[:, None]
    speed, acceleration = np.empty_like(x), np.empty_like(x)
    follow(x, np.diff(stamp, prepend=0.0), np.zeros((3, 1)), speed, acceleration)
    late = stamp[200:] - 2 * LAG
    assert speed[200:, 0] == pytest.approx(5.0 * np.cos(5.0 * late), abs=0.03)
    assert acceleration[200:, 0] == pytest.approx(-25.0 * np.sin(5.0 * late), abs=0.25)


def test_nothing_is_known_of_accelerations_between_samples_that_are_far_apart() -> None:
    _, slope, bend = smooth(np.arange(10.0), np.arange(10.0)[:, None] ** 2)
    assert np.abs(slope).max() == np.abs(bend).max() == 0.0


EFFECTS = {
    "load_dependent_friction": {"gain": np.full(5, 1e-3)},
    "load_elasticity": {"compliance": np.full(5, 0.03)},
    "joint_coupling": {"gain": np.full(5, 0.01), "source": [f"joint_{k or 5}" for k in range(5)]},
}


def chain_of(stage: str = "wire") -> Chain:
    effects = {"load_droop": {"gain": 0.01}} if stage == "servo" else EFFECTS
    return Chain(Model(loaded(), effects), stage)


@pytest.mark.parametrize("way", ["run", "invert", "servo"])
@settings(max_examples=8, deadline=None)
@given(cuts=st.sets(st.integers(1, 799), max_size=12), ticks=st.integers(0, 60))
def test_inertia_carries_its_memory_from_block_to_block(way: str, cuts: set[int], ticks: int) -> None:
    chain, stamp = chain_of("servo" if way == "servo" else "wire"), uneven(8)[:800]
    x = motion(stamp, pace=2.0)
    go = chain.invert if way == "invert" else chain.run
    state: State | None = None
    parts = []
    for part in np.split(np.arange(800), sorted(cuts | set(range(1, ticks)))):
        out, state = go(x[part], stamp[part], state)
        parts.append(out)
    alike(np.concatenate(parts), go(x, stamp)[0], 4 * AGREED)


def test_a_joint_that_is_swung_gives_way_to_its_inertia() -> None:
    stamp = stamps(12, 100)
    theta = motion(stamp, pace=3.0)
    arm = loaded()
    (with_it, _), (without, _) = (
        Chain(Model(each, {"load_elasticity": EFFECTS["load_elasticity"]}), "wire").run(theta / 0.625, stamp)
        for each in (arm, replace(arm, load_from="weight"))
    )
    late = np.interp(stamp - 2 * LAG, stamp, np.arange(len(stamp)))
    known = swung(arm, stamp, theta / 0.625)
    expected = 0.03 * (known.moment + arm.payload * known.lever)
    expected = np.column_stack([np.interp(late, np.arange(len(stamp)), c) for c in expected.T])
    assert np.abs(expected).max() > 1e-3
    off = np.abs(with_it - without - expected)
    assert np.sqrt(np.mean(off**2)) < 0.05 * np.sqrt(np.mean(expected**2))


def test_the_compensator_carries_the_inertia_as_well() -> None:
    """What is left is the inertia of the correction itself."""
    stamp = stamps(16, 100)
    wanted = motion(stamp, amplitude=0.2)
    chain = Chain(Model(loaded(payload=0.0), {"load_elasticity": EFFECTS["load_elasticity"]}), "wire")
    got, _ = chain.run(chain.invert(wanted, stamp)[0], stamp)
    alike(got, wanted, NOISE_FLOOR)


def test_the_sampling_rate_does_not_matter_to_inertia() -> None:
    fine, coarse = stamps(12, 500), stamps(12, 100)
    often, seldom = (chain_of().run(motion(t) / 0.625, t)[0] for t in (fine, coarse))
    assert np.quantile(np.abs(often[::5] - seldom), 0.99) < 2 * NOISE_FLOOR


@pytest.mark.parametrize("load", ["weight", "weight_and_inertia", "effort"])
def test_what_the_load_is_taken_from_is_kept_in_the_model_file(load: str, tmp_path: Path) -> None:
    model = Model(replace(load_model("trunk").arm, load_from=load))
    save_model(model, tmp_path / "model.yaml")
    again = load_model(tmp_path / "model.yaml")
    assert again.arm.load_from == load
    assert again.parameters() == model.parameters()
    assert again.for_joints(("joint_2",)).only(("joint_2",)).arm.load_from == load


def test_weight_alone_is_the_default() -> None:
    assert load_model("trunk").arm.load_from == "weight"


def test_an_unknown_load_is_refused_with_those_that_exist() -> None:
    with pytest.raises(ModelError, match=r"arm\.load = 'mass': choose from weight, weight_and"):
        Model.from_parameters({"arm.load": "mass"})
