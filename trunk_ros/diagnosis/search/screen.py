"""A cheap first look at how much each effect would explain, and with which values it may start."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.search.candidates import Candidate, extended, given, plain_forms, taken
from trunk_ros.diagnosis.search.credible import unshown
from trunk_ros.diagnosis.search.followed import directions
from trunk_ros.diagnosis.search.score import FURTHER, chance, may_be_for_a_time, need
from trunk_ros.diagnosis.search.size import different, merit, reach, scaled, too_large
from trunk_ros.diagnosis.search.starts import Starts, whens
from trunk_ros.diagnosis.search.windows import Prices, Reach, Window, best_course, best_window
from trunk_ros.diagnosis.stages.side_by_side import Seen
from trunk_ros.effects import Effect, effect
from trunk_ros.guards import ROUNDED
from trunk_ros.levels import HALF, NEARLY
from trunk_ros.parameter import leading

PROMISED = HALF  # of what a fit gains: a linear look does not see all of it

Products = dict[int, tuple[float, float]]
"""By column: (rest . d, d . d) of a change d of the prediction."""

Kept = dict[Hashable, list[Candidate]]
"""By effect, the forms it may have and what it shares with other joints: promising starts on a column."""


class Screen:
    """What is left of each column, with the directions already fitted projected out."""

    def __init__(self, context: Context, hypothesis: Hypothesis, columns: list[int] | None = None):
        self.context, self.hypothesis = context, hypothesis
        columns = context.columns if columns is None else columns
        self.rest = {c: context.whitened(hypothesis, c) for c in columns}
        self.basis, self._shared = directions(context, hypothesis, columns)
        self.starts = Starts(context, hypothesis, columns)
        self.unshown = unshown(context, hypothesis)

    def left(self, column: int) -> float:
        """Squared residual of a column once the values that are there have followed, linearly."""
        rest, q = self.rest[column], self.basis[column]
        return float(rest @ rest - np.sum((q.T @ rest) ** 2))

    def seen(self, there: Hypothesis | None = None) -> float:
        """Squared unit noise that values of each joint explain once they have followed, or so much of the way
        to another hypothesis as explains most.
        """
        own = sum(float(r @ r) - self.left(c) for c, r in self.rest.items())
        if there is None:
            return own
        looks = [self._look(self.change(there, c), c) for c in self.rest]
        rd, dd = np.sum(looks, axis=0)
        return own + float(max(rd, 0.0) ** 2 / max(dd, ROUNDED))

    def may_come_to(self, there: Hypothesis, gain: float) -> float:
        """Squared residual of all columns at another hypothesis, by a linear look: all values follow, shared
        ones too, and the fit sees as much again as the look does, or as its ``gain`` on single joints.
        """
        changes = {c: self.change(there, c) for c in self.rest}
        changes = {c: self.beyond_values(d, c) for c, d in changes.items()}
        rd = sum(float(self.rest[c] @ d) for c, d in changes.items())
        dd = sum(float(d @ d) for d in changes.values())
        left = sum(map(self.left, self.rest))
        if any(s.size for s in self._shared.values()):
            normal = sum((s.T @ s for s in self._shared.values()), np.zeros(()))
            along = sum((s.T @ self.rest[c] for c, s in self._shared.items()), np.zeros(()))
            across = sum((s.T @ changes[c] for c, s in self._shared.items()), np.zeros(()))
            step, bend = np.linalg.lstsq(normal, np.column_stack([along, across]), rcond=None)[0].T
            left, rd, dd = left - along @ step, rd - along @ bend, dd - across @ bend
        return float(left - max(gain, rd**2 / max(dd, ROUNDED)) / PROMISED)

    def products(self, candidates: Sequence[Candidate], columns: Sequence[int]) -> list[tuple[float, float]]:
        """(rest . d, d . d) of each candidate's change d of a column, as far as no fitted term follows."""
        there = [extended(self.context, self.hypothesis, candidate) for candidate in candidates]
        changes = self.changes([*zip(there, columns, strict=True)])
        return [self._look(*each) for each in zip(changes, columns, strict=True)]

    def beyond_values(self, d: Array, column: int) -> Array:
        """(rows,) of a column as far as the fitted values cannot follow it, linearly."""
        q = self.basis[column]
        return np.asarray(d - q @ (q.T @ d)) if q.size else d

    def _look(self, d: Array, column: int) -> tuple[float, float]:
        d = self.beyond_values(d, column)
        return float(self.rest[column] @ d), float(d @ d)

    def change(self, there: Hypothesis, column: int) -> Array:
        """(rows,) unit noise by which another hypothesis changes the prediction."""
        return next(self.changes([(there, column)]))

    def changes(self, there: Sequence[Seen]) -> Iterator[Array]:
        """The same of several hypotheses, each of one joint."""
        for k in range(0, len(there), most := self.context.together):
            some = there[k : k + most]
            for rest, (_, column) in zip(self.context.whitened_each(some), some, strict=True):
                yield self.rest[column] - rest

    def lasting(self, candidate: Candidate, columns: list[int]) -> Candidate | None:
        """A candidate with the time in which it gains most, or with the time at which its size changes; None
        where it acts all the time alike.
        """
        kind, context = effect(candidate.effect), self.context
        columns = [c for c in columns if context.timed(c)]
        if any(moment.name in candidate.start for moment in kind.moments()):
            return None
        if not kind.begins or len(context.views) > 1:
            return None
        there = extended(context, self.hypothesis, candidate)
        changes = {c: self.change(there, c) for c in columns if c in there[candidate.effect].own}
        timed = self._timed(candidate, changes)
        if timed is None or unshown(context, extended(context, self.hypothesis, timed)) <= self.unshown:
            return timed
        plain = self._timed(candidate, changes, once=True)
        if plain and unshown(context, extended(context, self.hypothesis, plain)) <= self.unshown:
            return plain  # what comes and goes more often gains more, but not while the joint moves
        return timed

    def _timed(self, candidate: Candidate, changes: dict[int, Array], once: bool = False) -> Candidate | None:
        """A candidate with the times and sizes at which ``changes`` gain most; ``once``: in one window."""
        kind, context = effect(candidate.effect), self.context
        window = self.window(changes, reach(kind, candidate), kind.grows, once)
        found = window and scaled(kind, candidate, window.rd, window.dd)
        if not window or not found or found.gain - window.price <= candidate.gain:
            return None
        if not may_be_for_a_time(context, {c: self.left(c) for c in changes}, found.gain / PROMISED):
            return None
        own = {c: {**start, **window.moments} for c, start in candidate.own.items()}
        return replace(found, start={**found.start, **window.moments}, own=own, free=True)

    def window(
        self, changes: dict[int, Array], within: Reach, grows: bool = False, once: bool = False
    ) -> Window | None:
        """The time in which changes (rows,) of the predictions of some columns gain most; None for all the
        time alike. ``grows``: it may do so little by little; ``once``: in one window only.
        """
        if not changes:
            return None
        view = self.context.views[0]
        seen = [
            (view.span.stamp[view.columns[c].counted], self.beyond_values(self.rest[c], c), d, self.basis[c])
            for c, d in changes.items()
        ]
        price = float(np.median([need(self.context, c) for c in changes]))
        value = FURTHER * float(np.mean([chance(self.context, c) for c in changes]))
        prices = Prices(price, value)
        if once:
            return best_window(seen, view.span.stamp, within, prices)
        return best_course(seen, view.span.stamp, within, prices, grows)

    def forms(self, kind: type[Effect], column: int) -> list[Candidate]:
        """The best start of each form that comes near the best one."""
        found = [c for c in (self.local_form(kind, form, column) for form in self._forms(kind, column)) if c]
        best = max((c.gain for c in found), default=0.0)
        near = [c for c in found if c.gain > NEARLY * best]
        some = [lasting for c in near if (lasting := self.lasting(c, [column])) is not None]
        return some if kind.everywhere else [*near, *some]

    def ranked(
        self,
        kinds: list[type[Effect]],
        column: int,
        most: int,
        always: Collection[str] = (),
        kept: Kept | None = None,
    ) -> list[Candidate]:
        """The most promising effects, as many that act all the time, since what comes and goes imitates much,
        and those of ``always``, each in its promising forms; what is ``kept`` is not looked at again.
        """
        kept = {} if kept is None else kept
        keys = {kind.id: self._key(kind, column) for kind in kinds}
        new = [kind for kind in kinds if keys[kind.id] not in kept]
        looked = each(self.context.work, lambda kind: self.forms(kind, column), new)
        kept |= zip((keys[kind.id] for kind in new), looked, strict=True)
        found = sorted(filter(None, map(kept.get, keys.values())), key=lambda f: -max(c.gain for c in f))
        steady = sorted((-c.gain, c.effect) for f in found for c in f if not c.lasts)
        named = [*dict.fromkeys(name for _, name in steady)][:most]
        further = [f for f in found[most:] if f[0].effect in {*named, *always}]
        return [candidate for forms in [*found[:most], *further] for candidate in forms]

    def _key(self, kind: type[Effect], column: int) -> Hashable:
        """What the starts of an effect depend on besides: what joints that have it already share, and when it
        acts on them.
        """
        shared = tuple(self.hypothesis[kind.id].shared.items()) if kind.id in self.hypothesis else ()
        forms = self._forms(kind, column)
        others = [w for form in forms for w in whens(self.hypothesis, kind, form, column)]
        return kind.id, forms, shared, tuple(tuple(when.items()) for when in others)

    def local_form(self, kind: type[Effect], form: str, column: int) -> Candidate | None:
        """The most promising start of an effect on one column; those that come near the best one are looked
        at again where that led them, as friction bends what a look takes for straight.
        """
        begun = [Candidate(kind.id, form, column, start) for start in self.starts.on(kind, form, column)]
        found = self._scaled(begun, column)
        most = max((c.gain for c in found), default=0.0)
        near = [c for c in found if c.gain > NEARLY * most]
        again = self._scaled(near, column) if len(near) > 1 else near
        return max(again or near, key=lambda c: c.gain, default=None)

    def _scaled(self, trials: list[Candidate], column: int) -> list[Candidate]:
        """Candidates on one column at their best sizes, but for what cannot help."""
        pairs = zip(trials, self.products(trials, [column] * len(trials)), strict=True)
        return [better for t, look in pairs if (better := scaled(effect(t.effect), t, *look))]

    def _forms(self, kind: type[Effect], column: int) -> tuple[str, ...]:
        """The forms to try: that of the effect on other joints, if it is there."""
        if kind.id in self.hypothesis:
            return (self.hypothesis[kind.id].form,)
        return plain_forms(kind, self.context, [column])

    def all_everywhere(
        self, kind: type[Effect], only: str | None = None, also: dict[str, float] | None = None
    ) -> list[Candidate]:
        """Promising starts of an effect that acts on all joints alike: with values that the arm's description
        states, and with values of each joint's own. ``only``: in one form; ``also``: start values of what is
        optional.
        """
        found: dict[tuple[bool, bool], Candidate] = {}
        for form in plain_forms(kind, self.context, self.context.columns) if only is None else (only,):
            for trial, looked in self._on_all(kind, form, also or {}):
                for free in self._freedoms(kind, form):
                    better = self._on_those_that_gain(kind, replace(trial, free=free), looked)
                    key = free, form != "" and form == kind.apart
                    if better and (key not in found or better.gain > found[key].gain):
                        found[key] = better
        some = [(apart, c) for (_, apart), c in found.items()]
        if any(p.shared for p in kind.moments()[:1]):
            some += [(apart, f) for apart, c in some if (f := self.lasting(c, self.context.columns))]
        shared = max((c.gain / NEARLY for apart, c in some if not apart), default=0.0)
        left = {c: PROMISED * (self.left(c) - self.context.count(c)) for c in self.context.columns}
        own = [c for apart, c in some if apart and c.gain > max(shared, sum(left[k] for k in c.columns))]
        return [*(c for apart, c in some if not apart), *own]  # others would be bent to what is missing

    def _freedoms(self, kind: type[Effect], form: str) -> tuple[bool, ...]:
        """Whether each joint begins at a size of its own: where one is stated, both ways are tried."""
        lead = leading(kind.own_parameters(form))
        if not kind.scalable or lead.shared:
            return (False,)
        return (False, True) if lead.name in given(kind, self.context) else (True,)

    def _on_all(
        self, kind: type[Effect], form: str, also: dict[str, float]
    ) -> Iterator[tuple[Candidate, Products]]:
        """Each choice of the shared values, with every joint's best choice of its own."""
        starts = {c: list(self.starts.on(kind, form, c)) for c in self.context.columns}
        names = [p.name for p in kind.own_parameters(form) if p.shared]
        shared = [{n: s[n] for n in names if n in s} | also for each in starts.values() for s in each]
        for values in different(shared):  # of all joints side by side
            options = {
                c: different([{n: v for n, v in s.items() if n not in names} | values for s in some])
                for c, some in starts.items()
            }
            trials = [Candidate(kind.id, form, c, s) for c, some in options.items() for s in some]
            looks = iter(self.products(trials, [c for c, some in options.items() for _ in some]))
            seen = {c: [(s, next(looks)) for s in some] for c, some in options.items()}
            best = {c: max(some, key=lambda one: merit(kind, form, *one[1])) for c, some in seen.items()}
            own = {c: start for c, (start, _) in best.items()}
            on_all = Candidate(kind.id, form, None, next(iter(own.values())), own=own)
            yield on_all, {c: look for c, (_, look) in best.items()}

    def _on_those_that_gain(self, kind: type[Effect], trial: Candidate, each: Products) -> Candidate | None:
        """On all joints; where a joint has values of its own, on those that a linear look finds better
        off.
        """
        each = {c: found for c, found in each.items() if not taken(kind, self.hypothesis, c)}
        if trial.free:
            return self._each_by_itself(kind, trial, each)
        if any(not p.shared for p in kind.own_parameters(trial.form)):
            size = too_large(list(each.values())) if kind.scalable else 1.0
            shared = leading(kind.own_parameters(trial.form)).shared
            each = {c: (rd, dd) for c, (rd, dd) in each.items() if 2 * rd > size * dd or shared}
        if not each:
            return None
        sums = np.sum(list(each.values()), axis=0)
        found = scaled(kind, trial, float(sums[0]), float(sums[1]), given(kind, self.context))
        if found is None:
            return None
        lead = leading(kind.own_parameters(trial.form)).name
        own = {c: {**s, lead: found.start[lead]} if kind.scalable else s for c, s in trial.own.items()}
        return replace(found, columns=tuple(each), own=own)

    def _each_by_itself(self, kind: type[Effect], trial: Candidate, each: Products) -> Candidate | None:
        """Every joint at its own optimum, where that is worth an effect."""
        found = {c: scaled(kind, replace(trial, start=trial.own[c]), *each[c]) for c in each}
        named = [c for c in found if c not in self.hypothesis.curved]
        chosen = {c: f for c in named if (f := found[c]) and f.gain > PROMISED * need(self.context, c)}
        if not chosen:
            return None
        own = {c: f.start for c, f in chosen.items()}
        gain = sum(f.gain for f in chosen.values())
        return replace(trial, start=next(iter(own.values())), gain=gain, columns=tuple(chosen), own=own)
