"""The nominal arm, written a second time from the contract: what the diagnosis believes."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

JOINTS = tuple(f"joint_{i}" for i in range(1, 6))
COUNT = len(JOINTS)
RATIO = 10.0 / 16.0
LIMIT = np.deg2rad(23.0)
COUNTS_PER_REV = 2**17
KP, TAU_V, V_MAX, STEP = 20.0, 0.02, 1.5, 0.002
LINK = 0.05
MASS = np.array([60.0, 55.0, 50.0, 45.0, 40.0]) * 1e-3
GRAVITY = 9.81
R_C, E_MODULUS, AREA, TENSION = 16e-3, 252523.55e6, 0.113e-6, 1.0
MU_1, ALPHA_1 = 0.10, 0.9774
LENGTH = np.array([204.0, 254.0, 304.0, 354.0, 404.0]) * 1e-3
LENGTH_1 = 113.64e-3
LENGTH_2 = np.array([59.0, 109.15, 159.15, 209.15, 259.15]) * 1e-3
HALF_WIDTH = TENSION * (LENGTH_1 + np.exp(-MU_1 * ALPHA_1) * LENGTH_2) / (E_MODULUS * AREA * R_C)
COMPLIANCE = LENGTH / (E_MODULUS * AREA * R_C**2)


def moments(payload: float = 0.0) -> Array:
    """Weight moment c_k of what link k carries, (5,) N m: tau_i = sum over k >= i of c_k sin Theta_k."""
    beyond = MASS[::-1].cumsum()[::-1] - MASS
    moment: Array = GRAVITY * LINK * (MASS / 2 + beyond + payload)
    return moment


def load(theta: Array, payload: float = 0.0) -> Array:
    """Moment of all weight beyond each joint about it, theta (n, 5) rad -> (n, 5) N m."""
    pull = moments(payload) * np.sin(theta.cumsum(axis=1))
    moment: Array = pull[:, ::-1].cumsum(axis=1)[:, ::-1]
    return moment


def tip(theta: Array, length_error: Array | None = None) -> Array:
    """Tip y, z in m and roll in rad, (n, 3), of the planar chain."""
    link = LINK + (np.zeros(COUNT) if length_error is None else length_error)
    turned = theta.cumsum(axis=1)
    return np.stack([-np.sin(turned) @ link, np.cos(turned) @ link, turned[:, -1]], axis=1)


@njit(cache=True)
def play(u: Array, below: Array, above: Array, start: Array) -> Array:
    """Play: the output keeps within u - below ... u + above. All (n, 5) rad, start (5,)."""
    out = np.empty_like(u)
    last = start.copy()
    for k in range(u.shape[0]):
        for j in range(u.shape[1]):
            last[j] = min(max(last[j], u[k, j] - below[k, j]), u[k, j] + above[k, j])
            out[k, j] = last[j]
    return out


def nominal_wire(phi: Array) -> Array:
    """Joint angle that the nominal wire gives to a gearbox angle, (n, 5) rad; memory starts at its centre."""
    u = RATIO * phi
    width = np.broadcast_to(HALF_WIDTH, u.shape).copy()
    out: Array = play(u, width, width, u[0])
    return out
