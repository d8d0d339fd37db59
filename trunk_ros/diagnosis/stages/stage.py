"""What every stage offers to be diagnosed: its data, what they show, and predictions. It never changes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Protocol

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.motion_content import STANDS, comes_back, holds
from trunk_ros.data.noise import Noise
from trunk_ros.data.repeated_readings import coarseness
from trunk_ros.data.span import Span
from trunk_ros.data.surroundings import View, following
from trunk_ros.diagnosis.hypothesis import Hypothesis, hypothesis_of, payload_of
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.stages.side_by_side import Seen, alike
from trunk_ros.effects import effect
from trunk_ros.effects.effect import Now, borne
from trunk_ros.effects.moments import NOTHING, Payload
from trunk_ros.guards import SAME
from trunk_ros.levels import HALF
from trunk_ros.machine import CELLS
from trunk_ros.model import Model
from trunk_ros.recording.signal.encoder import count

STANDING = 12.0 * HALF**2  # times the mean power of an encoder's steps: half of one, where a joint stands


class Sight(Protocol):
    """What a stage is shown of the arm when it is to predict."""

    @property
    def views(self) -> tuple[View, ...]:
        """What is seen in each span."""

    @property
    def work(self) -> Work:
        """What predictions have cost so far."""

    def now(
        self, index: int, column: int, payload: Payload = NOTHING, rows: tuple[int, ...] | None = None
    ) -> Now:
        """The surroundings of a column in a span, or at some ``rows`` of its grid."""


class Stage(ABC):
    """Recordings of one stage of an arm, and the model that predicts them."""

    name: str
    joint_by_joint = True
    """Only hypotheses of the same joint are computed together."""
    whole: str = "the residual's power"
    """What that is of which the unexplained residual is a share."""
    ahead: float = 0.0
    """By how much [s] its own steps are ahead of what goes on between them."""
    least_rest: float | None = None
    """Share of the noise power above which a residual is more than noise; None: it goes by the noise."""

    def __init__(self, spans: Sequence[Span], model: Model, units: dict[str, str] | None = None):
        """``model``: the nominal one, with the effects it already has; ``units``: SI unit of joints that are
        not in rad.
        """
        self.joints = spans[0].joints
        self.units = units or {}
        self.model = model.for_joints(self.joints)
        here = self.model.only(self.joints)
        here.bound(self.name)  # refuses what goes by a joint that was not recorded
        self.known = hypothesis_of(here.effects, self.name, len(self.joints))
        """The effects that the model has already: what a finding adds to."""
        loaded = self.model.loaded_arm()
        without = loaded.payload - payload_of(self.known).own  # the hypothesis brings its own payload
        self.arm = replace(loaded, payload=without).only(self.joints)
        self._load(spans)
        self.steps = [self._stepped(c) for c in range(len(self.joints))]
        """Standard deviation of the steps of joints' own encoders; 0 where readings lie on no grid."""
        self.stands = [self._standing(c) for c in range(len(self.joints))]
        """Samples for which the reading of a joint stays the same, in the mean over the samples."""
        self.coarse = [self._coarseness(c) for c in range(len(self.joints))]
        """Noise that the steps of a joint's own sensor are at least."""

    def unit(self, column: int) -> str:
        """The SI unit of a joint's position."""
        return self.units.get(self.joints[column], "rad")

    def _load(self, spans: Sequence[Span]) -> None:
        self.views = tuple(self._view(span) for span in spans)
        """What is seen at the gearbox's angles."""
        steps = np.concatenate([np.diff(span.stamp) for span in spans])
        self.step = float(np.median(steps)) if len(steps) else 0.0
        """Usual time between two samples of the target [s]."""
        columns = range(len(self.joints))
        moving = {c for c in columns if any(np.ptp(s.source[:, c]) >= STANDS for s in spans)}
        self.resting = frozenset(columns) - moving
        """Columns whose input stands."""
        self.one_way = frozenset(c for c in moving if not any(comes_back(s.source[:, c]) for s in spans))
        """Columns that go on and never come back: nothing can be told of reversals or of time."""
        self.holding = frozenset(c for c in self.one_way if any(holds(s.source[:, c]) for s in spans))
        """Those of them that rest for long on their way, and show what creeps."""

    def over(self, spans: Sequence[Span]) -> Stage:
        """The same stage and sensors over other spans of the same arm."""
        other = copy(self)
        for name in ("_bears", "loads"):
            other.__dict__.pop(name, None)
        other._load(spans)
        return other

    @property
    def has_load(self) -> bool:
        """Whether the moment on the joints is known, computed or measured."""
        return self.arm.has_load or self.views[0].span.resistance is not None

    @property
    def load_recorded(self) -> bool:
        """Whether that moment is a recorded torque, in place of the weight."""
        known = self.views[0].span.resistance
        return known is not None and not known.weighs

    def bears(self, column: int) -> bool:
        """Whether a joint feels any load: one about a vertical axis does not."""
        return self._bears[column]

    @cached_property
    def loads(self) -> Array:
        """(joints,) N m that the joints bear."""
        seen = [[borne(view.load[:, c]) for c in range(len(self.joints))] for view in self.views]
        return np.asarray(np.max(seen, axis=0))

    @cached_property
    def _bears(self) -> list[bool]:
        sizes = [_size(each) for view in self.views for each in (view.load, view.lever)]
        for view in self.views:
            if len(view.span.grid) > CELLS:
                view.large.clear()  # whoever asks for them again has them made anew
        seen = np.array(sizes)
        return [bool(felt) for felt in (seen > SAME * seen.max()).any(axis=0)]

    def own_steps(self, column: int) -> float:
        """Standard deviation of the steps of a joint's own encoder, or of a coarse sensor."""
        return max(self.steps[column], self.coarse[column])

    def ratio(self, hypothesis: Hypothesis, column: int) -> float:
        """Joint angle per gearbox angle, as a hypothesis has it."""
        ratio = float(self.arm.ratio[column])
        for term in hypothesis.on(column):
            kind = effect(term.effect)
            ratio = kind.changed(ratio, term.own[column]) if kind.changes == "ratio" else ratio
        return ratio

    def resolution(self, hypothesis: Hypothesis, column: int) -> float:
        """Standard deviation of the gearbox encoder's steps on the target's side [rad], as its readings have
        them: an arm may be described with other ones, or with those of another arm.
        """
        step = max(view.span.counts[column] for view in self.views if view.span.counts is not None)
        return float(step / np.sqrt(12.0) * abs(self.ratio(hypothesis, column)))

    def resolutions(self, hypothesis: Hypothesis) -> tuple[float, ...]:
        """The same of each column."""
        return tuple(self.resolution(hypothesis, c) for c in range(len(self.joints)))

    @abstractmethod
    def predict(self, sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> Array:
        """(n,) prediction of a column at the measured rows of a span."""

    def predict_each(self, sight: Sight, index: int, pairs: Sequence[Seen]) -> list[Array]:
        """The same of several hypotheses, each of one joint and (n,)."""
        out: dict[int, Array] = {}
        most = max(CELLS // len(sight.views[index].span.grid), 1)
        for same in alike(pairs, self.joint_by_joint):
            for first in range(0, len(same), most):
                some = same[first : first + most]
                seen = self._predict_alike(sight, index, [pairs[k] for k in some])
                out |= zip(some, seen, strict=True)
        return [out[k] for k in range(len(pairs))]

    def _predict_alike(self, sight: Sight, index: int, pairs: Sequence[Seen]) -> Sequence[Array]:
        """The same of hypotheses that may be computed together."""
        return [self.predict(sight, index, hypothesis, column) for hypothesis, column in pairs]

    def swings(self, sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> Array:
        """(k,) sums of squares, over the samples of a column that count, of swings of which nothing but the
        readings says how far they go.
        """
        return np.empty(0)

    def seen(self, sight: Sight, hypothesis: Hypothesis) -> tuple[View, ...]:
        """What is seen with the angles and loads that a hypothesis predicts, where the stage has any; as it
        is where they are nearly the same.
        """
        return sight.views

    def free(self, sight: Sight, hypothesis: Hypothesis) -> tuple[View, ...]:
        """What effects see in a run that is not led by the target: what the hypothesis predicts of it, as far
        as they look at the target at all.
        """
        return sight.views

    def noises(self, found: list[Noise]) -> list[Noise]:
        """Noise (joints,) as it is estimated, at least what is known of the sensors."""
        return [replace(n, std=max(n.std, self.own_steps(c))) for c, n in enumerate(found)]

    def _view(self, span: Span) -> View:
        dt = np.diff(span.grid, prepend=span.grid[:1])
        return View(span, dt, self.arm, following(span.valid))

    def _readings(self, column: int) -> list[Array]:
        return [view.span.target[view.span.valid[:, column], column] for view in self.views]

    def _coarseness(self, column: int) -> float:
        seen = [(view.span.target[:, column], view.span.valid[:, column]) for view in self.views]
        return max(coarseness(target, valid) for target, valid in seen)

    def _standing(self, column: int) -> float:
        ends = [np.concatenate([[True], np.diff(r) != 0.0, [True]]) for r in self._readings(column) if len(r)]
        runs = np.concatenate([np.diff(np.flatnonzero(end)) for end in ends]) if ends else np.ones(1)
        return float(np.sum(runs**2) / np.sum(runs))

    def _stepped(self, column: int) -> float:
        steps = max(
            (count(readings) for readings in self._readings(column) if len(readings) > 1), default=0.0
        )
        return float(steps / np.sqrt(12.0))


def _size(signal: Array) -> Array:
    """(columns,) how large a signal (n, columns) is at most."""
    return np.asarray(np.maximum(signal.max(axis=0), -signal.min(axis=0)))
