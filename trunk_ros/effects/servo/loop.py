"""The servo of the nominal arm: position loop over velocity loop, stepped at about 2 ms or finer."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.sine import sine

STEP = 0.002  # s
CLOSE = 0.25  # of the time that a position loop takes: longer steps would make a stiff one swing
EDGE = 0.01  # of a dead zone, over which the loop's answer rises: with a jump no two runs would agree
LONGEST = 30.0  # s without a new setpoint, after which a servo stands


@compiled
def at(numbers: Array, row: int, column: int) -> float:
    """What holds in a row, of numbers (1 or n, columns)."""
    value: float = numbers[min(row, len(numbers) - 1), column]
    return value


@compiled
def servo_loop(
    setpoint: Array,
    stamp: Array,
    kp: Array,
    tau_v: Array,
    v_max: Array,
    delay: Array,
    pull: Array,
    rub: Array,
    reach: Array,
    dead_zone: Array,
    cogging: Array,
    skip: int,
    state: Array,
    out: Array,
) -> None:
    """Gearbox angle at each stamp, before the setpoint of that stamp acts.

    ``setpoint`` (m, columns) and ``stamp`` (m,) start with the ``skip`` past rows that a delay may need;
    ``out`` (m - skip, columns); ``state`` (3, columns) is angle, speed and where the wire stuck at row
    ``skip - 1``. The numbers of the loop (1 or m - skip, columns), ``cogging`` (3, likewise), ``reach``
    (columns,). A wire that slides holds the shaft back by ``rub``, from ``reach``
    beyond where it stuck; a shorter reach than ``rub`` would make the loop stiffer than its own gain.
    Within a step that a late setpoint falls into, its time-weighted mean acts: the result is smooth in the
    delay.
    """
    rows, columns = setpoint.shape
    for j in range(columns):
        phi, v, stuck = state[0, j], state[1, j], state[2, j]
        held, smooth, known, lag = 0, 0.0, -1.0, -1.0
        for k in range(skip, rows):
            r = k - skip
            gain, tau, most, late = at(kp, r, j), at(tau_v, r, j), at(v_max, r, j), at(delay, r, j)
            pulled, rubs, zone = at(pull, r, j), at(rub, r, j), at(dead_zone, r, j)
            size, cycles, phase = at(cogging[0], r, j), at(cogging[1], r, j), at(cogging[2], r, j)
            if k > 0:
                span = min(stamp[k] - stamp[k - 1], LONGEST)
                substeps = max(1, int(np.round(span / min(STEP, CLOSE / gain))))
                h = span / substeps
                if h != known or tau != lag:
                    known, lag, smooth = h, tau, -np.expm1(-h / tau) if tau < h else h / tau
                for i in range(substeps):
                    t = stamp[k] - span + i * h - late
                    while held > 0 and stamp[held] > t + 1e-9:  # where setpoints have just become later
                        held -= 1
                    while held + 1 < k and stamp[held + 1] <= t + 1e-9:
                        held += 1
                    target = setpoint[held, j]
                    if held + 1 < k and stamp[held + 1] < t + h - 1e-9:
                        share = (t + h - stamp[held + 1]) / h
                        target += share * (setpoint[held + 1, j] - target)
                    target += pulled
                    if size != 0.0:
                        target += size * sine(cycles * phi + phase)
                    if reach[j] > 0.0:
                        stuck = min(max(stuck, phi - reach[j]), phi + reach[j])
                        if rubs != 0.0:
                            target -= rubs * (phi - stuck) / reach[j]
                    error = target - phi
                    if zone > 0.0:
                        error *= min(max((abs(error) / zone - 1.0) / EDGE + 0.5, 0.0), 1.0)
                    v_ref = min(max(gain * error, -most), most)
                    v += smooth * (v_ref - v)
                    phi += h * v
            out[k - skip, j] = phi
        state[0, j] = phi
        state[1, j] = v
        state[2, j] = stuck
