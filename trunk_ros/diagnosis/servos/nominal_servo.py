"""The nominal servo of an arm of whose servos nothing is said: found in the recording first."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from operator import itemgetter
from typing import Literal

import numpy as np

from trunk_ros.arm.arm import SERVO_OF_EACH, Arm
from trunk_ros.arm_model import SAMPLED
from trunk_ros.compiled import Array
from trunk_ros.data.align import servo_joints, servo_span
from trunk_ros.data.excerpt import excerpt, moving
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.search.score import SIGNIFICANT
from trunk_ros.diagnosis.servos.further import Beside, beside_more, like_others
from trunk_ros.diagnosis.servos.servo_loop import (
    FED,
    STARTS,
    TOP_SPEED,
    TOPS,
    Loop,
    cost_of,
    fastest_of,
    in_its_valley,
    is_explained,
    numbers_of,
    usual_loops,
    with_top,
)
from trunk_ros.diagnosis.servos.stood_short import clipped
from trunk_ros.diagnosis.simulators.against import with_room
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.effect_values import Values
from trunk_ros.effects import effect
from trunk_ros.effects.moments import NULLS
from trunk_ros.levels import CLEARLY, SEVERAL
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording

METHODS: tuple[Literal["dogbox", "trf"], ...] = ("dogbox", "trf")  # one goes on where the other stands


@dataclass(frozen=True)
class Servos:
    """What the servos of an arm were found to be, for its other recordings."""

    numbers: dict[str, tuple[float, ...]]
    """By joint, as in SERVO_OF_EACH."""
    setpoints: str

    @staticmethod
    def of(before: Model, found: Model) -> Servos:
        """Those of a model in which they were ``found`` that are not as they were ``before``."""
        old, new = (numbers_of_each(model.arm) for model in (before, found))
        changed = np.any(old != new, axis=0)
        told = {joint: tuple(new[:, j].tolist()) for j, joint in enumerate(found.arm.joints) if changed[j]}
        return Servos(told, found.setpoints)

    def hash(self) -> str:
        """12 digits that change with any number."""
        return hashlib.sha256(repr((sorted(self.numbers.items()), self.setpoints)).encode()).hexdigest()[:12]

    def on(self, model: Model) -> Model:
        """The model with them, where it has joints of those names."""
        numbers = numbers_of_each(model.arm)
        for j, joint in enumerate(model.arm.joints):
            numbers[:, j] = self.numbers.get(joint, numbers[:, j])
        return replace(_with(model, numbers), setpoints=self.setpoints)


def numbers_of_each(arm: Arm) -> Array:
    """(5, joints), as in SERVO_OF_EACH."""
    return np.array([np.full(len(arm.joints), getattr(arm, name)) for name in SERVO_OF_EACH])


def with_its_servo(model: Model, recordings: Sequence[Recording], known: Servos | None = None) -> Model:
    """The model with the first-order loop that each joint's servo is: its gain, velocity loop, top speed,
    delay, and how much of the setpoint's speed it is told, where setpoints move smoothly. What is found
    beyond is what such a loop cannot do.

    Setpoints may be samples that were taken beside the shaft's angle, of what moves on between them: so they
    are where the shaft is clearly nearer to what follows from that. ``known``: found in other recordings.
    """
    if known is not None and known.numbers:
        return _identified(known.on(model), recordings, known.numbers)[0]
    return _with_further(_of_its_setpoints(model, recordings), recordings)


def _of_its_setpoints(model: Model, recordings: Sequence[Recording]) -> Model:
    """The model with its servos, and with setpoints that are samples where these are nearer."""
    held, left, loops = _identified(model, recordings)
    if model.setpoints == SAMPLED:
        return _fed(held, recordings)
    if np.sqrt(CLEARLY) * _as_samples(held, recordings, loops) > left:
        return held  # other starts would not make up for that
    sampled, less, _ = _identified(replace(model, setpoints=SAMPLED), recordings)
    return _fed(sampled, recordings) if CLEARLY * less < left else held


def _as_samples(model: Model, recordings: Sequence[Recording], loops: dict[int, Loop]) -> float:
    """What the loops of a model leave, rms [rad], by joint, with setpoints that are samples of what moves on
    between them: fitted from what they are with setpoints that are held, also as they are late then.
    """
    numbers, squares = numbers_of_each(model.arm), 0.0
    late = period(recordings) / 2.0
    for context, column, joint in moved(replace(model, setpoints=SAMPLED), recordings):
        loop = replace(Loop.of(context, column), pulled=loops[joint].pulled)
        starts = [loop.at(numbers[:, joint] + [0.0, 0.0, 0.0, k * late, 0.0])[:4] for k in (0, 1)]
        cost = min(2.0 * cost_of(loop.fitted(x, rough=True)) for x in starts)
        squares += cost * context.noise[column].std ** 2 / context.count(column)
    return float(np.sqrt(squares))


def period(recordings: Sequence[Recording]) -> float:
    """The usual time between two setpoints [s], where that is longest."""
    stamps = [r.require("setpoints").stamp for r in recordings]
    return max((float(np.median(np.diff(each))) for each in stamps if len(each) > 1), default=0.0)


def _identified(
    model: Model, recordings: Sequence[Recording], known: Collection[str] = ()
) -> tuple[Model, float, dict[int, Loop]]:
    """The model with its servos, but for those of ``known`` joints, what these leave, rms [rad], and the
    loops by joint.
    """
    if set(servo_joints(recordings[0], model)) <= set(known):
        return model, 0.0, {}
    numbers, squares, found = numbers_of_each(model.arm), 0.0, []
    for context, column, joint in moved(model, recordings):
        if context.joints[column] not in known:
            loop, numbers[:, joint], cost = _loop(context, column, numbers[:, joint])
            found.append((loop, joint, cost))
    alone = numbers.copy()
    for loop, joint, cost in found:
        told = {*(other for _, other, _ in found), *map(model.arm.index, known)} - {joint}
        others = [alone[:, other] for other in sorted(told)]
        numbers[:, joint], cost = _like_others(loop, numbers[:, joint], others, cost)
        squares += cost * loop.context.noise[loop.column].std ** 2 / loop.context.count(loop.column)
    return _with(model, numbers), float(np.sqrt(squares)), {joint: loop for loop, joint, _ in found}


def with_other_numbers(
    model: Model, effects: Mapping[str, Values]
) -> tuple[Model, dict[str, Values], set[str]]:
    """The model whose servos were found in a recording with those of their numbers that ``effects`` of it
    say to be others, the other effects, and which say no more than that: what else acts on a servo was not
    known yet when it was found.
    """
    said = {
        name
        for name, values in effects.items()
        if effect(name).changes in SERVO_OF_EACH and NULLS.keys().isdisjoint(values)
    }
    told = replace(model, effects={name: effects[name] for name in said}).with_numbers(SERVO_OF_EACH)
    arm = replace(told.arm, servo_stated=True)
    return replace(model, arm=arm), {n: v for n, v in effects.items() if n not in said}, said


def _like_others(loop: Loop, own: Array, others: list[Array], cost: float) -> tuple[Array, float]:
    """(5,) numbers of the servo of a joint that its ``own`` starts led to, or those of ``others`` where these
    leave less than the ``cost``; and what is left. Drives of one arm are much alike.
    """
    if is_explained(loop, cost):
        return own, cost
    top = float(own[TOP_SPEED][0])
    starts = [loop.at(np.where(TOP_SPEED, top, numbers))[:4] for numbers in others]
    best, left = own, cost
    for x, method in product(loop.nearest(starts, SEVERAL), METHODS):
        if not is_explained(loop, left):
            there = numbers_of(loop.fitted(x, method).x)
            left, best = min((left, best), (loop.left(there), there), key=itemgetter(0))
    best = with_top(loop, best, np.maximum(own, TOPS[-1] * fastest_of(loop.context, loop.column)))
    left = loop.left(best)
    return (best, left) if left < cost - SIGNIFICANT else (own, cost)


def _fed(model: Model, recordings: Sequence[Recording]) -> Model:
    """The model with servos that are told the speed of their setpoints, where they go like that: a drive that
    follows a profile.
    """
    numbers = numbers_of_each(model.arm)
    for context, column, joint in moved(model, recordings):
        numbers[:, joint] = _told_speed(context, column, numbers[:, joint])
    return _with(model, numbers)


def _with_further(model: Model, recordings: Sequence[Recording]) -> Model:
    """The model with the loops that its servos have beside what else they do, which is to be found then."""
    numbers, found = numbers_of_each(model.arm), dict[int, Beside]()
    for context, column, joint in moved(model, recordings):
        loop, left = _at(context, column, numbers[:, joint])
        if not is_explained(loop, left) and not clipped(context, column):
            found[joint] = beside_more(replace(loop, pulled=()), numbers[:, joint], left, found.values())
    for joint, own in found.items():
        further, at, _ = like_others(own, found.values())
        numbers[:, joint] = further.numbers(at) if further.parts else numbers[:, joint]
    return _with(model, numbers)


def moved(model: Model, recordings: Sequence[Recording]) -> Iterator[tuple[Context, int, int]]:
    """A look at the servos, and the place in it and in the arm of each joint that was asked to move, and
    did.
    """
    unlimited = with_room(model, recordings)
    context = first_look(ServoStage([excerpt(servo_span(r, unlimited)) for r in recordings], unlimited))
    for column in context.columns:
        if fastest_of(context, column) > 0.0:
            yield context, column, model.arm.index(context.joints[column])


def _with(model: Model, numbers: Array) -> Model:
    own = dict(zip(SERVO_OF_EACH, numbers, strict=True))
    return replace(model, arm=replace(model.arm, **own, servo_stated=True))


def _loop(context: Context, column: int, told: Array) -> tuple[Loop, Array, float]:
    """The loop of a joint's servo, its (5,) numbers as in SERVO_OF_EACH, and what is left of its squared
    residual. What it bears pulls at it where that explains clearly more: a servo that gives way to its load,
    as one with an impedance does, follows a part of what it is asked, and passed for a slow one.
    """
    loop = Loop.of(context, column)
    numbers, cost = _fitted(loop, told)
    if is_explained(loop, cost):
        return loop, numbers, cost
    known = clipped(context, column)
    others = [replace(loop, clipped=known)] if known else Loop.pulled_at(context, column)
    return _clearest([(loop, numbers, cost), *((other, *_fitted(other, told)) for other in others)])


def _clearest(loops: Sequence[tuple[Loop, Array, float]]) -> tuple[Loop, Array, float]:
    """The last of loops, with their numbers and what they leave, that is clearly better than all before it:
    they are pulled by more and more.
    """
    best, least = loops[0], loops[0][-1]
    for other in loops[1:]:
        best, least = (other if CLEARLY**2 * other[-1] < least else best), min(least, other[-1])
    return best


def _fitted(whole: Loop, told: Array) -> tuple[Array, float]:
    """(5,) numbers of a loop, and what is left of its squared residual. What the recording does not show
    stays what it was ``told`` to be (5,).
    """
    context, column = whole.context, whole.column
    fastest = fastest_of(context, column)
    some = moving([view.span for view in context.views], column)
    part = replace(whole, context=context.over(some)) if some else whole
    fits = []
    for top in TOPS:  # a limit that is reached, and one that is not, hide each other
        begun = part.nearest(usual_loops(fastest * top), SEVERAL)
        near = min((part.fitted(x, method, rough=True) for x in begun for method in METHODS), key=cost_of)
        fits.append(near if part is whole else whole.fitted(near.x, rough=True))
    nearest = in_its_valley(min(fits, key=cost_of), partial(whole.fitted, rough=True))
    best = numbers_of(min(nearest, whole.fitted(nearest.x), key=cost_of).x)
    cost = whole.left(best)
    open_top = np.maximum(told, TOPS[-1] * fastest)
    shown = (np.where(TOP_SPEED, open_top, numbers) for numbers in (told, best))
    return next((n for n in shown if whole.left(n) - cost <= SIGNIFICANT), best), cost


def _told_speed(context: Context, column: int, found: Array) -> Array:
    """(5,) numbers of a servo that is told how fast its setpoints move, where that explains more than what
    was ``found`` (5,) without.
    """
    (loop, left), fastest = _at(context, column, found), np.log(found[TOP_SPEED][0])
    starts = [
        np.array([np.log(kp), np.log(swings), fastest, 0.0, share])
        for kp, swings, share in product(*STARTS[:2], FED)
    ]
    near = loop.nearest([np.clip(x, loop.low, loop.high) for x in starts], SEVERAL)
    best = min((numbers_of(loop.fitted(x).x) for x in near), key=loop.left)
    if loop.left(best) > left - SIGNIFICANT:
        return found
    return with_top(loop, best, found)


def _at(context: Context, column: int, found: Array) -> tuple[Loop, float]:
    """The loop of numbers that were ``found`` (5,), pulled by the load where that explains clearly more, and
    what it leaves.
    """
    loops = [Loop.of(context, column), *Loop.pulled_at(context, column)]
    loop, _, left = _clearest([(loop, found, loop.left(found)) for loop in loops])
    return loop, left
