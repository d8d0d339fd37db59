"""The loops of servos of which nothing but the load and what pulls changes: all steps in one while linear."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.servo.asked import speed_asked
from trunk_ros.effects.servo.loop import CLOSE, LONGEST, steps_in
from trunk_ros.effects.servo.speed import rise

MOST = 64  # steps that are taken in one
GRID = 1e-11  # s to which the time between two rows is rounded: else each row would have powers of its own


@compiled
def leaping_loops(
    setpoint: Array,
    stamp: Array,
    kp: Array,
    tau_v: Array,
    up: Array,
    down: Array,
    delay: Array,
    pull: Array,
    load: Array,
    torque: Array,
    ahead: float,
    skip: int,
    state: Array,
    out: Array,
) -> None:
    """The same as ``servo_loop`` but for rounding, of loops without friction, dead zone, cogging, limits of
    their own or integral parts; the numbers are (columns,), ``pull`` and ``load`` (1 or n, columns).

    Between two setpoints, with no top speed in the way, a step of the loop is a matrix, and some of them are
    its power: several times faster than their steps, each of which waits for the one before. Where the top
    speed may be in the way, which is asked of a bound, the loop is stepped.
    """
    rows, columns = setpoint.shape
    power, widest = np.empty((MOST + 1, 4)), np.empty((MOST + 1, 2))
    for j in range(columns):
        phi, v, bore = state[0, j], state[1, j], state[3, j]
        gain, tau, late, past = kp[j], tau_v[j], delay[j], torque[j]
        most, least = up[j], -down[j]
        free, step = min(most, -least), min(STEP, CLOSE / gain)
        held, substeps, h, smooth, powers, known = 0, 1, 0.0, 0.0, 0, -np.inf
        for k in range(skip, skip + len(out)):
            r = k - skip
            bears, pulled = load[min(r, len(load) - 1), j], pull[min(r, len(pull) - 1), j]
            borne = bears if bore != bore else 0.5 * (bore + bears)
            bore = bears
            if k > 0:
                apart = np.rint((stamp[k] - stamp[k - 1]) / GRID) * GRID
                if apart != known:
                    known, span = apart, min(apart, LONGEST)
                    substeps = steps_in(span, step)
                    h, powers = span / substeps, 0
                    smooth = rise(h, tau, ahead)
                i, begun = 0, stamp[k] - substeps * h - late
                while i < substeps:
                    t = begun + i * h
                    while held + 1 < rows and stamp[held + 1] <= t + 1e-9:
                        held += 1
                    alone = substeps - i  # steps without a new setpoint; 0: one comes in this step
                    if held + 1 < rows and stamp[held + 1] < begun + (substeps - 1) * h + h - 1e-9:
                        alone = min(max(int((stamp[held + 1] - t) / h), 0), alone)
                        while alone > 0 and stamp[held + 1] < t + alone * h - 1e-9:
                            alone -= 1
                    goal, change, leap = setpoint[held, j] + pulled + borne, 0.0, min(max(alone, 1), MOST)
                    if alone == 0:
                        change = setpoint[held + 1, j] - setpoint[held, j]
                    if alone > 0 or held + 2 >= rows or stamp[held + 2] >= t + h - 1e-9:
                        if powers < leap:
                            powers = raised(gain, smooth, h, ahead, powers, leap, power, widest)
                        most_off = max(abs(phi - goal), abs(phi - goal - change))
                        asks = widest[leap, 0] * most_off + widest[leap, 1] * abs(v)
                        if asks + abs(gain * past * borne) < free:
                            off = phi - goal
                            if alone == 0:
                                off -= (t + h - stamp[held + 1]) / h * change
                            phi += (power[leap, 0] - 1.0) * off + power[leap, 1] * v
                            v = power[leap, 2] * off + power[leap, 3] * v
                            i += leap
                            continue
                    for _ in range(max(alone, 1)):
                        rest = (1.0 - past) * borne + pulled - (phi + ahead * h * v)
                        t = begun + i * h
                        v_ref = speed_asked(setpoint, stamp, j, held, t, h, gain, rest, 0.0, least, most)
                        before = v
                        v += smooth * (v_ref + gain * past * borne - v)
                        phi += h * (v + ahead * (before - v))
                        i += 1
            out[r, j] = phi
        state[0, j], state[1, j], state[3, j] = phi, v, bore
        state[6, j] = 0.0 if state[6, j] != state[6, j] else state[6, j]


@compiled
def raised(
    gain: float, smooth: float, h: float, ahead: float, done: int, most: int, power: Array, widest: Array
) -> int:
    """The powers, up to the ``most``-th, of how far a loop is off and its speed after a step, row by row
    (MOST + 1, 4), with those that are ``done``; ``widest`` (MOST + 1, 2): per how far it is off, and per its
    speed, the highest that is asked for in any of so many steps. Gives how many there are.
    """
    follows = 1.0 - smooth - smooth * gain * ahead * h
    goes = h * (1.0 - ahead)
    back, on = 1.0 - goes * smooth * gain, goes * follows + h * ahead
    if done == 0:
        power[0, 0], power[0, 1], power[0, 2], power[0, 3] = 1.0, 0.0, 0.0, 1.0
        widest[0, 0], widest[0, 1] = 0.0, 0.0
    for m in range(done + 1, most + 1):
        a, b, c, d = power[m - 1, 0], power[m - 1, 1], power[m - 1, 2], power[m - 1, 3]
        widest[m, 0] = max(widest[m - 1, 0], abs(gain * (a + ahead * h * c)))
        widest[m, 1] = max(widest[m - 1, 1], abs(gain * (b + ahead * h * d)))
        power[m, 0], power[m, 1] = back * a + on * c, back * b + on * d
        power[m, 2], power[m, 3] = follows * c - smooth * gain * a, follows * d - smooth * gain * b
    return most
