"""Forward selection of effects with full refits; each step is then revised until no single change pays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from trunk_ros.diagnosis.hypothesis import Explanation, Term, bind_column, describe
from trunk_ros.diagnosis.search import form as reform
from trunk_ros.diagnosis.search import restart as anew
from trunk_ros.diagnosis.search import revise
from trunk_ros.diagnosis.search import swap as exchange
from trunk_ros.diagnosis.search.candidates import extended, usable
from trunk_ros.diagnosis.search.fit import Fit, fit
from trunk_ros.diagnosis.search.score import SIGNIFICANT, formed_misfits, need, score
from trunk_ros.diagnosis.search.screen import Screen
from trunk_ros.diagnosis.stage import Problem
from trunk_ros.effects import Effect, effect

PROMISING = 4  # local candidates a joint that are refitted in full
PROMISING_EVERYWHERE = 2
NEAR_BEST = 0.6  # an effect takes a joint along if it explains this share of what the best one does there
ROUNDS = 8
MOST = 4  # local effects on one joint
EXPECTED = 0.3  # of its own size: what an effect on all joints must explain on a joint
UNTOLD = ("reversal", "hold", "time")  # by joints that never come back
MAJORITY = 0.6  # of the joints

Progress = Callable[[str], None]
Trials = dict[str, tuple[float, Fit]]


@dataclass
class Search:
    """A search over explanations of one stage."""

    problem: Problem
    say: Progress = lambda _: None
    tried: dict[tuple[object, ...], Trials] = field(default_factory=dict)
    settled: set[tuple[object, ...]] = field(default_factory=set)
    barred: set[tuple[str, int]] = field(default_factory=set)
    """Effects that a fit has moved, on a column, to where its motion cannot show them."""

    def run(self, start: Explanation | None = None) -> Fit:
        """The explanation that no single change improves by what is needed."""
        now = self.begin(start)
        for _ in range(ROUNDS):
            grown = self.grow(now) or anew.begun_anew(self, now) or exchange.unname(self, now)
            if grown is None:
                break
            now = self.settle(grown)
            self.say(describe(now.explanation))
        now = exchange.believed(self, now)
        return self.written(revise.bystanders(self, revise.slices(self, now)))

    def begin(self, start: Explanation | None = None) -> Fit:
        """What is known, fitted; all else is measured by what it leaves."""
        now = self.refit(start or self.problem.known)
        self.weigh(now)
        self.problem.misfit = dict(self.problem.unexplained)
        self.problem.formed_misfit = formed_misfits(self.problem, now.explanation)
        return now

    def written(self, now: Fit) -> Fit:
        """The same physics in the values that one would write down."""
        out = now.explanation.copy()
        for term in out.values():
            term.own = {c: effect(term.effect).plain(values) for c, values in term.own.items()}
        return Fit(out, now.cost)

    def refit(self, explanation: Explanation) -> Fit:
        """Fit joint by joint, or all at once where they share values; with an effect of load, in its own
        postures.
        """
        done = self._refit(explanation)
        if any(effect(name).everywhere and "load" in effect(name).needs for name in explanation):
            self.problem.look_again(done.explanation)
            done = self._refit(done.explanation)
        return done

    def _refit(self, explanation: Explanation) -> Fit:
        cost: dict[int, float] = {}
        for group in self.groups(explanation):
            done = fit(self.problem, explanation, group)
            explanation = done.explanation
            cost |= done.cost
        return Fit(explanation, cost)

    def groups(self, explanation: Explanation) -> list[list[int]]:
        """Columns that have to be fitted together: those that share values, and each of the others alone."""
        columns = self.problem.columns
        shared = {c for term in explanation.values() if set(term.shared) - term.given for c in term.columns}
        together = sorted(shared & set(columns))
        return ([together] if together else []) + [[c] for c in columns if c not in shared]

    def refit_column(self, now: Fit, explanation: Explanation, column: int, rival: Fit | None = None) -> Fit:
        """Fit one joint's own values, the rest as it is; given up where it cannot beat a ``rival``."""
        goal = np.inf if rival is None else self._goal(now, explanation, column, rival)
        trial = fit(self.problem, explanation, [column], goal)
        return Fit(trial.explanation, now.cost | trial.cost)

    def _goal(self, now: Fit, explanation: Explanation, column: int, rival: Fit) -> float:
        """What a joint's squared residuals have to come to for the score to be better than a rival's."""
        others = Fit(explanation, {c: cost for c, cost in now.cost.items() if c != column})
        return self.score(rival) - self.score(others)

    def weigh(self, now: Fit) -> None:
        """Note what an explanation leaves, which further effects are measured by."""
        self.problem.unexplained = {c: max(cost - self.problem.count(c), 0.0) for c, cost in now.cost.items()}

    def score(self, state: Fit) -> float:
        """Squared residuals and prices."""
        return score(self.problem, state)

    def settle(self, now: Fit) -> Fit:
        """Look again with the noise and the angles of this explanation, and revise it."""
        self.problem.look_again(now.explanation)
        self.problem.estimate_noise(now.explanation)
        now = self.refit(now.explanation)
        self.weigh(now)
        for change in (
            revise.moments,
            reform.forms,
            revise.members,
            reform.options,
            revise.members,
            revise.incredible,
            revise.sources,
            revise.drop,
            exchange.exchange,
            exchange.exchange_on_many,
            exchange.exchange_everywhere,
            revise.members,
            revise.incredible,
        ):
            now = change(self, now)
            self.problem.look_again(now.explanation)
        self.weigh(now)
        return now

    def grow(self, now: Fit) -> Fit | None:
        """The explanation with the effect that explains most of what is left, if that is enough."""
        trials = [*self.grow_local(now), *self.grow_everywhere(now)]
        best = min(trials, key=self.score, default=None)
        return best if best is not None and self.score(best) < self.score(now) else None

    def grow_local(self, now: Fit) -> list[Fit]:
        """For each local effect, the explanation with it on the joints where it is among the best."""
        tried: dict[str, dict[int, tuple[float, Fit]]] = {}
        for column in self.problem.columns:
            for name, trial in self.trials(now, column).items():
                tried.setdefault(name, {})[column] = trial
        best = {
            c: max((t[c][0] for t in tried.values() if c in t), default=0.0) for c in self.problem.columns
        }
        chosen = {
            name: {c: t[1] for c, t in by.items() if t[0] >= NEAR_BEST * best[c]}
            for name, by in tried.items()
        }
        return [self._merged(now, name, trials) for name, trials in chosen.items() if trials]

    def trials(self, now: Fit, column: int) -> Trials:
        """(gain, fit) of the effects that would help a column; kept while nothing that bears on it
        changes.
        """
        barred = frozenset(name for name, where in self.barred if where == column)
        key = (column, self.problem.version, self.problem.noise[column], now.explanation.key(column), barred)
        if key not in self.tried:
            self.tried[key] = self._try(now, column)
        return self.tried[key]

    def _try(self, now: Fit, column: int) -> Trials:
        if weight(now.explanation, column) >= MOST:
            return {}
        screen = Screen(self.problem, now.explanation, [column])
        wanted = need(self.problem, column)
        kinds = [k for k in self.local_kinds() if self.open(k.id, column, now.explanation)]
        tried: Trials = {}
        for candidate in screen.ranked(kinds, column, PROMISING):
            if candidate.gain < 0.5 * wanted:
                continue
            trial = self.refit_column(now, extended(self.problem, now.explanation, candidate), column, now)
            gain = self.score(now) - self.score(trial)
            known = tried[candidate.effect][0] if candidate.effect in tried else 0.0
            if gain > known and self.credible(trial.explanation, column):
                tried[candidate.effect] = gain, trial
        return tried

    def _merged(self, now: Fit, name: str, trials: dict[int, Fit]) -> Fit:
        """One explanation out of the fits of one effect on several joints."""
        out = now.explanation.copy()
        leader = trials[max(trials, key=lambda c: now.cost[c] - trials[c].cost[c])].explanation[name]
        term = out.setdefault(name, Term(name, leader.form, dict(leader.shared), given=leader.given))
        shared = dict(term.shared)
        for column, trial in trials.items():
            out.take(column, trial.explanation)
        out[name].shared = shared
        return self.refit(out) if shared else Fit(out, now.cost | {c: t.cost[c] for c, t in trials.items()})

    def grow_everywhere(self, now: Fit) -> list[Fit]:
        """Explanations with a further effect that acts on all joints alike."""
        kinds = [k for k in usable(self.problem) if k.everywhere and k.id not in now.explanation]
        if not kinds:
            return []
        screen = Screen(self.problem, now.explanation)
        found = [c for k in kinds for c in screen.all_everywhere(k) if c.gain > SIGNIFICANT]
        most = PROMISING_EVERYWHERE if self.local_kinds() else len(found)  # a servo's lags hide each other
        promising = sorted(found, key=lambda c: -c.gain)[:most]
        trials = [
            revise.members(self, self.refit(extended(self.problem, now.explanation, c))) for c in promising
        ]
        return [
            trial
            for c, trial in zip(promising, trials, strict=True)
            if self.shared_by_most(now, trial, c.effect) and self.believable(trial.explanation, c.effect)
        ]

    def shared_by_most(self, now: Fit, trial: Fit, name: str) -> bool:
        """Whether an effect on all joints explains what it should on most of those that it moves."""
        sides = []
        for column in trial.explanation[name].columns:
            less = trial.explanation.without(name)
            changes = zip(
                self.problem.predictions(trial.explanation, column),
                self.problem.predictions(less, column),
                strict=True,
            )
            moved = self.problem.whiten_change([a - b for a, b in changes], column)
            size = float(moved @ moved)
            if size > need(self.problem, column):
                gain = now.cost[column] - trial.cost[column]
                left = now.cost[column] - self.problem.count(column)
                sides.append(gain > EXPECTED * size or gain > MAJORITY * left)
        return sum(sides) > MAJORITY * len(sides)

    def believable(self, explanation: Explanation, name: str) -> bool:
        """Whether an effect that acts on all joints is within what their motions can show."""
        return all(self.credible(explanation, c) for c in explanation[name].columns)

    def credible(self, explanation: Explanation, column: int) -> bool:
        """Whether all effects on a joint are within what its motion can show."""
        blocks = explanation.bound(column)
        there = {"", *(block.id for block in blocks)}
        placed = column not in self.problem.wide or {block.beyond for block in blocks} <= there
        return placed and all(self.shows(explanation, block, column) for block in blocks)

    def shows(self, explanation: Explanation, block: Effect, column: int) -> bool:
        """Whether an effect on a joint is within what its motion can show; less will do where another joint
        shows the same.
        """
        if self.problem.shows(block.credible, column):
            return True
        term = explanation[block.id]
        others = [c for c in term.columns if c in self.problem.columns and c != column]
        return self.problem.shows(block.plausible, column) and any(
            self.problem.shows(bind_column(term, c).credible, c) for c in others
        )

    def local_kinds(self) -> list[type[Effect]]:
        """Effects that a single joint may have."""
        return [k for k in usable(self.problem) if not k.everywhere]

    def open(self, name: str, column: int, explanation: Explanation) -> bool:
        """Whether an effect may be added on a column."""
        kind = effect(name)
        lost = kind.fine and column in self.problem.wide
        if (
            lost
            or (name, column) in self.barred
            or (kind.regime in UNTOLD and column in self.problem.one_way)
        ):
            return False
        if name in explanation and column in explanation[name].own:
            return 0 < len(explanation.get_words(name, column)) < len(kind.texts)
        return not any(name in effect(other).replaces for other in explanation)


def weight(explanation: Explanation, column: int) -> float:
    """How many effects a joint has of its own; beside a curve there is room for none."""
    own = [t for t in explanation.on(column) if not effect(t.effect).everywhere]
    return sum(1.0 if effect(t.effect).named else MOST for t in own)
