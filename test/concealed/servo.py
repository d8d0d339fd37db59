"""Setpoint to gearbox angle: position and velocity loop at 2 ms, with what a servo may hide."""

from __future__ import annotations

import numpy as np
from numba import njit

from test.concealed.hidden import Hidden
from test.concealed.nominal import COUNT, HALF_WIDTH, KP, RATIO, STEP, TAU_V, V_MAX, Array, moments

SUB = 5  # servo steps per setpoint (10 ms)


@njit(cache=True)
def _asked(setpoint: Array, k: int, j: int, late: float) -> float:
    """Setpoint that acts in the step from k on, averaged over a change within the step."""
    at = k - late
    whole = int(np.floor(at))
    share = at - whole
    first = min(max(whole // SUB, 0), setpoint.shape[0] - 1)
    after = min(max((whole + 1) // SUB, 0), setpoint.shape[0] - 1)
    return float((1 - share) * setpoint[first, j] + share * setpoint[after, j])


@njit(cache=True)
def _loop(setpoint: Array, own: Array, weight: Array) -> tuple[Array, Array]:
    """own: per joint kp, v_max, late (steps), droop, cogging amplitude, cycles, phase, dead zone."""
    n = setpoint.shape[0] * SUB
    phi, v = np.zeros((n, COUNT)), np.zeros((n, COUNT))
    p, s, tau = setpoint[0].copy(), np.zeros(COUNT), np.zeros(COUNT)
    for k in range(n):
        phi[k], v[k] = p, s
        turned = np.cumsum(RATIO * p)
        carried = 0.0
        for j in range(COUNT - 1, -1, -1):
            carried += weight[j] * np.sin(turned[j])
            tau[j] = carried
        for j in range(COUNT):
            kp, top, late, droop, cog, cycles, phase, dead = own[j]
            error = _asked(setpoint, k, j, late) + droop * tau[j] + cog * np.sin(cycles * p[j] + phase) - p[j]
            if abs(error) < dead:
                error = 0.0
            s[j] += STEP * (min(max(kp * error, -top), top) - s[j]) / TAU_V
            p[j] += STEP * s[j]
    return phi, v


def run_servo(hidden: tuple[Hidden, ...], setpoint: Array, payload: float) -> tuple[Array, Array]:
    """Gearbox angle and speed (5 n, 5) at 2 ms for setpoints (n, 5) at 10 ms."""
    own = np.tile([KP, V_MAX, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0], (COUNT, 1))
    for h in hidden:
        if h.effect == "servo_delay":
            own[:, 2] = h.column("delay") / STEP
        elif h.effect == "servo_bandwidth":
            own[:, 0] = KP * (1 + h.column("relative"))
        elif h.effect == "velocity_saturation":
            own[:, 1] = h.column("v_max", V_MAX)
        elif h.effect == "load_droop":
            own[:, 3] = h.column("gain")
        elif h.effect == "cogging":
            own[:, 4:7] = np.stack([h.column(x) for x in ("amplitude", "cycles_per_rev", "phase")], axis=1)
        elif h.effect == "x_servo_dead_zone":
            own[:, 7] = h.column("width")
    phi, v = _loop(setpoint, own, moments(payload))
    return phi, v


def compensated(reference: Array, period: float, rate: float = 1.0) -> Array:
    """Setpoints of the nominal compensator: dead band by remembered direction, its change limited in rate."""
    step = np.diff(reference, axis=0, prepend=reference[:1])
    lift, way = np.zeros(COUNT), np.zeros(COUNT)
    out = np.empty_like(reference)
    for k in range(reference.shape[0]):
        way = np.where(np.abs(step[k]) > 1e-9, np.sign(step[k]), way)
        lift = lift + np.clip(HALF_WIDTH * way - lift, -rate * period, rate * period)
        out[k] = (reference[k] + lift) / RATIO
    return out
