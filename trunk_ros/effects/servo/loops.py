"""The loops of many servos, stepped side by side."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.servo.asked import ask, beyond, speed_asked
from trunk_ros.effects.servo.loop import CLOSE, LONGEST, steps_in
from trunk_ros.effects.servo.speed import held_back, led_on, rise, towards
from trunk_ros.effects.servo.summed import first_asked, gathered, held_at_first, summed_up
from trunk_ros.sine import sine

SEVERAL = 5  # columns from which on it pays to step them side by side
BLOCK = 8  # steps of which setpoints are looked up at once


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
    ki: Array,
    beside: Array,
    ahead: float,
    skip: int,
    state: Array,
    out: Array,
) -> None:
    """The same as ``servo_loop``, to the last bit, with the columns in the innermost loop."""
    columns = setpoint.shape[1]
    phi, v, stuck, bore, led, pace, push, total = state
    held, substeps = np.zeros(columns, np.int64), np.zeros(columns, np.int64)
    step, h, smooth = np.empty(columns), np.empty(columns), np.empty(columns)
    tension, borne, moved = np.empty(columns), np.empty(columns), np.empty(columns)
    known, asked, whole = np.full(columns, -1.0), np.zeros((BLOCK, columns)), np.empty(columns)
    mixed, first_of = np.zeros(BLOCK, np.bool_), np.zeros((BLOCK, columns), np.int64)
    clocked = np.zeros(columns, np.bool_)  # as the column before
    below, above, own, used = -down, up + 0.0, np.zeros(columns), np.zeros(columns)
    sums, feeds, over = np.any(ki != 0.0), len(beside) > 0, np.zeros((BLOCK, columns))
    of_those, when = np.zeros(BLOCK, np.bool_), np.zeros((BLOCK, columns), np.int64)
    for j in range(columns):
        step[j] = min(STEP, CLOSE / kp[j])
        clocked[j] = j > 0 and delay[j] == delay[j - 1] and step[j] == step[j - 1]
        if skip > 0:
            held[j] = max(np.searchsorted(stamp, stamp[skip - 1] - delay[j], side="right") - 1, 0)
    rubs, cogs = np.any(rub != 0.0), np.any(cogging[0] != 0.0)
    quickest, ramp, feed = limits[0], limits[4], limits[5]
    led_to = np.minimum(quickest, ramp) < np.inf
    leads, strains = np.any(led_to), np.any(limits[1] < np.inf)
    dries, restore = np.any(limits[2] != 0.0), np.any(limits[6] != 0.0)
    for j in range(columns):
        if led[j] != led[j] and led_to[j]:
            led[j], pace[j] = phi[j] + v[j] / kp[j] - feed[j] * v[j], v[j]
    for k in range(skip, skip + len(out)):
        span = min(stamp[k] - stamp[k - 1], LONGEST) if k > 0 else 0.0
        most, zones = 0, False
        for j in range(columns if k > 0 else 0):
            if clocked[j]:
                substeps[j], h[j] = substeps[j - 1], h[j - 1]
            else:
                substeps[j] = steps_in(span, step[j])
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
            if ki[j] != 0.0 and total[j] != total[j]:
                pulls = load[k - skip, j] - (
                    rub[j] * (phi[j] - stuck[j]) / reach[j] if rub[j] != 0.0 else 0.0
                )
                goal = (
                    led[j] + feed[j] * pace[j] if led_to[j] else first_asked(setpoint, stamp, j, k, delay[j])
                )
                swing = cogging[0, j] * sine(cogging[1, j] * phi[j] + cogging[2, j])
                total[j] = held_at_first(
                    goal + pull[k - skip, j] + swing - phi[j], pulls, torque[j], v[j], kp[j],
                    dead_zone[k - skip, j], -down[j], up[j],
                )  # fmt: skip
            if push[j] != push[j]:
                push[j] = 0.0
                if limits[6, j] != 0.0 and torque[j] != 0.0:
                    held_by = rub[j] * (phi[j] - stuck[j]) / reach[j] if rub[j] != 0.0 else 0.0
                    push[j] -= kp[j] * torque[j] * (load[k - skip, j] - held_by)
            borne[j] = load[k - skip, j] if bore[j] != bore[j] else 0.5 * (bore[j] + load[k - skip, j])
            bore[j] = load[k - skip, j]
        for first in range(0, most, BLOCK):
            last = min(first + BLOCK, most)
            if sums and feeds:
                ask(
                    beside, stamp, stamp[k] - span, delay, h, substeps, clocked, held.copy(), first, last,
                    over, when, of_those,
                )  # fmt: skip
            ask(
                setpoint, stamp, stamp[k] - span, delay, h, substeps, clocked, held, first, last,
                asked, first_of, mixed,
            )  # fmt: skip
            for i in range(first, last):
                row = i - first
                error, mix = asked[row], mixed[row]
                if leads:
                    for j in range(columns):
                        if led_to[j] and i < substeps[j]:
                            came = led[j]
                            if ramp[j] < np.inf:
                                led[j], pace[j] = led_on(came, pace[j], error[j], quickest[j], ramp[j], h[j])
                            else:
                                led[j] = towards(came, error[j], quickest[j] * h[j])
                            told = feed[j] * (led[j] - came) / h[j] if h[j] > 0.0 else 0.0
                            error[j] = 0.5 * (came + led[j]) + told
                            over[row, j] = told + (over[row, j] if feeds else 0.0)
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
                if sums:
                    for j in range(columns):
                        if ki[j] != 0.0 and i < substeps[j]:
                            off = error[j] - (1.0 - torque[j]) * tension[j] - over[row, j]
                            own[j] = h[j] * ki[j] * beyond(off, dead_zone[k - skip, j])
                            used[j] = total[j] + ahead * own[j]
                            below[j], above[j] = -down[j] - used[j], up[j] - used[j]
                if zones:
                    for j in range(columns):
                        zone = dead_zone[k - skip, j]
                        if zone > 0.0:
                            error[j] = beyond(error[j], zone)
                if sums:
                    for j in range(columns):
                        if ki[j] != 0.0 and i < substeps[j]:
                            least, highest = below[j] - limits[3, j], above[j] + limits[3, j]
                            total[j] = summed_up(total[j], own[j], kp[j] * error[j], least, highest)
                for j in range(columns):
                    goes_on = i < substeps[j]
                    v_ref = kp[j] * error[j]
                    v_ref = above[j] if v_ref > above[j] else v_ref  # not min, which could not be vectorised
                    v_ref = below[j] if v_ref < below[j] else v_ref
                    if mix and goes_on and first_of[row, j] >= 0:
                        begun, zone = first_of[row, j], dead_zone[k - skip, j]
                        t = stamp[k] - span + i * h[j] - delay[j]
                        v_ref = speed_asked(
                            setpoint, stamp, j, begun, t, h[j], kp[j], whole[j], zone, below[j], above[j]
                        )
                    v_ref += used[j]
                    wanted = v_ref
                    v_ref += kp[j] * torque[j] * tension[j]
                    v_ref += push[j]
                    before = v[j]
                    if strains and limits[1, j] < np.inf:
                        v_ref = towards(before, before + smooth[j] * (v_ref - before), limits[1, j] * h[j])
                        v[j] = v_ref if goes_on else before
                    else:
                        v[j] += (smooth[j] if goes_on else 0.0) * (v_ref - before)
                    if dries and goes_on and limits[2, j] != 0.0:
                        v[j] = held_back(v[j], smooth[j] * kp[j] * limits[2, j])
                    meant = v[j] + ahead * (before - v[j])
                    if restore and goes_on and limits[6, j] != 0.0:
                        off = h[j] * limits[6, j] * (wanted - meant)
                        push[j] += gathered(off, v[j] - before, limits[1, j] * h[j])
                    phi[j] += (h[j] if goes_on else 0.0) * meant
        for j in range(columns):
            stuck[j] -= moved[j]
            out[k - skip, j] = phi[j]
