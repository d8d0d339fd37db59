"""The nominal servo of an arm of whose servos nothing is said: found in the recording first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.arm import SERVO_OF_EACH
from trunk_ros.arm_model import SAMPLED
from trunk_ros.diagnosis.data.align import servo_span
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.levels import CLEARLY, TURNS
from trunk_ros.diagnosis.search.candidates import Candidate, extended
from trunk_ros.diagnosis.search.fit import Fit, refit_column
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.score import beats, score
from trunk_ros.diagnosis.servo import ServoStage
from trunk_ros.effects import registry
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording

STIFFEST = 2000.0  # 1/s: what answers faster is where it was asked to be, for all that can be seen
DAMPED = 0.2  # of critical: no servo is tuned to swing longer


def with_its_servo(model: Model, recordings: Sequence[Recording]) -> Model:
    """The model with the first-order loop that each joint's servo is: its gain, delay, velocity loop and top
    speed, each as far as it pays. What is found beyond is what such a loop cannot do.

    Setpoints may be samples that were taken beside the shaft's angle, of what moves on between them: so they
    are where the shaft is clearly nearer to what follows from that.
    """
    held, left = _identified(model, recordings)
    sampled, less = _identified(replace(model, setpoints=SAMPLED), recordings)
    return sampled if CLEARLY * less < left else held


def _identified(model: Model, recordings: Sequence[Recording]) -> tuple[Model, float]:
    """The model with its servo, and what that leaves, rms over the joints [rad]."""
    spans = [servo_span(r, model) for r in recordings]
    for _ in range(TURNS):
        best = begun(first_look(ServoStage(spans, model)))
        for column in best.context.columns:
            while beats(more := min(_with_more(best, column), key=score, default=best), best):
                best = more
        found = best.hypothesis.model_effects(len(model.arm.joints))
        model = replace(model, arm=_looped(replace(model, effects={**model.effects, **found})))
        if not found:
            break
    context = best.context
    squares = [best.cost[c] * context.noise[c].std ** 2 / context.count(c) for c in context.columns]
    return model, float(np.sqrt(np.sum(squares)))


def _with_more(best: Fit, column: int) -> Iterator[Fit]:
    """With each thing more that a servo's loop is on a joint, from each of its starts."""
    context, there = best.context, best.hypothesis
    for kind in (k for k in registry().values() if k.stage == context.stage.name and k.changes):
        if not (kind.id in there and column in there[kind.id].own):
            for start in kind({}, {}, kind.apart).starts(context.shown(column), 0):
                candidate = Candidate(kind.id, kind.apart, column, start)
                trial = refit_column(best, extended(context, there, candidate), column)
                if _may_be(trial, column):
                    yield trial


def _may_be(fit: Fit, column: int) -> bool:
    """Whether a servo may have such a loop."""
    model, joints = fit.context.stage.model, len(fit.context.joints)
    arm = _looped(replace(model, effects=fit.hypothesis.model_effects(joints)))
    kp, tau_v = (np.broadcast_to(number, joints)[column] for number in (arm.kp, arm.tau_v))
    return bool(kp <= STIFFEST and 4.0 * DAMPED**2 * kp * tau_v <= 1.0)


def _looped(model: Model) -> Arm:
    """The arm with the numbers of its servos that the effects say."""
    return replace(model.arm, **{name: model.number(name) for name in SERVO_OF_EACH}, servo_stated=True)
