"""Forward selection of effects with refits, then elimination, exchange and other forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from trunk_ros.diagnosis.candidates import Candidate, Screen, extended, given, usable
from trunk_ros.diagnosis.explanation import Explanation, Term, describe
from trunk_ros.diagnosis.fit import Fit, fit
from trunk_ros.diagnosis.problem import Problem
from trunk_ros.diagnosis.unnamed import UNKNOWN, curve_fit
from trunk_ros.effects import effect
from trunk_ros.parameter import Parameter

SIGNIFICANT = (
    40.0  # gain in squared unit-noise residuals below which chance and small misfits are not ruled out
)
RELEVANT = 0.012  # share of the noise power that an effect must remove from a joint
PROMISING = 4  # local candidates a joint that are refitted in full
PROMISING_EVERYWHERE = 2
NEAR_BEST = 0.6  # an effect takes a joint along if it explains this share of what the best one does there
ROUNDS = 10
MOST = 4  # local effects on one joint
REST = 0.1  # of the noise power: a rest that a curve is tried on
CLEARER = 0.02  # of the misfit: what a curve must explain beyond the named effects to take their place
FEWER = 40.0  # loss at which one shared value in place of several own ones is still preferred

Progress = Callable[[str], None]


Trials = dict[str, tuple[float, Fit]]


@dataclass
class Search:
    """A search over explanations of one stage."""

    problem: Problem
    say: Progress = lambda _: None
    _tried: dict[tuple[object, ...], Trials] = field(default_factory=dict)
    _settled: set[tuple[object, ...]] = field(default_factory=set)

    def need(self, column: int) -> float:
        """The gain on a column below which nothing is claimed."""
        return max(SIGNIFICANT, RELEVANT * self.problem.count(column))

    def run(self, start: Explanation | None = None) -> Explanation:
        """The explanation that no single change improves by what is needed."""
        now = self.refit(start or Explanation())
        for _ in range(ROUNDS):
            grown = self.grow(now)
            if grown is None:
                break
            now = self.settle(grown)
            self.say(describe(now.explanation))
        return self.settle(now).explanation

    def refit(self, explanation: Explanation) -> Fit:
        """Fit joint by joint, or all joints at once where they share values."""
        problem = self.problem
        shared = {c for term in explanation.values() if _has_shared(term) for c in term.columns}
        together = sorted(shared & set(problem.columns))
        cost: dict[int, float] = {}
        groups = ([together] if together else []) + [[c] for c in problem.columns if c not in shared]
        for group in groups:
            done = fit(problem, explanation, group)
            explanation = done.explanation
            cost |= done.cost
        return Fit(explanation, cost, [], np.zeros((0, 0)))

    def settle(self, now: Fit) -> Fit:
        """Look again with the noise and the angles of this explanation; try forms, options, drops and exchanges."""
        self.problem.look_again(now.explanation)
        self.problem.estimate_noise(now.explanation)
        now = self.refit(now.explanation)
        now = self.options(self.forms(now))
        now = self.exchange(self.drop(now))
        return self.unname(self.exchange_everywhere(now))

    # -- one more effect ---------------------------------------------------------------------------------------------

    def grow(self, now: Fit) -> Fit | None:
        """The explanation with the effect that explains most of what is left, if that is enough."""
        trials = [*self.grow_local(now), *self.grow_everywhere(now)]
        if not trials:
            return None
        return max(trials, key=lambda pair: pair[0])[1]

    def grow_local(self, now: Fit) -> list[tuple[float, Fit]]:
        """(gain beyond need, fit) for each local effect on the joints where it is among the best."""
        tried: dict[str, dict[int, tuple[float, Fit]]] = {}
        for column in self.problem.columns:
            for name, trial in self.trials(now, column).items():
                tried.setdefault(name, {})[column] = trial
        best = {
            c: max((t[c][0] for t in tried.values() if c in t), default=0.0) for c in self.problem.columns
        }
        return [
            self._merged(now, name, {c: t for c, t in trials.items() if t[0] >= NEAR_BEST * best[c]})
            for name, trials in tried.items()
            if any(t[0] >= NEAR_BEST * best[c] for c, t in trials.items())
        ]

    def trials(self, now: Fit, column: int) -> Trials:
        """(gain, fit) of the effects that would help a column; kept while nothing that bears on it changes."""
        key = (column, self.problem.version, now.explanation.key(column))
        if key not in self._tried:
            self._tried[key] = self._try(now, column)
        return self._tried[key]

    def _try(self, now: Fit, column: int) -> Trials:
        on = [t for t in now.explanation.on(column) if not effect(t.effect).everywhere]
        if len(on) >= MOST:
            return {}
        screen = Screen(self.problem, now.explanation, [column])
        kinds = [k for k in usable(self.problem) if not k.everywhere]
        found = [screen.local(k, column) for k in kinds if self._open(k.id, column, now.explanation)]
        promising = sorted(
            (c for c in found if c and c.gain > 0.5 * self.need(column)), key=lambda c: -c.gain
        )
        tried: Trials = {}
        for candidate in promising[:PROMISING]:
            trial = fit(self.problem, extended(self.problem, now.explanation, candidate), [column])
            gain = now.cost[column] - trial.cost[column]
            if gain > self.need(column):
                tried[candidate.effect] = gain, trial
        return tried

    def _merged(self, now: Fit, name: str, trials: dict[int, tuple[float, Fit]]) -> tuple[float, Fit]:
        """One explanation out of the fits of one effect on several joints."""
        out = now.explanation.copy()
        leader = max(trials, key=lambda c: trials[c][0])
        form = trials[leader][1].explanation[name].form
        out.setdefault(name, Term(name, form))
        for column, (_, trial) in trials.items():
            out.take(column, trial.explanation)
        joined = out[name]
        joined.shared = dict(
            now.explanation[name].shared
            if name in now.explanation
            else trials[leader][1].explanation[name].shared
        )
        cost = now.cost | {c: trial.cost[c] for c, (_, trial) in trials.items()}
        total = sum(gain - self.need(c) for c, (gain, _) in trials.items())
        return total, Fit(out, cost, [], np.zeros((0, 0)))

    def grow_everywhere(self, now: Fit) -> list[tuple[float, Fit]]:
        """(gain beyond need, fit) for the effects that act on all joints alike."""
        screen = Screen(self.problem, now.explanation)
        kinds = [k for k in usable(self.problem) if k.everywhere and k.id not in now.explanation]
        found = [c for c in (screen.everywhere(k) for k in kinds) if c]
        need = self.need_everywhere()
        promising = sorted((c for c in found if c.gain > 0.5 * need), key=lambda c: -c.gain)
        trials = []
        for candidate in promising[:PROMISING_EVERYWHERE]:
            trial = self.refit(extended(self.problem, now.explanation, candidate))
            gain = now.total - trial.total
            if gain > need:
                trials.append((gain - need, trial))
        return trials

    def need_everywhere(self) -> float:
        """The gain over all joints below which no effect on all of them is claimed."""
        return max(self.need(c) for c in self.problem.columns)

    def _open(self, name: str, column: int, explanation: Explanation) -> bool:
        """Whether an effect may be added on a column."""
        kind = effect(name)
        if name in explanation and column in explanation[name].own:
            return 0 < len(explanation.get_words(name, column)) < len(kind.texts)
        return not any(name in effect(other).replaces for other in explanation)

    # -- the same effects, otherwise ---------------------------------------------------------------------------------

    def forms(self, now: Fit) -> Fit:
        """The best form of each effect."""
        for name in list(now.explanation):
            for form in effect(name).forms:
                if form != now.explanation[name].form and name in now.explanation:
                    trial = self._reformed(now, name, form)
                    if trial is not None and trial.total < now.total - 2.0:
                        now = trial
        return now

    def _reformed(self, now: Fit, name: str, form: str) -> Fit | None:
        """An effect in another form on the joints that it is on."""
        columns = now.explanation[name].columns
        bare = now.explanation.without(name)
        out = bare
        screen = Screen(self.problem, bare)
        for column in columns:
            candidate = screen.local_form(effect(name), form, column)
            if candidate is None:
                return None
            everywhere = effect(name).everywhere
            out = extended(
                self.problem, out, Candidate(name, form, None if everywhere else column, candidate.start)
            )
        return self.refit(out)

    def options(self, now: Fit) -> Fit:
        """Free what an effect may have besides: a payload, or what the arm's description states."""
        for name in list(now.explanation):
            term = now.explanation[name]
            kind = effect(name)
            for parameter in kind.own_parameters(term.form):
                if parameter.optional and parameter.shared:
                    now = self._with_or_without(now, name, parameter)
            known = given(kind, self.problem)
            if term.given & set(known):
                trial = now.explanation.copy()
                trial[name].given = frozenset()
                trial[name].shared.pop("payload", None)
                now = self._if_better(now, trial, SIGNIFICANT * len(term.columns))
        return now

    def _with_or_without(self, now: Fit, name: str, parameter: Parameter) -> Fit:
        trial = now.explanation.copy()
        if parameter.name not in now.explanation[name].shared:
            trial[name].shared[parameter.name] = parameter.typical
            return self._if_better(now, trial)
        del trial[name].shared[parameter.name]
        return self._if_better(now, trial, -self.need_everywhere())

    def _if_better(self, now: Fit, trial: Explanation, need: float | None = None) -> Fit:
        fitted = self.refit(trial)
        return (
            fitted if now.total - fitted.total > (self.need_everywhere() if need is None else need) else now
        )

    # -- fewer, or others --------------------------------------------------------------------------------------------

    def drop(self, now: Fit) -> Fit:
        """Leave out, one at a time, what is not missed."""
        while True:
            best: tuple[float, Fit] | None = None
            for name, column in self._droppable(now.explanation):
                trial = self._dropped(now, name, column)
                loss = trial.total - now.total
                need = self.need_everywhere() if column is None else self.need(column)
                if loss < need and (best is None or loss - need < best[0]):
                    best = loss - need, trial
            if best is None:
                return now
            now = best[1]

    def _droppable(self, explanation: Explanation) -> list[tuple[str, int | None]]:
        return [
            (t.effect, c)
            for t in explanation.values()
            for c in ([None] if effect(t.effect).everywhere else t.columns)
        ]

    def _dropped(self, now: Fit, name: str, column: int | None) -> Fit:
        less = now.explanation.without(name, column)
        if column is None:
            return self.refit(less)
        trial = fit(self.problem, less, [column])
        return Fit(trial.explanation, now.cost | trial.cost, [], np.zeros((0, 0)))

    def exchange(self, now: Fit) -> Fit:
        """Replace one or two effects of a joint by one that explains the joint better."""
        for column in self.problem.columns:
            key = (column, self.problem.version, now.explanation.key(column))
            if key in self._settled:
                continue
            local = [t.effect for t in now.explanation.on(column) if not effect(t.effect).everywhere]
            for gone in [(a,) for a in local] + [(a, b) for i, a in enumerate(local) for b in local[i + 1 :]]:
                if all(name in now.explanation and column in now.explanation[name].own for name in gone):
                    now = self._exchanged(now, column, gone)
            self._settled.add((column, self.problem.version, now.explanation.key(column)))
        return now

    def exchange_everywhere(self, now: Fit) -> Fit:
        """Replace an effect that is on all joints, by itself or joint by joint, by another that acts on all alike."""
        for name in list(now.explanation):
            if name not in now.explanation or set(now.explanation[name].columns) < set(self.problem.columns):
                continue
            bare = now.explanation.without(name)
            screen = Screen(self.problem, bare)
            for kind in usable(self.problem):
                if kind.everywhere and kind.id not in now.explanation and kind.id != name:
                    now = self._better_everywhere(now, name, bare, screen.everywhere(kind))
        return now

    def _better_everywhere(self, now: Fit, name: str, bare: Explanation, candidate: Candidate | None) -> Fit:
        if candidate is None or name not in now.explanation:
            return now
        trial = self.options(self.refit(extended(self.problem, bare, candidate)))
        fewer = size(now.explanation, self.problem) - size(trial.explanation, self.problem)
        margin = FEWER if fewer > 0 else -FEWER if fewer < 0 else -3.0
        return trial if trial.total < now.total + margin else now

    def _exchanged(self, now: Fit, column: int, gone: tuple[str, ...]) -> Fit:
        bare = now.explanation
        for name in gone:
            bare = bare.without(name, column)
        screen = Screen(self.problem, bare, [column])
        kinds = [
            k
            for k in usable(self.problem)
            if not k.everywhere and k.id not in gone and self._open(k.id, column, bare)
        ]
        found = sorted((c for c in (screen.local(k, column) for k in kinds) if c), key=lambda c: -c.gain)
        spare = (len(gone) - 1) * self.need(column)
        for candidate in found[:PROMISING]:
            trial = fit(self.problem, extended(self.problem, bare, candidate), [column])
            if trial.cost[column] < now.cost[column] + spare - 3.0:
                now = Fit(trial.explanation, now.cost | trial.cost, [], np.zeros((0, 0)))
                spare = -3.0
        return now

    # -- no name at all ----------------------------------------------------------------------------------------------

    def unname(self, now: Fit) -> Fit:
        """Put a smooth curve in the place of several named effects, or of a rest, where that explains a joint better."""
        for column in self.problem.columns:
            key = ("unname", column, self.problem.version, now.explanation.key(column))
            if key not in self._settled:
                self._settled.add(key)
                now = self._unnamed(now, column)
        return now

    def _unnamed(self, now: Fit, column: int) -> Fit:
        local = [t.effect for t in now.explanation.on(column) if not effect(t.effect).everywhere]
        rest = now.cost[column] / self.problem.count(column) - 1.0
        if UNKNOWN in local or (len(local) < 2 and rest < REST):
            return now
        nominal = fit(self.problem, now.explanation.only_everywhere(column), [column]).cost[column]
        best = now
        for kept in [(), *((name,) for name in local)]:
            bare = now.explanation
            for name in local:
                bare = bare if name in kept else bare.without(name, column)
            trial = curve_fit(self.problem, bare, column)
            if trial is not None and self._score(trial, column) < self._score(best, column):
                best = trial
        gained = now.cost[column] - best.cost[column]
        simpler = len(local) >= 3 and best is not now
        if best is now or not (simpler or gained > CLEARER * (nominal - now.cost[column])):
            return now
        return Fit(best.explanation, now.cost | best.cost, [], np.zeros((0, 0)))

    def _score(self, state: Fit, column: int) -> float:
        """Squared residual with a price on every effect; a curve costs as much as three."""
        price = sum(3 if t.effect == UNKNOWN else 1 for t in state.explanation.on(column))
        return state.cost[column] + price * self.need(column)


def size(explanation: Explanation, problem: Problem) -> int:
    """How many numbers an explanation leaves to the fit."""
    return len(explanation.free(list(range(len(problem.joints)))))


def _has_shared(term: Term) -> bool:
    return any(name not in term.given for name in term.shared)
