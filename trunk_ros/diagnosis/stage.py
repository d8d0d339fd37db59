"""One stage of one or more recordings, with a model that predicts it joint by joint."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from copy import copy
from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.align import Span
from trunk_ros.diagnosis.data.motion_content import comes_back, is_wide, speed_tells
from trunk_ros.diagnosis.data.noise import Noise, differences_of, strides_within
from trunk_ros.diagnosis.data.repeated_readings import coarseness
from trunk_ros.diagnosis.data.surroundings import View, first, following
from trunk_ros.diagnosis.hypothesis import Explanation, explanation_of, payload_of
from trunk_ros.effects.effect import Now
from trunk_ros.model import Model
from trunk_ros.recording.signal.encoder import count
from trunk_ros.recording.signal.resample import SLOW
from trunk_ros.resistance import loads

LEAST = 50  # valid samples without which a joint cannot be judged
UNLOADED = 1e-6  # of the largest moment, below which a joint feels none
OFTEN = 0.02  # s between samples that show what lies between them


class Problem(ABC):
    """What a stage must offer to be diagnosed: predictions of one column, and weights from its noise."""

    stage: str
    units: dict[str, str]
    """SI unit of joints that are not in rad."""

    def __init__(self, spans: list[Span], model: Model, units: dict[str, str] | None = None):
        """``model``: the nominal one, with the effects it already has."""
        self.joints = spans[0].joints
        self.units = units or {}
        self.model = model.for_joints(self.joints)
        self.known = explanation_of(self.model.only(self.joints).effects, self.stage, len(self.joints))
        """The effects that the model has already: what a finding adds to."""
        loaded = self.model.loaded_arm()
        without = loaded.payload - payload_of(self.known)  # the explanation brings its own payload
        self.arm = replace(loaded, payload=without).only(self.joints)
        self.views = [self._view(span) for span in spans]
        self.noise: list[Noise] = []
        self.one_way = {c for c in range(len(self.joints)) if not self._comes_back(c)}
        """Columns that never come back: nothing can be told of reversals or of time."""
        self.wide: set[int] = set()
        """Columns that always move alike and show a wide loop: it hides what else varies with speed or
        time.
        """
        self.steps = [self._stepped(c) for c in range(len(self.joints))]
        """Standard deviation of the steps of joints' own encoders; 0 where readings lie on no grid."""
        self.stands = [self._standing(c) for c in range(len(self.joints))]
        """Samples for which the reading of a joint stays the same, in the mean."""
        self.coarse = [self._coarseness(c) for c in range(len(self.joints))]
        self._cache: dict[tuple[int, int, float, int | None], Now] = {}
        self._telling: dict[int, list[int]] = {}
        self.version = 0
        self.unexplained: dict[int, float] = {}
        """Squared unit-noise residual above the noise that the explanation at hand leaves, by column."""
        self.misfit: dict[int, float] = {}
        """The same of the nominal arm."""
        self.formed_misfit: dict[int, float] = {}
        """The same but for a ratio that was not known."""
        self._known = [[view.angles for view in self.views]]
        """The angles of all spans, by version."""
        self.look_again(self.known)
        self.estimate_noise(self.known)
        self.wide = {c for c in self.columns if self.step < SLOW and self._is_wide(c)}
        self.estimate_noise(self.known)

    @property
    def step(self) -> float:
        """Usual time between two samples of the target [s]."""
        steps = np.concatenate([np.diff(view.span.stamp) for view in self.views])
        return float(np.median(steps)) if len(steps) else 0.0

    @property
    def has_load(self) -> bool:
        """Whether the moment on the joints is known, computed or measured."""
        return self.arm.has_load or self.views[0].span.resistance is not None

    @property
    def columns(self) -> list[int]:
        """Columns that can be judged: enough valid samples."""
        return [c for c in range(len(self.joints)) if self.count(c) >= LEAST]

    def count(self, column: int) -> int:
        """Valid samples of a column."""
        return int(sum(view.span.valid[:, column].sum() for view in self.views))

    def rest(self, column: int) -> float:
        """Share of the noise power above which a residual is more than noise.

        Coloured or rarely sampled noise is known less well, and a joint that stands shows one step of an
        encoder, up to three times the steps' mean power.
        """
        known = 0.1 if self.noise[column].correlation == 0.0 and self.step < OFTEN else 0.6
        steps = np.hypot(self.own_steps(column), self.resolution(column)) / self.noise[column].std
        return known + 2.0 * float(steps) ** 2

    def bears(self, column: int) -> bool:
        """Whether a joint feels any load: one about a vertical axis does not."""
        size = max(float(np.abs(each).max()) for view in self.views for each in (view.load, view.lever))
        own = [each[:, column] for view in self.views for each in (view.load, view.lever)]
        return any(np.abs(each).max() > UNLOADED * size for each in own)

    def own_steps(self, column: int) -> float:
        """Standard deviation of the steps of a joint's own encoder, or of a coarse sensor."""
        return max(self.steps[column], self.coarse[column])

    def resolution(self, column: int) -> float:
        """Standard deviation of the gearbox encoder's steps, told or seen, on the target's side [rad]."""
        seen = [view.span.counts[column] for view in self.views if view.span.counts is not None]
        step = max([2 * np.pi / self.arm.counts_per_rev, *seen])
        return float(step / np.sqrt(12.0) * abs(self.arm.ratio[column]))

    def _view(self, span: Span) -> View:
        angles = self.arm.driven(span.gearbox)
        speeds = span.velocity * self.arm.ratio
        dt = np.diff(span.grid, prepend=span.grid[:1])
        load, lever = loads(self.arm, angles, span.resistance)
        if self.arm.coupling is not None:
            load, lever = self.arm.carried(load), self.arm.carried(lever)
        return View(span, dt, angles, load, lever, angles, speeds, following(span.valid))

    def now(self, index: int, column: int, payload: float, steps: int | None = None) -> Now:
        """The surroundings of a column in a span, or in its first ``steps``, kept between calls."""
        key = (index, column, payload, steps)
        if key not in self._cache:
            if steps is None:
                made = self.views[index].now(self.arm, column, payload)
            else:
                made = first(self.now(index, column, payload), steps)
            if len(self._cache) > 8 * len(self.joints) * len(self.views):
                self._cache.clear()
            self._cache[key] = made
        return self._cache[key]

    def forget(self) -> None:
        """Surroundings have changed."""
        self._cache.clear()

    @abstractmethod
    def predict(self, index: int, explanation: Explanation, column: int) -> Array:
        """(n,) prediction of a column at the measured rows of a span."""

    def residual(self, index: int, explanation: Explanation, column: int) -> Array:
        """(n,) measured less predicted, 0 where nothing counts."""
        span = self.views[index].span
        off = span.target[:, column] - self.predict(index, explanation, column)
        return np.where(span.valid[:, column], off, 0.0)

    def whitened(self, explanation: Explanation, column: int) -> Array:
        """Residuals of a column over all spans, as unit noise, (rows,)."""
        parts = []
        for index, view in enumerate(self.views):
            white = self.noise[column].whiten(
                self.residual(index, explanation, column), view.follows[:, column]
            )
            parts.append(white[view.span.valid[:, column]])
        return np.concatenate(parts)

    def whiten_change(self, changes: list[Array], column: int) -> Array:
        """A change of the prediction (per span, (n,)) in the same units as ``whitened``."""
        parts = []
        for view, change in zip(self.views, changes, strict=True):
            valid = view.span.valid[:, column]
            white = self.noise[column].whiten(np.where(valid, change, 0.0), view.follows[:, column])
            parts.append(white[valid])
        return np.concatenate(parts)

    def predictions(self, explanation: Explanation, column: int) -> list[Array]:
        """Predictions of a column, one (n,) a span."""
        return [self.predict(index, explanation, column) for index in range(len(self.views))]

    def over(self, spans: list[Span]) -> Problem:
        """The same stage with the same noise over other spans of the same arm."""
        other = copy(self)
        other.views = [self._view(span) for span in spans]
        other.unexplained, other._cache, other._telling = {}, {}, {}
        other._known = [[view.angles for view in other.views]]
        return other

    def estimate_noise(self, explanation: Explanation) -> None:
        """Take the noise from what an explanation leaves: a size for each joint, one colour for all, as the
        joints' sensors are alike and some joints may have more than noise left.
        """
        longest = strides_within(self.step)
        seen = []
        for column in range(len(self.joints)):
            residuals = [self.residual(i, explanation, column) for i in range(len(self.views))]
            masks = [view.span.valid[:, column] for view in self.views]
            strides = 1 if column in self.formed else longest
            seen.append(differences_of(residuals, masks, strides, self.steps[column]))
        judged = [s.correlation for c, s in enumerate(seen) if len(s.strides) > 1 and self.count(c) >= LEAST]
        colour = float(np.median(judged)) if judged else 0.0
        found = [s.noise(colour if len(s.strides) > 1 else 0.0) for s in seen]
        least = [self.own_steps(column) for column in range(len(self.joints))]
        self.noise = [replace(n, std=max(n.std, c)) for n, c in zip(found, least, strict=True)]

    @property
    def formed(self) -> set[int]:
        """Columns whose residual is smooth by its form and not by the colour of noise."""
        return self.wide | self.one_way

    @property
    def speed_tells(self) -> bool:
        """Whether effects of speed and of holds can be seen: not in wide loops, nor where nothing is known
        of what lies between two samples.
        """
        return self.step < SLOW and not set(self.columns) <= self.wide

    def telling(self, column: int) -> list[int]:
        """The spans in which a column counts, the one with most to explain first."""
        if len(self.views) == 1:
            return [0]
        if column not in self._telling:
            left = [float(np.sum(self.residual(k, self.known, column) ** 2)) for k in range(len(self.views))]
            order = np.argsort(-np.array(left), kind="stable")
            self._telling[column] = [int(k) for k in order if left[k] > 0.0] or [0]
        return self._telling[column]

    def shown(self, column: int, index: int = 0) -> Now:
        """The surroundings of a column in a span; of a wide loop what counts, and of the gearbox's motion
        what comes through.
        """
        now, span = self.now(index, column, 0.0), self.views[index].span
        if column not in self.wide:
            return now
        valid = span.valid[:, column]
        return replace(
            now, gearbox=span.target[valid, column : column + 1] / now.ratio, stamp=span.stamp[valid]
        )

    def shows(self, tells: Callable[[Now], bool], column: int) -> bool:
        """Whether the motion of a column in one of the spans tells something."""
        return any(
            tells(self.now(index, column, 0.0)) and tells(self.shown(column, index))
            for index in self.telling(column)
        )

    def _comes_back(self, column: int) -> bool:
        return any(comes_back(view.span.source[:, column]) for view in self.views)

    def _is_wide(self, column: int) -> bool:
        position, speed, residual = (np.concatenate(parts) for parts in zip(*self._seen(column), strict=True))
        return is_wide(position, speed, residual) and not speed_tells(position, speed)

    def _seen(self, column: int) -> list[tuple[Array, Array, Array]]:
        """Gearbox angle, speed and what no effect explains (n,) where a column counts, by span."""
        out = []
        for index, view in enumerate(self.views):
            now, valid = self.now(index, column, 0.0), view.span.valid[:, column]
            rows = view.span.rows[valid]
            residual = self.residual(index, Explanation(), column)[valid]
            out.append((now.gearbox[rows, 0], now.speed[rows, 0], residual))
        return out

    def _coarseness(self, column: int) -> float:
        """Noise that the steps of the joint's own sensor are at least."""
        seen = [(view.span.target[:, column], view.span.valid[:, column]) for view in self.views]
        return max(coarseness(target, valid) for target, valid in seen)

    def _standing(self, column: int) -> float:
        seen = [view.span.target[view.span.valid[:, column], column] for view in self.views]
        changes = sum(int(np.count_nonzero(np.diff(readings))) for readings in seen)
        return sum(len(readings) for readings in seen) / (1 + changes)

    def _stepped(self, column: int) -> float:
        seen = [view.span.target[view.span.valid[:, column], column] for view in self.views]
        steps = max((count(readings) for readings in seen if len(readings) > 1), default=0.0)
        return float(steps / np.sqrt(12.0))

    def look_again(self, explanation: Explanation) -> None:
        """Let coupling and load see the angles that an explanation predicts, where the stage has any."""
        return None
