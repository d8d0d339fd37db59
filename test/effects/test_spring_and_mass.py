"""A wire's spring with the link's mass on it: under friction, and under weight."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects.filters import swing_step
from trunk_ros.effects.wire.held_link import HeldLink
from trunk_ros.model import load_model
from trunk_ros.parameter import Parameter

OMEGA, ZETA, WIDTH = 2 * np.pi * 7.0, 0.25, 3e-3
FINE = 400  # steps of the reference between two samples


def commands() -> tuple[Array, Array]:
    """Stamps and a wire that starts, stops and turns back, (n,)."""
    stamp = np.arange(0.0, 4.0, 0.01)
    return stamp, 0.05 * np.clip(np.sin(2 * np.pi * 0.7 * stamp) * 1.4, -1.0, 1.0)


def stepped(stamp: Array, u: Array) -> Array:
    """The same law in small steps, by Moreau's rule: what friction can hold does not move."""
    y, speed, out = u[0], 0.0, [u[0]]
    for k in range(1, len(u)):
        h, ramp = (stamp[k] - stamp[k - 1]) / FINE, (u[k] - u[k - 1]) / (stamp[k] - stamp[k - 1])
        for i in range(FINE):
            at = u[k - 1] + ramp * h * (i + 1)
            push = speed + h * (OMEGA**2 * (at - y) + 2 * ZETA * OMEGA * ramp)
            held, weight = h * OMEGA**2 * WIDTH, 1.0 + h * 2 * ZETA * OMEGA + h * h * OMEGA**2
            speed = np.sign(push) * max(abs(push) - held, 0.0) / weight
            y += h * speed
        out.append(y)
    return np.array(out)


def test_a_held_link_sticks_and_slips_as_its_law_says() -> None:
    stamp, u = commands()
    element = HeldLink(np.array([OMEGA]), np.array([ZETA]), np.diff(stamp, prepend=0.0))
    got, _ = element.run(u[:, None], np.array([[WIDTH]]), None)
    wanted = stepped(stamp, u)
    assert got[:, 0] == pytest.approx(wanted, abs=2e-5)
    assert np.mean(np.diff(wanted) == 0.0) > 0.1  # it does stick


def test_a_rigid_held_link_is_the_play() -> None:
    stamp, u = commands()
    got, _ = HeldLink(np.zeros(1), np.array([ZETA]), np.diff(stamp, prepend=0.0)).run(
        u[:, None], np.array([[WIDTH]]), None
    )
    theta, out = u[0], []
    for x in u:
        theta = min(max(theta, x - WIDTH), x + WIDTH)
        out.append(theta)
    assert got[:, 0] == pytest.approx(np.array(out), abs=1e-12)


def elastic(form: str, soft: float, **more: object) -> Chain:
    """The nominal arm without dead bands on wires that give way."""
    model = load_model("trunk").parameters() | {"wire.dead_band": [0.0] * 5}
    values = {"form": form, "compliance": [soft] * 5, "payload": 0.05, **more}
    return Chain(type(load_model("trunk")).from_parameters(
        model | {f"effects.load_elasticity.{k}": v for k, v in values.items()}
    ), "wire")  # fmt: skip


def test_links_on_their_springs_come_to_rest_where_their_weight_is_borne() -> None:
    stamp = np.arange(0.0, 12.0, 0.01)
    gearbox = np.tile(np.array([0.6, 0.3, -0.2, 0.4, 0.1]), (len(stamp), 1)) * np.minimum(stamp, 1.0)[:, None]
    swinging, _ = elastic("links", 0.05, damping=[0.2] * 5).run(gearbox, stamp)
    still, _ = elastic("weight", 0.05).run(gearbox, stamp)
    assert swinging[-1] == pytest.approx(still[-1], abs=1e-7)
    moved = np.abs(swinging - still).max(axis=0)
    assert np.all(moved > 5e-4)  # on the way their mass counts


@pytest.mark.parametrize(("unit", "factor"), [("rad/(N*m)", 0.1), ("N*m", 10.0), ("rad", 1.0)])
def test_usual_sizes_go_by_what_a_joint_bears(unit: str, factor: float) -> None:
    assert Parameter("p", unit, (0.0, 1.0), "", typical=1.0).under(1.0) == pytest.approx(factor)
    assert Parameter("p", unit, (0.0, 1.0), "", typical=1.0).under(0.0) == 1.0


@pytest.mark.parametrize("zeta", [0.0, 0.2, 1.0 - 1e-15, 1.0, 1.0 + 1e-12, 1.4, 30.0])
def test_a_step_of_a_swing_is_exact_however_it_is_damped(zeta: float) -> None:
    dt, got = 0.02, np.empty(5)
    swing_step(dt, OMEGA, zeta, got)
    wanted = expm(dt * np.array([[0.0, 1.0], [-(OMEGA**2), -2.0 * zeta * OMEGA]]))
    np.testing.assert_allclose(got[:4], wanted.ravel(), rtol=1e-6, atol=1e-9)


def test_a_folded_arm_is_damped_more_than_a_straight_one() -> None:
    """The mass beyond the first joint is a fraction of that of the straight arm: beyond critical damping."""
    stamp, folded = np.arange(0.0, 3.0, 0.01), np.array([0.0, 3.0, -3.0, 3.0, -3.0])
    moving = folded + 0.2 * np.sin(2.0 * stamp)[:, None] * np.eye(5)[0]
    chain = elastic("links", 0.02, damping=np.full(5, 0.94), compliance=0.02 * np.eye(5)[0])
    shown = chain.run(moving / chain.model.arm.ratio, stamp)[0]
    assert np.isfinite(shown).all()
    assert np.abs(shown[:, 0] - moving[:, 0]).max() < 0.2
