"""The servo of the nominal arm: position loop over velocity loop, stepped at about 2 ms or finer."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.servo.asked import beyond, mean_of, speed_asked
from trunk_ros.effects.servo.speed import held_back, led_on, rise, towards
from trunk_ros.effects.servo.summed import first_asked, gathered, held_at_first, summed_up
from trunk_ros.sine import sine

CLOSE = 0.25  # of the time that a position loop takes: longer steps would make a stiff one swing
LONGEST = 30.0  # s without a new setpoint, after which a servo stands
HALFWAY = 0.495  # of a step more between two rows, and there is one more: also where stamps are rounded


def fresh(angle: Array, speed: Array | float = 0.0) -> Array:
    """State (8, columns) of loops as a run begins, with wires that bear nothing that is known, and drives of
    which it is not known how far their own setpoint has come, how fast, and what their integral parts hold.
    """
    none = np.zeros_like(angle)
    return np.stack([angle, speed + none, angle, *(none + np.nan for _ in range(5))])


def unlimited(columns: int) -> Array:
    """(7, 1, columns) limits of loops that have none."""
    none = [[[np.inf]], [[np.inf]], [[0.0]], [[0.0]], [[np.inf]], [[0.0]], [[0.0]]]
    return np.repeat(none, columns, axis=2)


@compiled
def steps_in(span: float, step: float) -> int:
    """Steps of about ``step`` s in the ``span`` s between two rows. Were halves to go up or down, at
    200 Hz there would be 2 or 3 by chance, and 1 mrad between two looks at a run.
    """
    return max(1, int(span / step + 1.0 - HALFWAY))


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
    ki: Array,
    beside: Array,
    ahead: float,
    skip: int,
    state: Array,
    out: Array,
) -> None:
    """Gearbox angle at each stamp, before the setpoint of that stamp acts. ``up``, ``down``: top speeds.

    ``setpoint`` (m, columns) and ``stamp`` (m,) start with the ``skip`` past rows that a delay may need, and
    may go on beyond ``out`` (n, columns), for delays below 0; ``state`` (8, columns) is angle, speed, where
    the wire stuck, what the load pulled, how far the drive's own setpoint came, how fast, and what the
    integral parts of the speed's loop and of the position's ask for (NaN: the run begins) at row
    ``skip - 1``. The numbers of the loop (1 or n, columns), ``cogging`` (3, likewise), ``limits`` (7,
    likewise) of how fast the drive moves its own setpoint on, of how fast the speed changes, the error that
    the motor's dry friction holds, how far beyond its top speed the loop sums up, how fast the speed of the
    drive's own setpoint changes, s of that speed by which the loop is told it, and how fast the loop of the
    speed sums up its own error; ``reach`` (columns,).
    A wire that slides holds the shaft back by ``rub``, from ``reach`` beyond where it stuck, no less than
    ``rub``: the loop would be stiffer than its gain. A wire that sticks keeps its tension: a ``load`` (rad of
    the setpoint) that changes meanwhile only brings it nearer to sliding. Between two rows the mean of their
    loads acts. Of what wires pull the share ``torque`` acts past the top speed that the position loop may ask
    for, the rest before it. Its integral part, of the gain ``ki``, sums up neither what they pull nor what
    setpoints are fed ``beside`` (m or 0, columns): it makes up for the one, and does not know of the other.
    ``ahead`` of a step, the loop sees its shaft go on, and the shaft has the speed that it had: 0 as the
    reference, 1/2 as one that is integrated exactly, but for the square of the step.
    Within a step that late setpoints fall into, the time-weighted mean of what each asks for acts: the result
    is smooth in the delay.
    """
    rows, columns = setpoint.shape
    for j in range(columns):
        phi, v, stuck, bore, led = state[0, j], state[1, j], state[2, j], state[3, j], state[4, j]
        pace, push, total, own, used, over = state[5, j], state[6, j], state[7, j], 0.0, 0.0, 0.0
        held, smooth, known, lag = 0, 0.0, -1.0, -1.0
        for k in range(skip, skip + len(out)):
            r = k - skip
            gain, tau, late = at(kp, r, j), at(tau_v, r, j), at(delay, r, j)
            most, least = at(up, r, j), -at(down, r, j)
            pulled, rubs, zone = at(pull, r, j), at(rub, r, j), at(dead_zone, r, j)
            bears, past = at(load, r, j), at(torque, r, j)
            size, cycles, phase = at(cogging[0], r, j), at(cogging[1], r, j), at(cogging[2], r, j)
            quickest, hardest, dry = at(limits[0], r, j), at(limits[1], r, j), at(limits[2], r, j)
            firm, winds, ramp = at(ki, r, j), at(limits[3], r, j), at(limits[4], r, j)
            leads, feed, told = min(quickest, ramp) < np.inf, at(limits[5], r, j), 0.0
            restores = at(limits[6], r, j)
            if led != led and leads:
                led, pace = phi + v / gain - feed * v, v  # where a loop that goes at that speed is led
            moved = 0.0
            if rubs != 0.0 and bore == bore:  # half of it before, half of it behind the step
                moved = 0.5 * (bears - bore) * reach[j] / rubs
                stuck -= moved
            elif rubs != 0.0:  # the run begins: friction holds what the loop does not
                off = setpoint[max(k - 1, 0), j] + pulled + size * sine(cycles * phi + phase) - phi
                stuck = phi - reach[j] * min(max((bears + off - v / gain) / rubs, -1.0), 1.0)
            if firm != 0.0 and total != total:
                tension = bears - (rubs * (phi - stuck) / reach[j] if rubs != 0.0 else 0.0)
                goal = led + feed * pace if leads else first_asked(setpoint, stamp, j, k, late)
                rest = goal + pulled + size * sine(cycles * phi + phase) - phi
                total = held_at_first(rest, tension, past, v, gain, zone, least, most)
            if push != push:  # the run begins: a torque that lasts is made up for
                push = 0.0
                if restores != 0.0 and past != 0.0:
                    push -= gain * past * (bears - (rubs * (phi - stuck) / reach[j] if rubs != 0.0 else 0.0))
            borne = bears if bore != bore else 0.5 * (bore + bears)
            bore = bears
            if k > 0:
                span = min(stamp[k] - stamp[k - 1], LONGEST)
                substeps = steps_in(span, min(STEP, CLOSE / gain))
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
                    if leads:
                        came, changes = led, False
                        if ramp < np.inf:
                            led, pace = led_on(led, pace, mean, quickest, ramp, h)
                        else:
                            led = towards(led, mean, quickest * h)
                        told = feed * (led - came) / h if h > 0.0 else 0.0
                        mean = 0.5 * (came + led) + told
                    target = mean + pulled
                    if size != 0.0:
                        target += size * sine(cycles * phi + phase)
                    tension = borne
                    if reach[j] > 0.0:
                        stuck = min(max(stuck, phi - reach[j]), phi + reach[j])
                        if rubs != 0.0:
                            tension -= rubs * (phi - stuck) / reach[j]
                    error = target + (1.0 - past) * tension - (phi + ahead * h * v)
                    if firm != 0.0:
                        over = told + (mean_of(beside, stamp, j, held, t, h) if len(beside) > 0 else 0.0)
                        own = h * firm * beyond(error - (1.0 - past) * tension - over, zone)
                        used = total + ahead * own
                        asked = gain * beyond(error, zone)
                        total = summed_up(total, own, asked, least - used - winds, most - used + winds)
                    if changes:
                        rest, low, high = error - mean, least - used, most - used
                        v_ref = speed_asked(setpoint, stamp, j, held, t, h, gain, rest, zone, low, high)
                    else:
                        v_ref = min(max(gain * beyond(error, zone), least - used), most - used)
                    v_ref += used
                    wanted = v_ref
                    v_ref += gain * past * tension
                    v_ref += push
                    before = v
                    if hardest < np.inf:
                        v = towards(v, v + smooth * (v_ref - v), hardest * h)
                    else:
                        v += smooth * (v_ref - v)
                    if dry != 0.0:
                        v = held_back(v, smooth * gain * dry)
                    meant = v + ahead * (before - v)
                    if restores != 0.0:
                        push += gathered(h * restores * (wanted - meant), v - before, hardest * h)
                    phi += h * meant
            stuck -= moved
            out[k - skip, j] = phi
        state[0, j] = phi
        state[1, j] = v
        state[2, j] = stuck
        state[3, j] = bore
        state[4, j] = led
        state[5, j] = pace
        state[6, j] = push
        state[7, j] = total
