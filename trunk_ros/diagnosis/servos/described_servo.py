"""What a model that describes its servos leaves open: whether recorded setpoints are samples of what moves on
between them, and how fast the loops run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from operator import itemgetter

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.arm_model import SAMPLED
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.search.formed import but_for_a_lag
from trunk_ros.diagnosis.servos.nominal_servo import METHODS, moved, numbers_of_each, period
from trunk_ros.diagnosis.servos.servo_loop import (
    HARDLY_MORE,
    STEPS,
    TOP_SPEED,
    Loop,
    fastest_of,
    is_explained,
    numbers_of,
)
from trunk_ros.diagnosis.servos.stood_short import clipped
from trunk_ros.levels import CLEARLY
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording

EARLIEST = np.array([0.0, 0.0, 0.0, 0.5, 0.0])  # s before their stamps that setpoints may be there

Told = tuple[Loop, Array]
"""The loop of a joint's servo, and its (5,) numbers as a model has them, as in SERVO_OF_EACH."""


def as_it_runs(model: Model, recordings: Sequence[Recording]) -> Model:
    """A model that says its servos, with setpoints and steps as the recordings have them."""
    told = _told(model, recordings)
    sampled = with_its_setpoints(model, recordings, told)
    return with_its_step(sampled, recordings, told if sampled is model else _told(sampled, recordings))


def with_its_setpoints(model: Model, recordings: Sequence[Recording], told: Sequence[Told]) -> Model:
    """A model that says its servos, with setpoints that are samples of what moves on between them, where it
    does not say what they are, and its loops then go as told, or those that effects can make of them,
    ``told``, are clearly nearer to the shafts, and about as near as other velocity loops and late stamps
    would be: samples look like servos that are quicker, by half of the time between two of them. Where
    samples leave the loops as told, no fit of held setpoints is asked; else, what a rough one explains stays.
    """
    if model.setpoints_stated or model.setpoints == SAMPLED:
        return model
    if not any(_leads(*one, recordings) for one in told):
        return model
    sampled = replace(model, setpoints=SAMPLED)
    others = _told(sampled, recordings)
    if all(is_explained(loop, _but_for_a_lag(loop, numbers)) for loop, numbers in others):
        return sampled
    if _is_hardly_more(_left(told, quickly=True)):
        return model
    nearer = _clearly_nearer(others, told) and not _clearly_nearer(_early(told), others)
    return sampled if nearer and _explain_as_much(_left(others, quickly=True), told) else model


def with_its_step(model: Model, recordings: Sequence[Recording], told: Sequence[Told]) -> Model:
    """A model that says its servos, with loops that run faster than the reference's, where those that effects
    can make of its own, ``told``, are then clearly nearer to the shafts, and about as near as other velocity
    loops would be, which look like other steps: in proportion, in the mean of the joints. What else is wrong
    with one may leave far more than steps do, which are the same for all.
    """
    if model.arm.step != STEP or _explains(told):
        return model

    def stepped(step: float) -> Sequence[Told]:
        return _in_their_noise(told, _told(_in_steps(model, step), recordings))

    quick = stepped(0.0)
    near = STEP * (1.0 - _nearer(told, quick))
    if _explains(stepped(near)):
        return _in_steps(model, near)
    left = _left(told, quickly=True)
    fitted, rest = _fitted(quick, quickly=True)
    alike = [(loop, numbers) for (loop, _), (_, numbers) in zip(told, fitted, strict=True)]
    again = STEP * (1.0 - _nearer(alike, fitted))
    rests = {STEP: left, 0.0: rest}
    if again not in rests:
        rests[again] = _left(stepped(again), quickly=True)
    first, second = (_times(rests[step], left) for step in (0.0, again))
    if 0.0 < second < first:  # what steps leave is in proportion to how far off they are
        ends = min(again * first / (first - second), STEP)
        if ends not in rests:
            rests[ends] = _left(stepped(ends), quickly=True)
    times, step = min((_times(rest, left), step) for step, rest in rests.items())
    nearer = CLEARLY * times < 1.0
    return _in_steps(model, step) if nearer and _explain_as_much(rests[step], told) else model


def _told(model: Model, recordings: Sequence[Recording]) -> list[Told]:
    """Of each joint that was asked to move, and did; whatever its zero is. Joints that drives stop short of
    their setpoints tell only where there are no others: nobody knows yet where exactly.
    """
    numbers, out = numbers_of_each(model.arm), []
    for context, column, joint in moved(model, recordings):
        zero = context.whiten_change([np.ones(len(view.span.stamp)) for view in context.views], column)
        limited = clipped(context, column)
        out.append((replace(Loop.of(context, column), clipped=limited, beside=zero), numbers[:, joint]))
    return [one for one in out if one[0].clipped is None] or out


def _early(told: Sequence[Told]) -> list[Told]:
    """Loops that may see setpoints before their stamps, which are late then."""
    return [(replace(loop, low=loop.low - EARLIEST), numbers) for loop, numbers in told]


def _in_their_noise(told: Sequence[Told], others: Sequence[Told]) -> list[Told]:
    """``others`` in the noise of what is ``told``: each has its own, which grows with what is left."""
    return [
        (replace(loop, context=replace(loop.context, stage=other.context.stage)), numbers)
        for (loop, _), (other, numbers) in zip(told, others, strict=True)
    ]


