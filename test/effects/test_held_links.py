"""Links with weight and mass on soft wires in joints that rub, against their law in small steps."""

from __future__ import annotations

import numpy as np
import pytest

from test.effects.example import arm_of, motion, stamps
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.now import Now
from trunk_ros.effects.wire.held_links import HeldLinks, slide
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.effects.wire.swinging_links import Links
from trunk_ros.model import Model

WIDTH, ZETA, PARTS = 2e-3, 0.15, 20
ARM = arm_of(3, dead_band=WIDTH)
STAMP = stamps(6, 100)
THETA = motion(STAMP, 3)
OMEGA = 2 * np.pi * np.array([5.0, 6.0, 7.0])


def look(angles: Array, columns: tuple[int, ...]) -> Now:
    """What some joints see of an arm whose joints are at ``angles`` (n, joints)."""
    own, ones = angles[:, columns], np.ones(len(columns))
    dt = np.diff(STAMP, prepend=STAMP[0])
    return Now(
        STAMP, dt, own, 0.0 * own, 0.0 * own, angles, angles, ARM.joints, ones, columns=columns, arm=ARM
    )


def stepped(soft: Array, slack: float = np.inf) -> Array:
    """M(q) y'' + d (y' - u') + pull(y - r phi) - tau = -F sign(y'): wires of which one slackens past a
    moment, and friction F that takes the dead band to overcome while both are taut. Moreau's rule and Gauss
    and Seidel's, and the wire as stiff as it is at the end of a step.
    """
    hold = 1.0 / soft
    damp, friction = 2 * ZETA * OMEGA * hold / OMEGA**2, hold * WIDTH
    y, speed = THETA[0] + bent(soft, slack, ARM.load(THETA[:1])[0]), np.zeros(3)
    out, load = [y.copy()], ARM.load(THETA[:1])[0]
    for before, after, dt in zip(THETA[:-1], THETA[1:], np.diff(STAMP), strict=True):
        h, ramp, soon = dt / PARTS, (after - before) / dt, (y + speed * dt)[None]
        mass, old, load = ARM.mass_matrix(soon)[0], load, ARM.load(soon)[0]
        ramp = ramp + (bent(soft, slack, load) - bent(soft, slack, old)) / dt
        for part in range(PARTS):
            share = (part + 1) / PARTS
            stretch = y - before - (after - before) * share
            firm = np.where(np.abs(stretch) < soft * slack, hold, hold / 2)
            pull = hold * (stretch - np.sign(stretch) * np.maximum(np.abs(stretch) - soft * slack, 0.0) / 2)
            full = mass + np.diag(h * damp + h * h * firm)
            push = mass @ speed + h * (old + (load - old) * share - pull + damp * ramp)
            rub(full, push, h * friction, speed)
            y = y + h * speed
        out.append(y.copy())
    return np.array(out)


@compiled
def rub(full: Array, push: Array, held: Array, speed: Array) -> None:
    """Gauss and Seidel's rounds of full v = push - held sign(v), from ``speed`` (3,) on, in place."""
    for _ in range(60):
        for j in range(3):
            rest = push[j]
            for k in range(3):
                rest -= full[j, k] * speed[k] if k != j else 0.0
            speed[j] = np.sign(rest) * max(abs(rest) - held[j], 0.0) / full[j, j]


def bent(soft: Array, slack: float, load: Array) -> Array:
    """(3,) rad by which a ``load`` (3,) stretches wires of which one slackens."""
    more: Array = np.sign(load) * np.maximum(np.abs(load) - slack, 0.0)
    return soft * (load + more)


@pytest.mark.parametrize("share", [np.inf, 0.2, 0.7])
def test_links_stick_slip_and_shake_each_other_as_their_law_says(share: float) -> None:
    """Of wires of which one slackens at a ``share`` of the largest load."""
    soft = 1.0 / (ARM.straight_inertia * OMEGA**2)
    slack = share if share == np.inf else share * float(np.abs(ARM.load(THETA)).max())
    name = "load_elasticity" if slack == np.inf else "wire_slack"
    values = {"compliance": soft} | ({} if slack == np.inf else {"threshold": np.full(3, slack)})
    held = {**values, "damping": np.full(3, ZETA), "form": "held"}
    got, _ = Chain(Model(ARM, {name: held}), "wire").run(THETA / 0.625, STAMP)
    light, _ = Chain(Model(ARM, {name: {**values, "upstream": 1.0}}), "wire").run(THETA / 0.625, STAMP)
    wanted, settled = stepped(soft, slack), STAMP > 1.5
    off, beside = (got - wanted)[settled], (light - wanted)[settled]
    assert np.std(off) < 0.15 * np.std(beside)


def test_each_of_several_joints_slides_or_stands_as_friction_lets_it() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        root = rng.normal(size=(4, 4))
        full, least = root @ root.T + 0.1 * np.eye(4), rng.uniform(0.0, 2.0, 4)
        pull, speed = rng.normal(size=4) * 3.0, np.empty(4)
        slide(full, pull, least, np.sign(rng.normal(size=4)), np.empty((4, 4)), speed)
        rest = pull - full @ speed
        stands = speed == 0.0
        assert np.all(np.abs(rest[stands]) <= least[stands] * (1 + 1e-6))
        assert rest[~stands] == pytest.approx(np.sign(speed[~stands]) * least[~stands], abs=1e-9)


def test_links_that_swing_from_some_moment_on_are_rigid_before_it() -> None:
    values = {
        "compliance": 1.0 / (ARM.straight_inertia * OMEGA**2),
        "damping": np.full(3, ZETA),
        "form": "held",
    }
    always, late, rigid = (
        Chain(Model(ARM, effects), "wire").run(THETA / 0.625, STAMP)[0]
        for effects in (
            {"load_elasticity": values},
            {"load_elasticity": {**values, "from": np.full(3, 3.0)}},
            {},
        )
    )
    before, after = STAMP < 2.9, STAMP > 3.5
    assert late[before] == pytest.approx(rigid[before], abs=1e-12)
    assert np.std((late - rigid)[after]) > 0.5 * np.std((always - rigid)[after])


def test_a_joint_that_is_looked_at_alone_moves_as_it_does_among_the_others() -> None:
    """What a fit sees of it: a tenth of what its mass does besides."""
    links = Links(ARM, (0, 1, 2), OMEGA, np.full(3, ZETA))
    width = np.full((1, 3), WIDTH)
    together, _ = HeldLinks(links, look(THETA, (0, 1, 2))).run(THETA, width, None)
    light, _ = SharpPlay().run(THETA, width, None)
    for c in range(3):
        one = Links(ARM, (c,), OMEGA[[c]], np.full(1, ZETA))
        alone, _ = HeldLinks(one, look(together, (c,))).run(THETA[:, [c]], width[:, [c]], None)
        off, beside = alone[:, 0] - together[:, c], light[:, c] - together[:, c]
        assert np.std(off) < 0.1 * np.std(beside)
