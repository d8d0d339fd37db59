"""How moves are tried: each yields groups of trials; the best of the first group that pays is taken."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import Candidate
from trunk_ros.diagnosis.search.fit import Fit, costed
from trunk_ros.diagnosis.search.hummed import told_from_hum
from trunk_ros.diagnosis.search.looked_again import relooked, renewed, told_from_clocks
from trunk_ros.diagnosis.search.score import BETTER, beats, score
from trunk_ros.diagnosis.search.screen import PROMISED, Kept
from trunk_ros.diagnosis.search.slow_noise import told_from_noise
from trunk_ros.diagnosis.search.state import describe, moments_of, state_of, structure
from trunk_ros.effects import effect
from trunk_ros.levels import HALF, HARDLY

LARGE = HALF  # of what is left: what explains so much of it, and much of all, comes before anything is mended
COARSE = (0.2, HARDLY, 0.0)  # of what is left: what a change has to gain then, later, and in the end


@dataclass(frozen=True)
class Group:
    """Trials that exclude each other: of ``what``, judged by what is on some ``columns``."""

    what: Hashable
    columns: Iterable[int]
    trials: Callable[[], Iterable[Fit]]
    promise: Callable[[], float] = lambda: np.inf
    """What the best of them may gain by a linear look, where that costs much less than they do."""


@dataclass(frozen=True)
class Move:
    """One kind of change. ``grows``: it explains something new, so that the arm is looked at again.
    ``cheap``: its trials are few, or on one joint. ``settles``: it finds out how an effect is what it is, and
    when. ``resort``: it waits until no other one gains much. ``descends``: its trials take steps of their
    own, which have to lead to another structure, and gain by what a step has to."""

    name: str
    groups: Callable[[Fit, Desk], Iterator[Group]]
    grows: bool = False
    resort: bool = False
    descends: bool = False
    cheap: bool = False
    settles: bool = False


def only(move: Move, *what: Hashable) -> Move:
    """A move on some things, such as an effect."""
    return _where(move, lambda thing: thing in what)


def of(move: Move, *names: str) -> Move:
    """A move on some effects, on any of their joints."""
    return _where(move, lambda thing: (thing[0] if isinstance(thing, tuple) else thing) in names)


def _where(move: Move, keeps: Callable[[Hashable], bool]) -> Move:
    return replace(move, groups=lambda best, desk: (g for g in move.groups(best, desk) if keeps(g.what)))


@dataclass
class Desk:
    """What a search remembers between moves: what was tried in vain, and in which state."""

    say: Callable[[str], None] = lambda _: None
    share: float = 0.0
    """Of what is left above the noise: what a change has to gain to be taken."""
    goal: float = np.inf
    """The score that a hypothesis has to come to in the end."""
    vain: dict[Hashable, float] = field(default_factory=dict)
    """By move, group and state: what its best trial gained there."""
    kept: set[Hashable] = field(default_factory=set)
    """What was tried once and for all."""
    tried: dict[Hashable, dict[tuple[str, bool], Any]] = field(default_factory=dict)
    """Effects that would help single columns, by all that this depends on."""
    kept_looks: dict[Hashable, Kept] = field(default_factory=dict)
    """By column and a state that is nearly the same: what looks at each effect found."""
    looked: dict[Hashable, list[Candidate]] = field(default_factory=dict)
    """Candidates on all joints together, by all that a look at them depends on."""
    been: dict[Hashable, Hypothesis] = field(default_factory=dict)
    """By structure: how the search last stood on it."""
    _trials: dict[Hashable, dict[Hashable, list[Fit]]] = field(default_factory=dict)
    _spare: tuple[Fit, Move, Fit] | None = None

    def is_vain(self, move: Move, group: Group, best: Fit) -> bool:
        """Whether a group was tried in a state that is nearly the same, and gained too little."""
        gain = self.vain.get(self._key(move, group, best))
        return gain is not None and not self.pays(gain, best)

    def note(self, move: Move, group: Group, best: Fit, gain: float) -> None:
        """A group was tried in vain: its best trial is better by no more than a ``gain``."""
        self.vain[self._key(move, group, best)] = gain

    def _key(self, move: Move, group: Group, best: Fit) -> Hashable:
        share = self.inner_share if move.descends else 0.0
        return (move.name, group.what, share, state_of(best, group.columns))

    def looks_at(self, best: Fit, column: int) -> Kept:
        """The looks at a column that are kept."""
        return self.kept_looks.setdefault((column, state_of(best, [column])), {})

    def trials_in(self, state: Hashable) -> dict[Hashable, list[Fit]]:
        """The trials on all joints that are kept in a state; those in another one are forgotten."""
        if state not in self._trials:
            self._trials = {state: {}}
        return self._trials[state]

    def stands_on(self, best: Fit) -> None:
        """The search has come to a structure."""
        self.been[structure(best.hypothesis), best.context.claims] = best.hypothesis

    def puts_aside(self, move: Move, trial: Fit, best: Fit) -> None:
        """A trial that is better, but not by enough as yet."""
        before = self._spare[2] if self._spare is not None and self._spare[0] is best else best
        if beats(trial, before) and _is_new(move, trial, best, self):
            self._spare = best, move, trial

    def put_aside(self, best: Fit) -> tuple[Move, Fit] | None:
        """The best of these, where the work ends before its turn would come."""
        return self._spare[1:] if self._spare is not None and self._spare[0] is best else None

    @property
    def inner_share(self) -> float:
        """What a step within a move has to gain of what is left: large things first."""
        return max(self.share, COARSE[1])

    def in_reach(self, group: Group, best: Fit) -> bool:
        """Whether a group would pay if it explained all that is left there, and all names were free."""
        left = sum(best.cost[c] - best.context.least_noise(c) for c in group.columns if c in best.cost)
        return self.pays(left + score(best) - best.total, best)

    def pays(self, gain: float, best: Fit) -> bool:
        """Whether a gain is worth a step: more than rounding, and large things first."""
        whole = COARSE[0] * sum(best.context.formed_misfit.values()) if self.share == LARGE else 0.0
        return gain > max(BETTER, self.share * sum(map(best.rest, best.cost)), whole)


def descend(best: Fit, moves: Sequence[Move], desk: Desk, steady: bool = False) -> Fit:
    """The best hypothesis that single changes lead to; after each the arm is looked at again. ``steady``:
    what is only noise that wanders is told from physics on the way.
    Changes that gain a small share of what is left wait until none gains more: what is still missing would
    make them anew, or make them up. So the largest effects come before anything is bent to do without them.
    """
    newest: list[str] = []
    stale = False
    for desk.share in (LARGE, *COARSE):
        now = [m for m in moves if _in_turn(m, desk.share)]
        best = told_from_hum(best, partial(desk.looks_at, best)) if steady else best
        best = told_from_noise(best, partial(desk.looks_at, best)) if steady else best
        best = told_from_clocks(best) if steady and desk.share == 0.0 else best
        while _is_large(best, desk.share):
            better = _next(best, _ordered(now, best, desk.share, newest), moves, desk)
            if better is None and best.context.work.over:
                better = desk.put_aside(best)
            if better is None and stale and not best.context.work.over:
                best, stale = renewed(best), False  # what was mended may have been most of the noise
                continue
            if better is None:
                break
            move, found = better
            desk.stands_on(found)
            best.context.work.finds(len(found.hypothesis) - len(best.context.known))
            if move.grows:
                newest = [name for name in found.hypothesis if name not in best.hypothesis]
            best, stale = (renewed if move.grows else relooked)(found), not move.grows
            desk.say(f"so far {describe(best.hypothesis)}")
    return best


def _next(best: Fit, now: Sequence[Move], moves: Sequence[Move], desk: Desk) -> tuple[Move, Fit] | None:
    """The next change. While large things are missing, the better one of what is new and of what is there in
    another way: other options, or for a time.
    """
    found = first_that_pays(best, now, desk)
    if desk.share < COARSE[0]:
        return found
    theirs = [of(move, *best.hypothesis) for move in moves if move.settles]
    other = first_that_pays(best, theirs, desk)
    return min(filter(None, (found, other)), key=lambda step: score(step[1]), default=None)


def _ordered(moves: Sequence[Move], best: Fit, share: float, newest: list[str]) -> Sequence[Move]:
    """What explains more before all but cheap mends and how the ``newest`` effects are what they are, while
    more is left than formulas are off by.
    """
    much = sum(map(best.rest, best.cost)) > COARSE[1] * sum(best.context.formed_misfit.values())
    if share < COARSE[0] or not much:
        return moves
    cheap = [move for move in moves if move.cheap]
    settling = [of(move, *newest) for move in moves if move.settles]
    others = [move for move in moves if not move.cheap]
    return [*cheap, *settling, *sorted(others, key=lambda move: not move.grows)]


def _is_large(best: Fit, share: float) -> bool:
    """Whether a share of what is left may be more than noise; what any change gains always counts."""
    return share == 0.0 or any(best.beyond_noise(c) > 0.0 for c in best.cost)


def _in_turn(move: Move, share: float) -> bool:
    """Whether a move is tried where a change has to gain this share of what is left."""
    return move.grows and not move.resort if share == LARGE else not move.resort or share < COARSE[0]


def descend_with(
    best: Fit, moves: Sequence[Move], desk: Desk, goal: float = np.inf,
    lacks: Callable[[Fit], bool] = lambda _: True,
) -> Fit:  # fmt: skip
    """A few steps that have to follow a change before it is judged, in what was seen before, while it
    ``lacks`` something. What gains little is left to the search of ``desk``; what that tried in vain is not
    tried again, nor what by its promise would not bring the score to a ``goal``.
    """
    desk = Desk(share=desk.inner_share, goal=goal, vain=desk.vain)
    while lacks(best) and (better := first_that_pays(best, moves, desk)) is not None:
        best = better[1]
        desk.stands_on(best)
    return best


def first_that_pays(best: Fit, moves: Sequence[Move], desk: Desk) -> tuple[Move, Fit] | None:
    """The best trial of the first group that has one better than ``best``; None at the end."""
    for move in moves:
        for group in move.groups(best, desk):
            if best.context.work.over:
                return None
            if desk.is_vain(move, group, best) or not desk.in_reach(group, best):
                continue
            promised = group.promise()
            if not desk.pays(promised, best):
                desk.note(move, group, best, promised)
                continue
            saved = score(best) - best.total
            if best.total - max(promised - saved, 0.0) / PROMISED > desk.goal:
                continue
            trials = _as_many_as_may_be(group, best)
            found = min(trials, key=score, default=best)
            for trial in (_plainest(found, trials, best, desk), found):
                if desk.pays(score(best) - score(trial), best) and _is_new(move, trial, best, desk):
                    return move, trial
            desk.puts_aside(move, found, best)
            if not best.context.work.over:  # else not all was tried
                desk.note(move, group, best, score(best) - score(found))
    return None


def _as_many_as_may_be(group: Group, best: Fit) -> list[Fit]:
    """The trials of a group, or the first ones where the work that is granted ends before."""
    trials = []
    for trial in group.trials():
        trials.append(trial)
        if best.context.work.over:
            break
    return trials


def _plainest(found: Fit, trials: list[Fit], best: Fit, desk: Desk) -> Fit:
    """The best trial; one whose effect it includes, with a further one or without, or that comes and goes
    less, where that pays as well and what the best has more would not as a step of its own.
    """
    least = score(found)
    for other in sorted(trials, key=score):
        step = score(other) - least
        if (
            _includes(found, other)
            and not desk.pays(step, other)
            and desk.pays(score(best) - score(other), best)
        ):
            found = other
    return found


def _includes(fit: Fit, other: Fit) -> bool:
    """Whether a hypothesis has one effect in the place of what that includes in the other, which may have a
    further one beside it; or the same ones, some of which come and go.
    """
    names, theirs = fit.hypothesis.keys(), other.hypothesis.keys()
    more, less = names - theirs, theirs - names
    if not more and not less:
        return moments_of(other.hypothesis) < moments_of(fit.hypothesis)
    return len(more) == 1 and len(less) in (1, 2) and bool(less & {*effect(*more).replaces})


def _is_new(move: Move, trial: Fit, best: Fit, desk: Desk) -> bool:
    """Whether the search has not stood on a structure, or not as well: new noise could lead it in circles.
    What a change gains that ends where it began is what fits leave to each other.
    """
    there = structure(trial.hypothesis)
    if there == structure(best.hypothesis):
        return not move.descends
    before = desk.been.get((there, best.context.claims))
    return before is None or beats(trial, costed(trial.context, before))
