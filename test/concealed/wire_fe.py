"""A wire pair as finite elements: elastic pieces, and contacts on the arcs that stick or slip (Coulomb).

Nothing of capstan friction, dead band or rounded reversal is put in: only springs for the wire, a normal
force T d(alpha) at every node on an arc, and a contact there that holds the wire by the shear of its coating
until mu N is reached, then slips. Quasi-static; in every step the set of slipping nodes is sought until each
agrees with its law.

The pair is one chain: gearbox wheel, wire to the joint, joint, wire back to the wheel. x is the sliding along
it as seen from the wheel, which both ends go with; the middle goes with the joint.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

from test.concealed import nominal
from test.concealed.nominal import Array

Signs: TypeAlias = NDArray[np.int64]
R_S, R_C = nominal.RATIO * nominal.R_C, nominal.R_C
ARC_RADIUS = 0.010
RIGID = 1e12  # N/m per m of arc: bare metal
TRIES = 60
SMALLEST = 1e-5
LEAP = 0.3


@dataclass(frozen=True)
class Pair:
    """One joint's wires: friction (mu1, mu2), wrap (a1, a2) rad, straight (l', l'') m, length m, tension N.

    ``shear`` N/m per m of arc is the stiffness of the contact (a soft coating rounds the reversal); ``rub``
    N m dry friction of the joint itself; ``pieces`` the elements on each arc.
    """

    friction: tuple[float, float] = (0.10, 0.08)
    wrap: tuple[float, float] = (0.9774, 0.4189)
    straight: tuple[float, float] = (0.11364, 0.15915)
    length: float = 0.304
    tension: float = 1.0
    shear: float = RIGID
    rub: float = 0.0
    pieces: int = 40


def pair_of(joint: int, tension: float = 1.0, **more: Any) -> Pair:
    """The pair of joint 0 ... 4 by the paper's table 1; more: further fields of `Pair`."""
    wrap = (nominal.ALPHA_1, 0.5411 if joint == 0 else 0.4189)
    straight = (nominal.LENGTH_1, float(nominal.LENGTH_2[joint]))
    return Pair((0.10, 0.08), wrap, straight, float(nominal.LENGTH[joint]), tension, **more)


@dataclass(frozen=True)
class Chain:
    """Elements' stiffness (m,) N/m; at the nodes (m + 1,) mu d(alpha), constant friction N, hold N/m."""

    stiffness: Array
    grip: Array
    rub: Array
    hold: Array
    middle: int
    tension: float


def chain_of(pair: Pair) -> Chain:
    """The elements of a pair: straight, arc, straight, arc, rest, and the same back."""
    arcs = [angle * ARC_RADIUS / pair.pieces for angle in pair.wrap]
    size: list[float] = []
    grip: list[float] = [0.0]
    for straight, arc, angle, mu in zip(pair.straight, arcs, pair.wrap, pair.friction, strict=True):
        share = mu * angle / pair.pieces
        size += [straight, *[arc] * pair.pieces]
        grip += [share / 2, *[share] * (pair.pieces - 1), share / 2]
    size.append(max(pair.length - sum(size), 1e-3))
    nodes = np.array([*grip, 0.0, *grip[::-1]])
    rub, middle = np.zeros(nodes.size), len(size)
    rub[middle] = pair.rub / R_C
    hold = np.where(nodes > 0, pair.shear * ARC_RADIUS * float(np.mean(pair.wrap)) / pair.pieces, 0.0)
    hold[middle] = 1e9 if pair.rub else 0.0
    stiff = nominal.E_MODULUS * nominal.AREA / np.array([*size, *size[::-1]])
    return Chain(stiff, nodes, rub, hold, middle, pair.tension)


@njit(cache=True)
def _tensions(x: Array, k: Array, pull: float) -> Array:
    """Tension of each element; a wire cannot push."""
    return np.maximum(pull + k * (x[1:] - x[:-1]), 0.0)


