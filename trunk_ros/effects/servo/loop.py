"""The servo of the nominal arm: position loop over velocity loop, stepped at about 2 ms or finer."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.servo.asked import ask, beyond, speed_asked
from trunk_ros.effects.servo.speed import held_back, rise, towards
from trunk_ros.sine import sine

CLOSE = 0.25  # of the time that a position loop takes: longer steps would make a stiff one swing
LONGEST = 30.0  # s without a new setpoint, after which a servo stands
SEVERAL = 4  # columns from which on it pays to step them side by side; twice as many of such as nothing rubs
BLOCK = 8  # steps of which setpoints are looked up at once


def fresh(angle: Array, speed: Array | float = 0.0) -> Array:
    """State (5, columns) of loops as a run begins, with wires that bear nothing that is known, and drives of
    which it is not known how far their own setpoint has come.
    """
    none = np.zeros_like(angle)
    return np.stack([angle, speed + none, angle, none + np.nan, none + np.nan])


def unlimited(columns: int) -> Array:
    """(3, 1, columns) limits of loops that have none."""
    return np.repeat([[[np.inf]], [[np.inf]], [[0.0]]], columns, axis=2)


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
    up: Array,
    down: Array,
    delay: Array,
    pull: Array,
    load: Array,
    torque: Array,
    rub: Array,
    reach: Array,
    dead_zone: Array,
    cogging: Array,
    limits: Array,
    ahead: float,
    skip: int,
    state: Array,
    out: Array,
) -> None:
    """Gearbox angle at each stamp, before the setpoint of that stamp acts. ``up``, ``down``: top speeds.

    ``setpoint`` (m, columns) and ``stamp`` (m,) start with the ``skip`` past rows that a delay may need, and
    may go on beyond ``out`` (n, columns), for delays below 0; ``state`` (5, columns) is angle, speed, where
    the wire stuck, what the load pulled and how far the drive's own setpoint came (NaN: the run begins) at
    row ``skip - 1``. The numbers of the loop (1 or n, columns), ``cogging`` (3, likewise), ``limits`` (3,
    likewise) of how fast the drive moves its own setpoint on, of how fast the speed changes, and the error
    that the motor's dry friction holds; ``reach`` (columns,). A wire that slides holds the shaft back by
    ``rub``, from ``reach`` beyond where it stuck, no less than ``rub``: the loop would be stiffer than its
    gain. A wire that sticks keeps its tension: a ``load`` (rad of the setpoint) that changes meanwhile only
    brings it nearer to sliding. Between two rows the mean of their loads acts. Of what wires pull the share
    ``torque`` acts past the top speed that the position loop may ask for, the rest before it.
    ``ahead`` of a step, the loop sees its shaft go on, and the shaft has the speed that it had: 0 as the
    reference, 1/2 as one that is integrated exactly, but for the square of the step.
    Within a step that late setpoints fall into, the time-weighted mean of what each asks for acts: the result
    is smooth in the delay.
    """
    rows, columns = setpoint.shape
    for j in range(columns):
        phi, v, stuck, bore, led = state[0, j], state[1, j], state[2, j], state[3, j], state[4, j]
        held, smooth, known, lag = 0, 0.0, -1.0, -1.0
        for k in range(skip, skip + len(out)):
            r = k - skip
            gain, tau, late = at(kp, r, j), at(tau_v, r, j), at(delay, r, j)
            most, least = at(up, r, j), -at(down, r, j)
            pulled, rubs, zone = at(pull, r, j), at(rub, r, j), at(dead_zone, r, j)
            bears, past = at(load, r, j), at(torque, r, j)
            size, cycles, phase = at(cogging[0], r, j), at(cogging[1], r, j), at(cogging[2], r, j)
            quickest, hardest, dry = at(limits[0], r, j), at(limits[1], r, j), at(limits[2], r, j)
            if led != led and quickest < np.inf:
                led = phi + v / gain  # where a loop that goes at that speed is led
            moved = 0.0
            if rubs != 0.0 and bore == bore:  # half of it before, half of it behind the step
                moved = 0.5 * (bears - bore) * reach[j] / rubs
                stuck -= moved
            elif rubs != 0.0:  # the run begins: friction holds what the loop does not
                off = setpoint[max(k - 1, 0), j] + pulled + size * sine(cycles * phi + phase) - phi
                stuck = phi - reach[j] * min(max((bears + off - v / gain) / rubs, -1.0), 1.0)
            borne = bears if bore != bore else 0.5 * (bore + bears)
            bore = bears
            if k > 0:
                span = min(stamp[k] - stamp[k - 1], LONGEST)
                substeps = max(1, int(np.round(span / min(STEP, CLOSE / gain))))
                h = span / substeps
                if h != known or tau != lag:
                    known, lag, smooth = h, tau, rise(h, tau, ahead)
                for i in range(substeps):
                    t = stamp[k] - span + i * h - late
                    while held > 0 and stamp[held] > t + 1e-9:  # where setpoints have just become later
                        held -= 1
                    while held + 1 < rows and stamp[held + 1] <= t + 1e-9:
                        held += 1
                    mean, after, changes = setpoint[held, j], held + 1, False
                    while after < rows and stamp[after] < t + h - 1e-9:
                        mean += (t + h - stamp[after]) / h * (setpoint[after, j] - setpoint[after - 1, j])
                        changes = changes or setpoint[after, j] != setpoint[after - 1, j]
                        after += 1
                    if quickest < np.inf:
                        came, led, changes = led, towards(led, mean, quickest * h), False
                        mean = 0.5 * (came + led)
                    target = mean + pulled
                    if size != 0.0:
                        target += size * sine(cycles * phi + phase)
                    tension = borne
                    if reach[j] > 0.0:
                        stuck = min(max(stuck, phi - reach[j]), phi + reach[j])
                        if rubs != 0.0:
                            tension -= rubs * (phi - stuck) / reach[j]
                    error = target + (1.0 - past) * tension - (phi + ahead * h * v)
                    if changes:
                        rest = error - mean
                        v_ref = speed_asked(setpoint, stamp, j, held, t, h, gain, rest, zone, least, most)
                    else:
                        v_ref = min(max(gain * beyond(error, zone), least), most)
                    v_ref += gain * past * tension
                    before = v
                    if hardest < np.inf:
                        v = towards(v, v + smooth * (v_ref - v), hardest * h)
                    else:
                        v += smooth * (v_ref - v)
                    if dry != 0.0:
                        v = held_back(v, smooth * gain * dry)
                    phi += h * (v + ahead * (before - v))
            stuck -= moved
            out[k - skip, j] = phi
        state[0, j] = phi
        state[1, j] = v
        state[2, j] = stuck
        state[3, j] = bore
        state[4, j] = led


@compiled
def servo_loops(
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
    rub: Array,
    reach: Array,
    dead_zone: Array,
    cogging: Array,
    limits: Array,
    ahead: float,
    skip: int,
    state: Array,
    out: Array,
) -> None:
    """The same as ``servo_loop``, to the last bit, with the columns in the innermost loop."""
    columns = setpoint.shape[1]
    phi, v, stuck, bore, led = state[0], state[1], state[2], state[3], state[4]
    held, substeps = np.zeros(columns, np.int64), np.zeros(columns, np.int64)
    step, h, smooth = np.empty(columns), np.empty(columns), np.empty(columns)
    tension, borne, moved = np.empty(columns), np.empty(columns), np.empty(columns)
    known, asked, whole = np.full(columns, -1.0), np.zeros((BLOCK, columns)), np.empty(columns)
    mixed, first_of = np.zeros(BLOCK, np.bool_), np.zeros((BLOCK, columns), np.int64)
    clocked = np.zeros(columns, np.bool_)  # as the column before
    for j in range(columns):
        step[j] = min(STEP, CLOSE / kp[j])
        clocked[j] = j > 0 and delay[j] == delay[j - 1] and step[j] == step[j - 1]
        if skip > 0:
            held[j] = max(np.searchsorted(stamp, stamp[skip - 1] - delay[j], side="right") - 1, 0)
    rubs, cogs = np.any(rub != 0.0), np.any(cogging[0] != 0.0)
    leads, strains = np.any(limits[0] < np.inf), np.any(limits[1] < np.inf)
    dries = np.any(limits[2] != 0.0)
    for j in range(columns):
        if led[j] != led[j] and limits[0, j] < np.inf:
            led[j] = phi[j] + v[j] / kp[j]
    for k in range(skip, skip + len(out)):
        span = min(stamp[k] - stamp[k - 1], LONGEST) if k > 0 else 0.0
        most, zones = 0, False
        for j in range(columns if k > 0 else 0):
            if clocked[j]:
                substeps[j], h[j] = substeps[j - 1], h[j - 1]
            else:
                substeps[j] = max(1, int(np.round(span / step[j])))
                h[j] = span / substeps[j]
            if h[j] != known[j]:
                known[j] = h[j]
                smooth[j] = rise(h[j], tau_v[j], ahead)
            most = max(most, substeps[j])
            zones = zones or dead_zone[k - skip, j] > 0.0
        for j in range(columns):
            moved[j] = 0.0
            if rub[j] != 0.0 and bore[j] == bore[j]:
                moved[j] = 0.5 * (load[k - skip, j] - bore[j]) * reach[j] / rub[j]
                stuck[j] -= moved[j]
            elif rub[j] != 0.0:
                swing = cogging[0, j] * sine(cogging[1, j] * phi[j] + cogging[2, j])
                off = setpoint[max(k - 1, 0), j] + pull[k - skip, j] + swing - phi[j]
                bears = load[k - skip, j] + off - v[j] / kp[j]
                stuck[j] = phi[j] - reach[j] * min(max(bears / rub[j], -1.0), 1.0)
            borne[j] = load[k - skip, j] if bore[j] != bore[j] else 0.5 * (bore[j] + load[k - skip, j])
            bore[j] = load[k - skip, j]
        for first in range(0, most, BLOCK):
            last = min(first + BLOCK, most)
            ask(
                setpoint, stamp, stamp[k] - span, delay, h, substeps, clocked, held, first, last,
                asked, first_of, mixed,
            )  # fmt: skip
            for i in range(first, last):
                row = i - first
                error, mix = asked[row], mixed[row]
                if leads:
                    for j in range(columns):
                        if limits[0, j] < np.inf and i < substeps[j]:
                            came = led[j]
                            led[j] = towards(came, error[j], limits[0, j] * h[j])
                            error[j] = 0.5 * (came + led[j])
                            first_of[row, j] = -1
                if mix:
                    for j in range(columns):
                        whole[j] = error[j]
                for j in range(columns):
                    error[j] += pull[k - skip, j]
                if cogs:
                    for j in range(columns):
                        error[j] += cogging[0, j] * sine(cogging[1, j] * phi[j] + cogging[2, j])
                for j in range(columns):
                    tension[j] = borne[j]
                if rubs:
                    for j in range(columns):
                        if rub[j] != 0.0 and i < substeps[j]:
                            stuck[j] = min(max(stuck[j], phi[j] - reach[j]), phi[j] + reach[j])
                            tension[j] -= rub[j] * (phi[j] - stuck[j]) / reach[j]
                for j in range(columns):
                    error[j] = error[j] + (1.0 - torque[j]) * tension[j] - (phi[j] + ahead * h[j] * v[j])
                if mix:
                    for j in range(columns):
                        whole[j] = error[j] - whole[j]
                if zones:
                    for j in range(columns):
                        zone = dead_zone[k - skip, j]
                        if zone > 0.0:
                            error[j] = beyond(error[j], zone)
                for j in range(columns):
                    goes_on = i < substeps[j]
                    v_ref = kp[j] * error[j]
                    v_ref = up[j] if v_ref > up[j] else v_ref  # not min, which could not be vectorised
                    v_ref = -down[j] if v_ref < -down[j] else v_ref
                    if mix and goes_on and first_of[row, j] >= 0:
                        begun, zone = first_of[row, j], dead_zone[k - skip, j]
                        t = stamp[k] - span + i * h[j] - delay[j]
                        v_ref = speed_asked(
                            setpoint, stamp, j, begun, t, h[j], kp[j], whole[j], zone, -down[j], up[j]
                        )
                    v_ref += kp[j] * torque[j] * tension[j]
                    before = v[j]
                    if strains and limits[1, j] < np.inf:
                        v_ref = towards(before, before + smooth[j] * (v_ref - before), limits[1, j] * h[j])
                        v[j] = v_ref if goes_on else before
                    else:
                        v[j] += (smooth[j] if goes_on else 0.0) * (v_ref - before)
                    if dries and goes_on and limits[2, j] != 0.0:
                        v[j] = held_back(v[j], smooth[j] * kp[j] * limits[2, j])
                    phi[j] += (h[j] if goes_on else 0.0) * (v[j] + ahead * (before - v[j]))
        for j in range(columns):
            stuck[j] -= moved[j]
            out[k - skip, j] = phi[j]