def _in_steps(model: Model, step: float) -> Model:
    """The model with loops that run each ``step`` s."""
    return replace(model, arm=replace(model.arm, step=step))


def _explains(told: Sequence[Told]) -> bool:
    """Whether each servo goes as the model says."""
    return all(is_explained(loop, loop.left(numbers)) for loop, numbers in told)


def _explain_as_much(rest: Array, told: Sequence[Told]) -> bool:
    """Whether a ``rest`` (joints,) is hardly more than noise, or not clearly more than what loops of ``told``
    leave with other velocity loops.
    """
    if _is_hardly_more(rest):
        return True
    return _times(rest, _left(told, quickly=True, speeding=True)) < CLEARLY


def _is_hardly_more(rest: Array) -> bool:
    """Whether a ``rest`` (joints,) is hardly more than noise."""
    return bool(np.all(rest**2 <= HARDLY_MORE))


def _times(left: Array, other: Array) -> float:
    """How many times ``other`` (joints,) is ``left`` (joints,), in the geometric mean of those joints that
    are not explained with both; of all, where each is: noise may be taken for too large.
    """
    tells = np.maximum(left, other) > np.sqrt(HARDLY_MORE)
    return float(np.exp(np.mean(np.log(left / other)[tells | ~tells.any()])))


def _leads(loop: Loop, numbers: Array, recordings: Sequence[Recording]) -> bool:
    """Whether a shaft is ahead of the model's loop by a fourth of the time between two setpoints or more, as
    far as another gain does not say so: held setpoints come half of it late. A linear look, which is cheap.
    """
    if is_explained(loop, _but_for_a_lag(loop, numbers)):
        return False
    return bool(_ways(loop, numbers, [])[1] < -period(recordings) / 4.0)


def _but_for_a_lag(loop: Loop, numbers: Array) -> float:
    """What a loop leaves, but for what it may be later than it is described."""
    rest = but_for_a_lag(loop.context, loop.column, loop.residual(numbers))
    return float(rest @ rest)


def _nearer(told: Sequence[Told], others: Sequence[Told]) -> float:
    """How much of the way to what ``others`` predict leaves least, beside another gain and delay: the median
    of a linear look at each joint.
    """
    shares = []
    for (loop, numbers), (other, _) in zip(told, others, strict=True):
        there = other.residual(numbers)
        shares.append(np.clip(_ways(loop, numbers, [there])[2], 0.0, 1.0))
    return float(np.median(shares))


def _ways(loop: Loop, numbers: Array, others: Sequence[Array]) -> Array:
    """How far a loop's gain (logarithm) and delay [s] are from what it is told, and how much of the way it is
    to ``others`` that are whitened likewise.
    """
    at, tau_v = loop.at(numbers), float(numbers[1])
    base = loop.residual(numbers_of(at, tau_v))
    gain, late = (loop.residual(numbers_of(at + np.diag(STEPS)[k], tau_v)) - base for k in (0, 3))
    ways = np.column_stack([gain / STEPS[0], late / STEPS[3], *(other - base for other in others)])
    return np.asarray(np.linalg.lstsq(ways, -base, rcond=None)[0])


def _clearly_nearer(others: Sequence[Told], told: Sequence[Told]) -> bool:
    """Whether what is ``_left`` of all joints, rms [rad], is clearly less with ``others``; not where it is
    not with the first of them already, however near the rest of them are.
    """
    lagging = [_but_for_a_lag(loop, numbers) / loop.context.count(loop.column) for loop, numbers in told]
    most, left = _in_rad(lagging, told), 0.0
    for one in others:
        left += _in_rad(_left([one]) ** 2, [one])
        if CLEARLY**2 * left >= most:
            return False
    return CLEARLY**2 * left < _in_rad(_left(told) ** 2, told)


def _in_rad(squares: Sequence[float] | Array, told: Sequence[Told]) -> float:
    """Mean squares over noise (joints,) of all of them, rad^2."""
    return float(np.sum(squares * np.array([loop.context.noise[loop.column].std ** 2 for loop, _ in told])))


def _left(told: Sequence[Told], quickly: bool = False, speeding: bool = False) -> Array:
    """(joints,) what loops leave, rms over noise, as they are ``_fitted``."""
    return _fitted(told, quickly, speeding)[1]


def _fitted(told: Sequence[Told], quickly: bool = False, speeding: bool = False) -> tuple[list[Told], Array]:
    """Loops like those of a model with other gains, delays and top speeds, as effects make them, and what
    they leave (joints,), rms over noise; ``quickly``: as a rough fit by one method has it; ``speeding``: also
    with other velocity loops.
    """
    best, rms, methods = [], [], METHODS[: 1 if quickly else None]
    for loop, numbers in told:
        cost, found = _but_for_a_lag(loop, numbers), numbers
        if not is_explained(loop, cost):
            tau_v, share = None if speeding else float(numbers[1]), None if numbers[-1] else -1
            for top, method in product(
                (numbers[TOP_SPEED][0], fastest_of(loop.context, loop.column)), methods
            ):
                if quickly and is_explained(loop, cost):
                    break
                start = loop.at(np.where(TOP_SPEED, top, numbers))[:share]
                other = numbers_of(loop.fitted(start, method, tau_v, quickly).x, tau_v)
                cost, found = min((cost, found), (loop.left(other), other), key=itemgetter(0))
        best.append((loop, found))
        rms.append(np.sqrt(cost / loop.context.count(loop.column)))
    return best, np.array(rms)
