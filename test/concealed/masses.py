"""The arm integrated from its pieces: motors and loops, wires of finite stiffness, friction, links with mass.

wheel -- wire -- capstan (dry friction) -- wire -- joint (dry friction, drag, skin) -- links (inertia, weight)

Per joint a massless capstan, and the links' full mass matrix; every step of 0.5 ms is implicit (Moreau's time
stepping), so that sticking is exact and no wire is too stiff. All forces are moments about the joint.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from test.concealed.masses_arm import Arm, shared_of, table_of
from test.concealed.nominal import COUNT, GRAVITY, KP, LINK, MASS, RATIO, STEP, TAU_V, V_MAX, Array, load, tip
from test.concealed.plant import Motion

SUB = 4  # steps of the mechanics in one of the drive's
H = STEP / SUB
SETTLE = 250  # steps of the drive at rest before the run begins
ROUNDS = 60  # of Gauss and Seidel; most steps need a few
CLOSE = 1e-8  # rad/s
HUB = 1e-7  # kg m², of a joint
(
    BEFORE,
    AFTER,
    CAPSTAN,
    GRIP,
    JOINT,
    STATIC,
    SPEED,
    BRISTLE,
    DRAG,
    GAP,
    HARD,
    SLACK,
    CREEP,
    LATE,
    SKIN,
    WHEEL,
    ZERO,
    DAMPED,
    LAG,
) = range(19)  # of a table; fmt: skip
PAYLOAD, LIGHT, BALANCED, GAIN, GIVES = range(5)  # of what is shared
ANGLE, RATE, CABLE, CABLE_RATE, CREPT, CALM, BENT = range(7)  # of a state; from BENT on its elements
ELEMENTS = 12
FIRST_TO_SLIDE = -np.log(1.0 - (np.arange(ELEMENTS) + 0.5) / ELEMENTS)  # of a law that falls exponentially
SHARE = FIRST_TO_SLIDE / FIRST_TO_SLIDE.sum()


@njit(cache=True)
def _carried(payload: float) -> tuple[Array, Array]:
    """What of all masses hangs on two links at once, kg (5, 5), and on one, with its lever in links (5,)."""
    both, one = np.zeros((COUNT, COUNT)), np.zeros(COUNT)
    for k in range(COUNT + 1):
        mass = payload if k == COUNT else MASS[k]
        for a in range(min(k + 1, COUNT)):
            lever = 0.5 if a == k else 1.0
            one[a] += mass * lever
            for b in range(min(k + 1, COUNT)):
                both[a, b] += mass * lever * (0.5 if b == k else 1.0)
    return both, one


@njit(cache=True)
def _links(th: Array, w: Array, both: Array, one: Array, own: Array) -> tuple[Array, Array]:
    """Mass matrix (5, 5) kg m², moments of weight and centrifugal forces (5,) N m, about the joints."""
    turned, rate = np.cumsum(th), np.cumsum(w)
    inertia, moment = np.zeros((COUNT + 1, COUNT + 1)), np.zeros(COUNT + 1)
    for a in range(COUNT - 1, -1, -1):
        pull = GRAVITY * LINK * one[a] * np.sin(turned[a]) * (1.0 - own[BALANCED])
        for b in range(COUNT):
            pull -= LINK**2 / own[LIGHT] * both[a, b] * np.sin(turned[a] - turned[b]) * rate[b] ** 2
        moment[a] = moment[a + 1] + pull
        for b in range(COUNT - 1, -1, -1):
            here = LINK**2 / own[LIGHT] * both[a, b] * np.cos(turned[a] - turned[b])
            inertia[a, b] = here + inertia[a + 1, b] + inertia[a, b + 1] - inertia[a + 1, b + 1]
    return inertia[:COUNT, :COUNT], moment[:COUNT]


@njit(cache=True)
def _pull(stretch: float, soft: float, hard: float, slack: float) -> tuple[float, float]:
    """Moment and stiffness of the wire behind the capstan; it hardens, or one wire of two goes slack."""
    pull = stretch / soft
    if hard < 1e6:  # stretch = soft hard asinh(moment/hard)
        pull = hard * np.sinh(stretch / (soft * hard))
        return pull, np.sqrt(1 + (pull / hard) ** 2) / soft
    if abs(pull) > slack:
        return np.sign(pull) * (slack + (abs(pull) - slack) / 2), 1 / (2 * soft)
    return pull, 1 / soft


@njit(cache=True)
def _slid(push: float, holds: float, weight: float) -> float:
    """Speed of a mass that is pushed against dry friction; it sticks where that holds."""
    if abs(push) <= holds:
        return 0.0
    return (push - holds) / weight if push > 0 else (push + holds) / weight


@njit(cache=True)
def _over(stretch: float, gap: float) -> float:
    """What a stretch has beyond a play."""
    return max(stretch - gap, 0.0) + min(stretch + gap, 0.0)


@njit(cache=True)
def _bends(p: Array, j: int, rate: float, at: Array) -> float:
    """Stiffness of bristles: elements that each give until they slide (Maxwell slip), alike but for when. The
    loop of a whole slide is Dahl's; small ones close, so that shaking does not make a joint relax.
    """
    if p[BRISTLE, j] == 0:
        return 0.0
    each, stiff = 2 * p[BRISTLE, j] / ELEMENTS, 0.0
    for i in range(ELEMENTS):
        if np.sign(rate) * at[BENT + i, j] < p[JOINT, j] * SHARE[i]:
            stiff += each
    return stiff


@njit(cache=True)
def _holds(p: Array, j: int, calm: float) -> float:
    """Dry friction of a joint that has moved at a speed of late."""
    if p[BRISTLE, j] > 0:
        return 0.0
    return float(p[JOINT, j] + p[STATIC, j] * np.exp(-((calm / p[SPEED, j]) ** 2)))


@njit(cache=True)
def _pushes(u: Array, du: Array, at: Array, moment: Array, p: Array, act: Array) -> None:
    """What acts in a step. act: rows push, hold and weight of capstans, the same of joints, their link."""
    for j in range(COUNT):
        stretch = u[j] - at[CABLE, j]
        k1 = 0.0 if abs(stretch) < p[GAP, j] else 1 / p[BEFORE, j]
        pull, k2 = _pull(at[CABLE, j] - at[ANGLE, j] - at[CREPT, j], p[AFTER, j], p[HARD, j], p[SLACK, j])
        at[CALM, j] += H / p[LAG, j] * (abs(at[RATE, j]) - at[CALM, j])
        damped = p[DAMPED, j]
        act[6, j] = H * (H + damped) * k2
        act[0, j] = H * (_over(stretch, p[GAP, j]) / p[BEFORE, j] + damped * k1 * du[j] - pull)
        act[1, j] = H * (p[CAPSTAN, j] + p[GRIP, j] * abs(pull))
        act[2, j] = H * (H + damped) * k1 + act[6, j]
        act[3, j] = (
            H * (pull + moment[j] - p[SKIN, j] * at[ANGLE, j] - at[BENT:, j].sum()) + HUB * at[RATE, j]
        )
        act[4, j] = H * _holds(p, j, at[CALM, j])
        bends = _bends(p, j, at[RATE, j], at)
        act[5, j] = act[6, j] + H * p[DRAG, j] + H * H * (p[SKIN, j] + bends) + HUB


@njit(cache=True)
def _dot(mass: Array, at: Array, j: int) -> float:
    """Momentum of a joint; a loop is faster than a library for five numbers."""
    out = 0.0
    for i in range(COUNT):
        out += mass[j, i] * at[RATE, i]
    return out


@njit(cache=True)
def _solve(at: Array, mass: Array, act: Array) -> None:
    """Speeds at the end of the step, by Gauss and Seidel: sticking or sliding of all at once."""
    push = act[3].copy()
    for j in range(COUNT):
        push[j] += _dot(mass, at, j)
    for _ in range(ROUNDS):
        moved = 0.0
        for j in range(COUNT - 1, -1, -1):
            cable = _slid(act[0, j] + act[6, j] * at[RATE, j], act[1, j], act[2, j])
            others = _dot(mass, at, j) - mass[j, j] * at[RATE, j]
            rate = _slid(push[j] + act[6, j] * cable - others, act[4, j], act[5, j] + mass[j, j])
            moved = max(moved, abs(cable - at[CABLE_RATE, j]), abs(rate - at[RATE, j]))
            at[CABLE_RATE, j], at[RATE, j] = cable, rate
        if moved < CLOSE:
            return


@njit(cache=True)
def _advance(at: Array, p: Array) -> None:
    """Angles, and what friction and wires remember, at the end of the step."""
    for j in range(COUNT):
        for i in range(ELEMENTS):
            most = p[JOINT, j] * SHARE[i]
            bent = at[BENT + i, j] + H * 2 * p[BRISTLE, j] / ELEMENTS * at[RATE, j]
            at[BENT + i, j] = min(max(bent, -most), most)
        at[ANGLE, j] += H * at[RATE, j]
        at[CABLE, j] += H * at[CABLE_RATE, j]
        pull, _ = _pull(at[CABLE, j] - at[ANGLE, j] - at[CREPT, j], p[AFTER, j], p[HARD, j], p[SLACK, j])
        at[CREPT, j] += H / p[LATE, j] * (p[CREEP, j] * pull - at[CREPT, j])


@njit(cache=True)
def _wheel(shaft: Array, at: Array, p: Array, route: Array) -> Array:
    """What the wheels ask of the wires, rad at the joint (5,)."""
    out: Array = RATIO * p[WHEEL] * shaft + p[ZERO] + route @ at[ANGLE]
    return out


@njit(cache=True)
def _begin(shaft: Array, p: Array, route: Array, one: Array, own: Array) -> Array:
    """State (BENT + ELEMENTS, 5) at rest, weight on linear wires, no friction; settling does the rest."""
    at, pull = np.zeros((BENT + ELEMENTS, COUNT)), np.zeros(COUNT)
    for _ in range(30):
        turned, carried = np.cumsum(at[ANGLE]), 0.0
        for j in range(COUNT - 1, -1, -1):
            carried += GRAVITY * LINK * one[j] * np.sin(turned[j]) * (1.0 - own[BALANCED])
            pull[j] = carried - p[SKIN, j] * at[ANGLE, j]
        at[CABLE] = _wheel(shaft, at, p, route) + p[BEFORE] * pull
        at[CREPT] = -p[CREEP] * pull
        at[ANGLE] = at[CABLE] + (p[AFTER] + p[CREEP]) * pull
    return at


@njit(cache=True)
def _drive(shaft: Array, speed: Array, asked: Array, pulled: Array, own: Array) -> None:
    """One step of motors and loops; pulled (5,) N m at the joint."""
    for j in range(COUNT):
        wanted = min(max(KP * own[GAIN] * (asked[j] - shaft[j]), -V_MAX), V_MAX)
        speed[j] += STEP * ((wanted - speed[j]) / TAU_V - own[GIVES] * RATIO * pulled[j])
        shaft[j] += STEP * speed[j]


@njit(cache=True)
def _pulled(u: Array, at: Array, p: Array) -> Array:
    out = np.empty(COUNT)
    for j in range(COUNT):
        out[j] = _over(u[j] - at[CABLE, j], p[GAP, j]) / p[BEFORE, j]
    return out


@njit(cache=True)
def _run(asked: Array, first: Array, tables: Array, owns: Array, routes: Array) -> tuple[Array, Array, Array]:
    n, now, act = len(asked), 0, np.empty((7, COUNT))
    phi, v, theta = np.zeros((n, COUNT)), np.zeros((n, COUNT)), np.zeros((n, COUNT))
    shaft, speed = asked[0].copy(), np.zeros(COUNT)
    both, one = _carried(owns[0, PAYLOAD])
    at = _begin(shaft, tables[0], routes[0], one, owns[0])
    u = _wheel(shaft, at, tables[0], routes[0])
    for k in range(-SETTLE, n):
        if now + 1 < len(first) and k >= first[now + 1]:
            now += 1
            both, one = _carried(owns[now, PAYLOAD])
        p, own, route = tables[now], owns[now], routes[now]
        if k >= 0:
            phi[k], v[k], theta[k] = shaft, speed, at[ANGLE]
        before = shaft.copy()
        _drive(shaft, speed, asked[max(k, 0)], _pulled(u, at, p), own)
        for m in range(SUB):
            last, u = u, _wheel(before + (m + 1) / SUB * (shaft - before), at, p, route)
            mass, moment = _links(at[ANGLE], at[RATE], both, one, own)
            _pushes(u, (u - last) / H, at, moment, p, act)
            _solve(at, mass, act)
            _advance(at, p)
    return phi, v, theta


def run_masses(arms: list[tuple[float, Arm]], asked: Array) -> Motion:
    """The arm under what its drives are asked, (n, 5) rad at 2 ms; arms: from when (s) it is built how.

    Raises RuntimeError where the integration does not stay finite.
    """
    first = np.array([round(t / STEP) for t, _ in arms])
    tables = np.stack([table_of(arm) for _, arm in arms])
    owns, routes = np.stack([shared_of(arm) for _, arm in arms]), np.stack([arm.route for _, arm in arms])
    phi, v, theta = _run(np.ascontiguousarray(asked), first, tables, owns, routes)
    if not np.isfinite(theta).all():
        raise RuntimeError("the integration ran off")
    t = np.arange(len(phi), dtype=np.float64) * STEP
    which = np.searchsorted(first, np.arange(len(phi)), side="right") - 1
    tau = np.concatenate([load(theta[which == n], arm.payload) for n, (_, arm) in enumerate(arms)])
    return Motion(t, phi, v, theta, theta, tau, tip(theta))
