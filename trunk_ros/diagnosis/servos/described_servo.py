"""What a model that describes its servos leaves open: whether recorded setpoints are samples of what moves on
between them, and how fast the loops run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.arm_model import SAMPLED
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
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
from trunk_ros.levels import CLEARLY
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording

FASTER = (STEP / 2.0, 0.0)  # s: loops of drives run at 1 kHz, or so fast that no recording tells how fast


def as_it_runs(model: Model, recordings: Sequence[Recording]) -> Model:
    """A model that says its servos, with setpoints and steps as the recordings have them."""
    return with_its_step(with_its_setpoints(model, recordings), recordings)


def with_its_setpoints(model: Model, recordings: Sequence[Recording]) -> Model:
    """A model that says its servos, with setpoints that are samples of what moves on between them, where it
    does not say what they are and loops that effects can make of its own are then clearly nearer to the
    shafts: samples look like servos that are quicker than told, by half of the time between two of them.
    """
    if model.setpoints_stated or model.setpoints == SAMPLED:
        return model
    if not any(_leads(*seen, model, recordings) for seen in moved(model, recordings)):
        return model
    sampled = replace(model, setpoints=SAMPLED)
    left, less = (_in_all(each, recordings) for each in (model, sampled))
    return sampled if CLEARLY * less < left else model


def with_its_step(model: Model, recordings: Sequence[Recording]) -> Model:
    """A model that says its servos, with loops that run faster than the reference's, where those that effects
    can make of its own are then clearly nearer to the shafts: in proportion, in the mean of the joints. What
    else is wrong with one may leave far more than steps do, which are the same for all.
    """
    if model.arm.step != STEP or _explains(model, recordings):
        return model
    near = _as_told(model, recordings)
    if _explains(near, recordings):
        return near
    told, best, least = _left(model, recordings, quickly=True), model, np.inf
    for step in (near.arm.step, *FASTER):
        faster = replace(model, arm=replace(model.arm, step=step))
        times = _times(_left(faster, recordings, quickly=True), told)
        if times < least:
            best, least = faster, times
        elif step == FASTER[0] and times >= 1.0:
            break
    return best if CLEARLY * least < 1.0 else model


def _as_told(model: Model, recordings: Sequence[Recording]) -> Model:
    """The model in the steps that leave least where all else is as it says, as far as a linear look tells."""
    endless = replace(model, arm=replace(model.arm, step=0.0))
    both = zip(moved(model, recordings), moved(endless, recordings), strict=True)
    step = STEP * (1.0 - float(np.median([_nearer(*one, other, model) for one, (other, _, _) in both])))
    return replace(model, arm=replace(model.arm, step=step))


def _times(left: Array, other: Array) -> float:
    """How many times ``other`` (joints,) is ``left`` (joints,), in the geometric mean of those joints that
    are not explained with both; of all, where each is: noise may be taken for too large.
    """
    tells = np.maximum(left, other) > np.sqrt(HARDLY_MORE)
    return float(np.exp(np.mean(np.log(left / other)[tells | ~tells.any()])))


def _explains(model: Model, recordings: Sequence[Recording]) -> bool:
    """Whether each servo goes as the model says."""
    numbers = numbers_of_each(model.arm)
    for context, column, joint in moved(model, recordings):
        loop = Loop.of(context, column)
        if not is_explained(loop, loop.left(numbers[:, joint])):
            return False
    return True


def _leads(context: Context, column: int, joint: int, model: Model, recordings: Sequence[Recording]) -> bool:
    """Whether a shaft is ahead of the model's loop by a fourth of the time between two setpoints or more, as
    far as another gain does not say so: held setpoints come half of it late. A linear look, which is cheap.
    """
    loop, told = Loop.of(context, column), numbers_of_each(model.arm)[:, joint]
    rest = but_for_a_lag(context, column, loop.residual(told))
    if is_explained(loop, float(rest @ rest)):
        return False
    return bool(_steps(loop, told, [])[1] < -period(recordings) / 4.0)


def _nearer(context: Context, column: int, joint: int, other: Context, model: Model) -> float:
    """How much of the way to what ``other`` predicts leaves least, beside another gain and delay: linear."""
    loop, told = Loop.of(context, column), numbers_of_each(model.arm)[:, joint]
    there = replace(loop, context=replace(context, stage=other.stage)).residual(told)  # in the same noise
    return float(np.clip(_steps(loop, told, [there])[2], 0.0, 1.0))


def _steps(loop: Loop, told: Array, others: Sequence[Array]) -> Array:
    """How far a loop's gain (logarithm) and delay [s] are from what it is told, and how much of the way it is
    to ``others`` that are whitened likewise.
    """
    at, tau_v = loop.at(told), float(told[1])
    base = loop.residual(numbers_of(at, tau_v))
    gain, late = (loop.residual(numbers_of(at + np.diag(STEPS)[k], tau_v)) - base for k in (0, 3))
    ways = np.column_stack([gain / STEPS[0], late / STEPS[3], *(other - base for other in others)])
    return np.asarray(np.linalg.lstsq(ways, -base, rcond=None)[0])


def _in_all(model: Model, recordings: Sequence[Recording]) -> float:
    """The same of all joints, rms [rad]."""
    noise = [context.noise[column].std for context, column, _ in moved(model, recordings)]
    return float(np.linalg.norm(_left(model, recordings) * noise))


def _left(model: Model, recordings: Sequence[Recording], quickly: bool = False) -> Array:
    """(joints,) what loops like those of a model leave, rms over noise, of other gains, delays and top
    speeds, as effects make them; ``quickly``: as a rough fit by one method has it.
    """
    numbers, rms, methods = numbers_of_each(model.arm), [], METHODS[: 1 if quickly else None]
    for context, column, joint in moved(model, recordings):
        loop, told = Loop.of(context, column), numbers[:, joint]
        rest = but_for_a_lag(context, column, loop.residual(told))
        cost = float(rest @ rest)
        if not is_explained(loop, cost):
            tau_v, share = float(told[1]), None if told[-1] else -1
            for top, method in product((told[TOP_SPEED][0], fastest_of(context, column)), methods):
                start = loop.at(np.where(TOP_SPEED, top, told))[:share]
                cost = min(cost, loop.left(numbers_of(loop.fitted(start, method, tau_v, quickly).x, tau_v)))
        rms.append(np.sqrt(cost / context.count(column)))
    return np.array(rms)
