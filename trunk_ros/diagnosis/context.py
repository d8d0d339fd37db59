"""What a hypothesis is judged in: a stage, what is seen of the arm, the noise. A new look makes a new one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.data.louder import CONSTANT, Louder
from trunk_ros.data.noise import Noise, known_to, strides_within
from trunk_ros.data.noises import Rest, noises
from trunk_ros.data.seen import at, now_of
from trunk_ros.data.span import Span
from trunk_ros.data.surroundings import View
from trunk_ros.diagnosis.disturbances.thrown import rests, thrown
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.resources.work import Work, steps_of
from trunk_ros.diagnosis.stages.side_by_side import Seen
from trunk_ros.diagnosis.stages.stage import Stage
from trunk_ros.effects.effect import Motion, Now
from trunk_ros.effects.moments import NOTHING, Payload
from trunk_ros.levels import HARDLY
from trunk_ros.machine import CELLS, make_room
from trunk_ros.recording.signal.resample import SLOW

Key = tuple[int, int, Payload, tuple[int, ...] | None]
LEAST = 50  # valid samples without which a joint cannot be judged


@dataclass(frozen=True, eq=False)
class Context:
    """Everything that a prediction, a residual and a price depend on besides the hypothesis."""

    stage: Stage
    views: tuple[View, ...]
    noise: tuple[Noise, ...]
    resolution: tuple[float, ...] = ()  # std of gearbox encoders' steps at the joints, by the ratios found
    wide: frozenset[int] = frozenset()
    """Columns that always move alike and show a wide loop: it hides what else varies with speed or time."""
    alone: bool = False  # no joint is explained by what others do
    once: frozenset[int] = frozenset()
    """Columns that show a wide loop and go through none of it twice: what varies with time is in it."""
    look: int = 0  # counts the looks at the arm that differed from the one before
    louder: Louder = CONSTANT
    misfit: Mapping[int, float] = field(default_factory=dict)
    """Squared unit-noise residual above the noise that the nominal arm leaves, by column."""
    formed_misfit: Mapping[int, float] = field(default_factory=dict)
    """The same with the right zero, with the right ratio where that was not known, and but for a lag."""
    wanders: Mapping[int, Noise] = field(default_factory=dict)
    """The noise of columns that show nothing else than one that wanders."""
    claims: bool = False
    """Whether effects are weighed as what will be said, no more as steps on the way to it."""
    doubts: bool = False
    """Whether what a motion that never comes back cannot show is open all the same: it is as possible."""
    work: Work = field(default_factory=Work)
    shown_before: dict[tuple[object, ...], int] = field(default_factory=dict, repr=False)
    """What the motion was found to show, by column and what is on it."""
    likely: dict[bytes, tuple[Noise, float]] = field(default_factory=dict, repr=False)
    """The likeliest noise of what is left of a column, and how likely it is, by all that this depends on."""
    least_needs: dict[int, float] = field(default_factory=dict, init=False, repr=False)  # score's, by column
    off: dict[int, float] = field(default_factory=dict, init=False, repr=False)  # formed's, by column
    _cache: dict[Key, Now] = field(default_factory=dict, repr=False)

    # What the stage says.

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self.stage.joints

    @property
    def arm(self) -> Arm:
        """The arm of these joints, without the payload of a hypothesis."""
        return self.stage.arm

    @property
    def known(self) -> Hypothesis:
        """The effects that the model has already."""
        return self.stage.known

    @property
    def step(self) -> float:
        """Usual time between two samples of the target [s]."""
        return self.stage.step

    @property
    def together(self) -> int:
        """Predictions of a joint that are looked at together."""
        return max(CELLS // sum(len(view.span.grid) for view in self.views), 1)

    # Other contexts.

    def viewing(self, views: Sequence[View], anew: bool = False) -> Context:
        """With other views of the same spans, and nothing that was kept of these; ``anew``: another look."""
        return replace(self, views=tuple(views), look=self.look + anew, shown_before={}, _cache={})

    def seen_with(self, hypothesis: Hypothesis) -> Context:
        """With the angles that a hypothesis predicts, for coupling and load."""
        views = self.stage.seen(self, hypothesis)
        if views is self.views:
            return self
        pairs = zip(self.views, views, strict=True)
        same = all(old.apart(new.angles) < HARDLY * float(np.ptp(old.angles)) for old, new in pairs)
        return self.viewing(views, anew=not same)

    def weighed(self, hypothesis: Hypothesis) -> Context:
        """With the noise that a hypothesis leaves."""
        longest, rests = strides_within(self.step), []
        for c, step in enumerate(self.stage.steps):
            masks, strides = [v.span.valid[:, c] for v in self.views], 1 if c in self.formed else longest
            rests.append(Rest(self.evened(hypothesis, c), masks, strides, step, self.count(c) >= LEAST))
        found = noises(rests, [view.span.neighbours for view in self.views] if self.step >= SLOW else ())
        told = tuple(self.wanders.get(c, noise) for c, noise in enumerate(self.stage.noises(found)))
        return replace(self.in_noise(told), resolution=self.stage.resolutions(hypothesis))

    def in_noise(self, noise: Sequence[Noise]) -> Self:
        """With another noise, in units of which misfits then are."""
        shares = [(old.std / new.std) ** 2 for old, new in zip(self.noise or noise, noise, strict=True)]
        scaled = [{c: m * shares[c] for c, m in some.items()} for some in (self.misfit, self.formed_misfit)]
        return replace(self, noise=tuple(noise), misfit=scaled[0], formed_misfit=scaled[1], shown_before={})

    def over(self, spans: Sequence[Span]) -> Context:
        """The same noise over other spans of the same arm."""
        stage = self.stage.over(spans)
        return replace(self, stage=stage).viewing(stage.views)

    def only(self, rows: Sequence[np.ndarray]) -> Context:
        """The same with these rows (n,) of each span's target alone counting."""
        views = tuple(view.only(r) for view, r in zip(self.views, rows, strict=True))
        return replace(self, views=views, shown_before={})

    # What counts.

    @cached_property
    def columns(self) -> list[int]:
        """Columns that can be judged: enough valid samples."""
        return [c for c in range(len(self.joints)) if self.count(c) >= LEAST]

    def judged(self, term: Term) -> list[int]:
        """Columns of a term that can be judged."""
        return [c for c in term.columns if c in self.columns]

    @cached_property
    def _counts(self) -> list[int]:
        return [int(n) for n in np.sum([view.span.valid.sum(axis=0) for view in self.views], axis=0)]

    def count(self, column: int) -> int:
        """Valid samples of a column."""
        return self._counts[column]

    def rest(self, column: int) -> float:
        """Share of the noise power above which a residual is no noise; a joint at rest shows one step."""
        if self.stage.least_rest is not None:
            return self.stage.least_rest
        noise = self.noise[column]
        return known_to(noise, self.count(column), self.step) + 2.0 * (self.steps(column) / noise.std) ** 2

    def steps(self, column: int) -> float:
        """Standard deviation of the steps of a joint's and its gearbox's encoders."""
        return float(np.hypot(self.stage.own_steps(column), self.resolution[column]))

    def least_noise(self, column: int) -> float:
        """Squared unit-noise residual of a column that is noise for sure: between stops it may be physics."""
        return max(1.0 - self.rest(column), 0.0) * self.count(column) if self.step < SLOW else 0.0

    def motion(self, column: int) -> Motion:
        """What a joint's motion is like."""
        stage, masses = self.stage, self.arm.has_load and self.arm.load_from == "weight"
        one_way, once = (column in those and not self.doubts for those in (stage.one_way, self.once))
        bears, wide = stage.has_load and stage.bears(column), column in self.wide
        return Motion(wide, one_way, once, masses, bears, column in stage.resting, column in stage.holding)

    def timed(self, column: int) -> bool:
        """Whether a column shows what varies with time: it comes back, through its loop more than once."""
        return column not in self.stage.one_way | self.once

    @property
    def formed(self) -> frozenset[int]:
        """Columns whose residual is smooth by its form and not by the colour of noise."""
        return self.wide | self.stage.one_way

    @property
    def speed_tells(self) -> bool:
        """Whether what speed and holds do can be seen: not in wide loops, nor between readings far apart."""
        return self.step < SLOW and not set(self.columns) <= self.wide

    # Predictions and residuals.

    def now(
        self, index: int, column: int, payload: Payload = NOTHING, rows: tuple[int, ...] | None = None
    ) -> Now:
        """The surroundings of a column in a span, or at some ``rows`` of its grid, kept between calls."""
        key = (index, column, payload, rows)
        if key not in self._cache:
            view, whole = self.views[index], None if rows is None else self.now(index, column, payload)
            made = now_of(view, self.arm, column, payload) if whole is None else at(whole, np.array(rows))
            alike = [k for k in self._cache if k[:2] == key[:2] and (k[3] is None) == (rows is None)]
            make_room(self._cache, len(view.span.grid), alike)
            self._cache[key] = made
        return self._cache[key]

    def forget(self) -> None:
        """Let go of what is known of the arm at all angles: it is made anew when it is asked for."""
        self._cache.clear()
        for view in self.views:
            view.large.clear()

    def predict(self, index: int, hypothesis: Hypothesis, column: int) -> Array:
        """(n,) prediction of a column at the measured rows of a span."""
        self.work.done += len(self.views[index].span.grid) * steps_of(hypothesis, column)
        return self.stage.predict(self, index, hypothesis, column)

    def predictions(self, hypothesis: Hypothesis, column: int) -> list[Array]:
        """Predictions of a column, one (n,) a span."""
        return [self.predict(index, hypothesis, column) for index in range(len(self.views))]

    def predictions_each(self, pairs: Sequence[Seen]) -> list[list[Array]]:
        """The same of several hypotheses, each of one joint, computed together where they differ in values
        alone.
        """
        out: list[list[Array]] = [[] for _ in pairs]
        for index, view in enumerate(self.views):
            self.work.done += len(view.span.grid) * sum(steps_of(*pair) for pair in pairs)
            for parts, seen in zip(out, self.stage.predict_each(self, index, pairs), strict=True):
                parts.append(seen)
        return out

    def residual(self, index: int, hypothesis: Hypothesis, column: int) -> Array:
        """(n,) measured less predicted, 0 where nothing counts."""
        return self._off(index, hypothesis, column, self.predict(index, hypothesis, column))

    def _off(self, index: int, hypothesis: Hypothesis, column: int, predicted: Array) -> Array:
        view = self.views[index]
        return view.columns[column].off(thrown(view, column, rests(view, hypothesis, column), predicted))

    def whitened(self, hypothesis: Hypothesis, column: int) -> Array:
        """Residuals of a column over all spans, as unit noise, (rows,)."""
        return self.whiten([self.residual(i, hypothesis, column) for i in range(len(self.views))], column)

    def whitened_each(self, pairs: Sequence[Seen]) -> list[Array]:
        """The same of several hypotheses, each of one joint."""
        return [
            self.whiten([self._off(i, hypothesis, column, p) for i, p in enumerate(each)], column)
            for (hypothesis, column), each in zip(pairs, self.predictions_each(pairs), strict=True)
        ]

    def evened(self, hypothesis: Hypothesis, column: int) -> list[Array]:
        """Residuals of a column, one (n,) a span, in the noise at rest, all but their zeros."""
        rests = [self.residual(index, hypothesis, column) for index in range(len(self.views))]
        zeros = [v.columns[column].middle(rest) for v, rest in zip(self.views, rests, strict=True)]
        return self.even(rests, column, zeros)

    def even(self, signals: list[Array], column: int, zeros: Sequence[Array | None] = ()) -> list[Array]:
        """Signals (per span, (n,)) in the measure of the noise at rest, all but their ``zeros``."""
        even, zeros = self.louder.evened, zeros or [None] * len(signals)
        each = [(view.columns[column].speed, column, view.span.loud) for view in self.views]
        return [even(s, *loud, zero) for s, loud, zero in zip(signals, each, zeros, strict=True)]

    def whiten_change(self, changes: list[Array], column: int) -> Array:
        """A change of the prediction (per span, (n,)) in the same units as ``whitened``."""
        pairs = zip(self.views, changes, strict=True)
        seen = [np.where(view.columns[column].valid, change, 0.0) for view, change in pairs]
        return self.whiten(seen, column)

    def whiten(self, signals: list[Array], column: int) -> Array:
        """Signals (per span, (n,)) that are 0 where nothing counts, as independent unit noise, (rows,)."""
        whiten, seen = self.noise[column].whiten, [view.columns[column] for view in self.views]
        pairs = zip(seen, self.even(signals, column), strict=True)
        parts = [one.those(whiten(even, one.follows)) for one, even in pairs]
        return np.concatenate(parts) if len(parts) > 1 else parts[0]

    # What the motion shows.

    def telling(self, column: int) -> list[int]:
        """The spans in which a column counts, the one with most to explain first."""
        if len(self.views) == 1:
            return [0]
        off = [self.residual(k, self.known, column) for k in range(len(self.views))]
        seen = [view.columns[column].those(rest) for view, rest in zip(self.views, off, strict=True)]
        left = [float(np.sum((rest - np.median(np.concatenate(seen))) ** 2)) for rest in seen]
        return [k for k in sorted(range(len(left)), key=lambda k: -left[k]) if left[k] > 0.0] or [0]

    def shown(self, column: int, index: int = 0) -> Now:
        """Surroundings of a column in a span; of a wide loop what counts, and motion that comes through."""
        now, span = self.now(index, column), self.views[index].span
        if column not in self.wide:
            return now
        valid = span.valid[:, column]
        came = span.target[valid, column : column + 1] / now.ratio
        return replace(at(now, span.rows[valid]), gearbox=came)

    def shows(self, tells: Callable[[Now], bool], column: int) -> bool:
        """Whether the motion of a column in one of the spans tells something."""
        spans = range(len(self.views))
        return any(tells(self.now(index, column)) and tells(self.shown(column, index)) for index in spans)