@njit(cache=True)
def _solve(
    x: Array,
    held: Array,
    slip: Signs,
    k: Array,
    grip: Array,
    rub: Array,
    hold: Array,
    force: Array,
    pull: float,
) -> Array:
    """Places of the nodes for a given set of slipping ones (slip -1, 0, 1).

    Slipping: T+ (1 - s g/2) - T- (1 + s g/2) = s rub - force; sticking: T+ - T- = hold (x - held) - force,
    with T = pull + k (x+ - x-): tridiagonal. A slack element counts as a very soft one.
    """
    n = x.size
    upper, right, out = np.zeros(n), np.zeros(n), np.zeros(n)
    taut = pull + k * (x[1:] - x[:-1]) > -1e-12
    for i in range(1, n - 1):
        low, high = 1 + slip[i] * grip[i] / 2, 1 - slip[i] * grip[i] / 2
        a = k[i - 1] * low * (1.0 if taut[i - 1] else 1e-6)
        c = k[i] * high * (1.0 if taut[i] else 1e-6)
        still = pull * ((high if taut[i] else 0.0) - (low if taut[i - 1] else 0.0))
        b = still - slip[i] * rub[i] + force[i]
        stuck = hold[i] if slip[i] == 0 else 0.0
        pivot = a + c + stuck - a * upper[i - 1]
        upper[i] = c / pivot
        right[i] = (b + stuck * held[i] + a * right[i - 1]) / pivot
    for i in range(n - 2, 0, -1):
        out[i] = right[i] + upper[i] * out[i + 1]
    return out


@njit(cache=True)
def _revise(
    x: Array, held: Array, slip: Signs, t: Array, grip: Array, rub: Array, hold: Array, force: Array
) -> int:
    """Lets overloaded nodes go and stops those that would slide backwards; how many changed."""
    changed = 0
    for i in range(1, x.size - 1):
        if hold[i] == 0:
            continue
        drag = t[i] - t[i - 1] + force[i]
        limit = grip[i] * (t[i] + t[i - 1]) / 2 + rub[i]
        if slip[i] == 0 and abs(drag) > limit + 1e-8:
            slip[i] = 1 if drag > 0 else -1
            changed += 1
        elif slip[i] != 0 and (x[i] - drag / hold[i] - held[i]) * slip[i] < -1e-14:
            slip[i] = 0
            changed += 1
    return changed


@njit(cache=True)
def _move(
    wheel: Array, load: Array, k: Array, grip: Array, rub: Array, hold: Array, middle: int, pull: float
) -> Array:
    """Places of all nodes (n, nodes) in m, from the wheel, for its sliding (n,) and the force on the joint.

    An increment that finds no consistent set, or leaps to another branch (a large one can make the pair
    slack), is cut to a quarter.
    """
    nodes = grip.size
    out = np.zeros((wheel.size, nodes))
    x, held, force, slip = np.zeros(nodes), np.zeros(nodes), np.zeros(nodes), np.zeros(nodes, np.int64)
    for step in range(1, wheel.size):
        done, share = 0.0, 1.0
        while done < 1.0:
            at = min(done + share, 1.0)
            force[middle] = load[step - 1] + at * (load[step] - load[step - 1])
            shifted = held - (at - done) * (wheel[step] - wheel[step - 1])
            now, trial, good = x.copy(), slip.copy(), False
            for _ in range(TRIES):
                now = _solve(now, shifted, trial, k, grip, rub, hold, force, pull)
                t = _tensions(now, k, pull)
                if _revise(now, shifted, trial, t, grip, rub, hold, force) == 0:
                    good = np.abs(t - _tensions(x, k, pull)).max() < LEAP * pull
                    break
            if not good and share > SMALLEST:
                share /= 4
                continue
            x, held, slip, done, share = now, shifted, trial, at, 2 * share
            t = _tensions(x, k, pull)
            for i in range(1, nodes - 1):
                if slip[i] != 0:
                    held[i] = x[i] - (t[i] - t[i - 1] + force[i]) / hold[i]
        out[step] = x
    return out


def nodes_of(pair: Pair, phi: Array, tau: Array | None = None) -> Array:
    """Sliding of all nodes from the wheel, (n, nodes) m, for a gearbox angle (n,) rad, a moment (n,) N m."""
    c = chain_of(pair)
    push = np.zeros(phi.size) if tau is None else tau / R_C
    out: Array = _move(R_S * phi, push, c.stiffness, c.grip, c.rub, c.hold, c.middle, c.tension)
    return out


def tensions_of(pair: Pair, nodes: Array) -> Array:
    """Tension (n, elements) N of all elements from the nodes."""
    chain = chain_of(pair)
    return np.maximum(chain.tension + chain.stiffness * np.diff(nodes, axis=1), 0.0)


def joint_angle(pair: Pair, phi: Array, tau: Array | None = None) -> Array:
    """Joint angle (n,) rad for a gearbox angle (n,) rad and a moment on the joint (n,) N m.

    The wire begins without friction in it, the joint at the wheel's angle times the ratio.
    """
    behind: Array = nodes_of(pair, phi, tau)[:, chain_of(pair).middle] / R_C
    return nominal.RATIO * phi + behind
