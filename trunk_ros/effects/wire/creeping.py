"""How a wire creeps, step by step: behind the friction, back from there, and before it."""

import numpy as np

from trunk_ros.compiled import Array, compiled, copied
from trunk_ros.effects.filters import kept, lag_step, lowpass


@compiled
def creep_before(
    u: Array,
    width: Array,
    gain: Array,
    rubbing: Array,
    share: Array,
    constant: Array,
    dt: Array,
    memory: Array,
    out: Array,
) -> None:
    """By how much the wire before a play has crept, (n, columns) rad, as it moves by ``u`` (n, columns) rad:
    in modes of a ``share`` of it and a time ``constant`` (modes, columns). ``memory`` (2 + modes, columns) is
    the joint's angle, what bears on the wire and what that has come to in the time of each mode.
    """
    steps, columns = u.shape
    modes = len(share)
    lags, known, s = np.empty((2, modes, 2)), np.empty(2), 0
    for j in range(columns):
        known[0] = known[1] = -1.0
        theta, bears = memory[0, j], memory[1, j]
        for k in range(steps):
            s, new_step = kept(dt[k], known, s)
            if new_step:
                for m in range(modes):
                    lags[s, m, 0], lags[s, m, 1] = lag_step(dt[k], constant[m, j])
            ahead = u[k, j]
            for m in range(modes):
                decay = lags[s, m, 1]
                ahead -= share[m, j] * (decay * memory[2 + m, j] + (1.0 - decay) * bears)
            w = max(width[k, j], 0.0)
            theta = min(max(theta, ahead - w), ahead + w)
            new, crept = gain[j] * theta + rubbing[j] * (ahead - theta), 0.0
            for m in range(modes):
                ramp, decay = lags[s, m, 0], lags[s, m, 1]
                came = ramp * new + (1.0 - ramp - decay) * bears + decay * memory[2 + m, j]
                memory[2 + m, j] = came
                crept += share[m, j] * came
            bears = new
            out[k, j] = crept
        memory[0, j], memory[1, j] = theta, bears


@compiled
def creep(x: Array, dt: Array, gain: Array, constant: Array, before: Array, out: Array) -> None:
    """theta = x - gain lowpass(x); ``before`` (modes, 2, columns) holds each low-pass' input and output of
    the sample before.
    """
    steps, columns = x.shape
    low = np.empty((steps, columns))
    for j in range(columns):
        copied(x[:, j], out[:, j])
    for m in range(len(gain)):
        lowpass(x, dt, constant[m], before[m], low)
        for j in range(columns):
            for k in range(steps):
                out[k, j] -= gain[m, j] * low[k, j]


@compiled
def creep_inverse(y: Array, dt: Array, gain: Array, constant: Array, before: Array, out: Array) -> None:
    """The input for which ``creep`` gives ``y``: step by step, what is known of the low-pass, and its share
    of the new input.
    """
    steps, columns = y.shape
    modes = len(gain)
    shares = np.empty((2, modes, 2, columns))
    known, s = np.full(2, -1.0), 0
    for k in range(steps):
        s, new_step = kept(dt[k], known, s)
        share = shares[s]
        if new_step:
            fill_in(dt[k], constant, share)
        for j in range(columns):
            wanted, left = y[k, j], 1.0
            for m in range(modes):
                ramp, decay = share[m, 0, j], share[m, 1, j]
                before[m, 1, j] = (1.0 - ramp - decay) * before[m, 0, j] + decay * before[m, 1, j]
                wanted += gain[m, j] * before[m, 1, j]
                left -= gain[m, j] * ramp
            out[k, j] = wanted / left
            for m in range(modes):
                before[m, 0, j] = out[k, j]
                before[m, 1, j] += share[m, 0, j] * out[k, j]


@compiled
def fill_in(dt: float, constant: Array, share: Array) -> None:
    """Shares (modes, 2, columns) of the low-passes for a step ``dt``."""
    for m in range(share.shape[0]):
        for j in range(share.shape[2]):
            share[m, 0, j], share[m, 1, j] = lag_step(dt, constant[m, j])
