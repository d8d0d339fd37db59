"""The effect that explains most of what is left, on all joints where it is among the best."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import chain
from typing import NamedTuple

from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.search.candidates import (
    Candidate,
    breaking_kinds,
    extended,
    kinds_of_all,
    local_kinds,
    open_kinds,
)
from trunk_ros.diagnosis.search.credible import hidden, unshown
from trunk_ros.diagnosis.search.descent import Desk, Group, Move, descend_with, of
from trunk_ros.diagnosis.search.fit import Fit, change, refit, refit_column
from trunk_ros.diagnosis.search.moves.drop import DROP
from trunk_ros.diagnosis.search.moves.event import EVENT
from trunk_ros.diagnosis.search.moves.member import MEMBER
from trunk_ros.diagnosis.search.moves.onset import dated
from trunk_ros.diagnosis.search.moves.option import OPTION
from trunk_ros.diagnosis.search.moves.spell import SPELL
from trunk_ros.diagnosis.search.moves.swap_all import SWAP_ALL, with_more, with_what_it_stood_for
from trunk_ros.diagnosis.search.moves.swap_many import SWAP_MANY
from trunk_ros.diagnosis.search.score import need, priced, score
from trunk_ros.diagnosis.search.screen import Kept, Screen
from trunk_ros.diagnosis.search.state import exactly
from trunk_ros.diagnosis.search.trial import column_trials, may_win, on_all_joints, refit_to_win
from trunk_ros.effects import Effect, effect
from trunk_ros.levels import MOST, REFITTED, SOME


class Tried(NamedTuple):
    """An effect on a joint: what it gains, the hypothesis with it, and the joint's squared residuals."""

    gain: float
    hypothesis: Hypothesis
    cost: float


Trials = dict[tuple[str, bool], Tried]
"""By effect, and whether the joint shows it by itself and not only beside another one."""


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """All effects on all joints together."""
    yield Group("any", best.context.columns, partial(additions, best, desk))


def additions(best: Fit, desk: Desk) -> Iterator[Fit]:
    """For each further effect the hypothesis with it where it helps most, but for what cannot win, and laws
    with more to them than what is there.
    """
    leader = best
    for trial in chain(with_more(best, desk), on_joints(best, desk)):
        leader = min(leader, trial, key=score)
        yield trial
    yield from everywhere(best, desk, leader)


def on_joints(best: Fit, desk: Desk) -> Iterator[Fit]:
    """For each effect that a joint may have, the hypothesis with it on the joints where it is among the
    best.
    """
    alone: dict[str, dict[int, Tried]] = {}
    beside: dict[str, dict[int, Tried]] = {}
    for column, found in zip(best.context.columns, trials(best, desk, best.context.columns), strict=True):
        for (name, by_itself), trial in found.items():
            (alone if by_itself else beside).setdefault(name, {})[column] = trial
    most = {c: max((t[c].gain for t in alone.values() if c in t), default=0.0) for c in best.context.columns}
    for name, by in alone.items():
        chosen = {c: t for c, t in by.items() if t.gain >= MOST * most[c]}
        if chosen:
            yield _merged(best, name, chosen | _shown(best, name, chosen, beside.get(name, {}), most))
    yield from lines(best, most)


def lines(best: Fit, most: dict[int, float]) -> Iterator[Fit]:
    """The hypothesis with ratio and zero of each joint of which either alone explains less: of a joint that
    moves on one side of its zero they hide each other.
    """
    context, found = best.context, best
    kinds = [k for k in local_kinds(context) if k.of_every_joint]
    for column in best.context.columns if len(kinds) > 1 else ():
        if any(column in best.hypothesis[k.id].own for k in kinds if k.id in best.hypothesis):
            continue
        there = found.hypothesis
        for kind in kinds:
            start = {p.name: p.null for p in kind.parameters}
            there = extended(context, there, Candidate(kind.id, kind.forms[0], column, start))
        trial = refit_column(best, there, column)
        if score(best) - score(trial) > most[column]:
            found = Fit(trial.hypothesis, found.cost | {column: trial.cost[column]}, context)
    if found is not best:
        yield found


def trials(best: Fit, desk: Desk, columns: list[int]) -> list[Trials]:
    """The effects that would help each of the columns; kept while nothing that bears on it changes."""
    context = best.context
    forms = frozenset((term.effect, term.form) for term in best.hypothesis.values())
    whens = tuple(sorted(_whens(best.hypothesis)))
    frame = context.look, context.claims
    keys = {c: (c, *frame, context.noise[c], forms, whens, best.hypothesis.key(c)) for c in columns}
    new = [c for c, key in keys.items() if key not in desk.tried]
    kept = {c: desk.looks_at(best, c) for c in new}
    for column, (tried, looked) in zip(
        new, each(context.work, partial(_tried, best, kept), new), strict=True
    ):
        desk.tried[keys[column]] = tried
        kept[column] |= looked
    return [desk.tried[key] for key in keys.values()]


def _whens(hypothesis: Hypothesis) -> Iterator[tuple[str, str, float]]:
    """When an effect acts on any joint, as far as a start of it on another one asks."""
    for term in hypothesis.values():
        moments = {p.name for p in effect(term.effect).used(term.form) if p.moment and not p.shared}
        for own in term.own.values():
            yield from ((term.effect, name, round(own[name], 1)) for name in moments if name in own)


def _tried(best: Fit, kept: dict[int, Kept], column: int) -> tuple[Trials, Kept]:
    """The effects that would help a column, and all looks at it, those ``kept`` among them."""
    tried: Trials = {}
    kinds, before = open_kinds(best.context, best.hypothesis, column), unshown(best.context, best.hypothesis)
    kinds = [*kinds, *(breaking_kinds(best.context, best.hypothesis, column) if kinds else ())]
    for trial in column_trials(best, column, kinds, kept[column]):
        alone = unshown(trial.context, trial.hypothesis) <= before
        gain, key = priced(best) - priced(trial), (_added(best.hypothesis, trial.hypothesis, column), alone)
        if gain > (tried[key].gain if key in tried else 0.0):
            tried[key] = Tried(gain, trial.hypothesis, trial.cost[column])
    return tried, kept[column]


def _added(before: Hypothesis, after: Hypothesis, column: int) -> str:
    """The effect that one hypothesis has more of on a column than the other."""
    return next(
        t.effect
        for t in after.on(column)
        if t.effect not in before
        or column not in before[t.effect].own
        or after.get_words(t.effect, column) != before.get_words(t.effect, column)
    )


def _shown(
    best: Fit, name: str, chosen: dict[int, Tried], beside: dict[int, Tried], most: dict[int, float]
) -> dict[int, Tried]:
    """Those that explain more on a joint than what it shows by itself, where it shows them beside what was
    ``chosen``.
    """
    more = {
        c: t
        for c, t in beside.items()
        if t.gain >= MOST * most[c] and (c not in chosen or t.gain > chosen[c].gain)
    }
    unseen = hidden(best.context, _joined(best, name, chosen | more)[name]) if more else []
    return {c: trial for c, trial in more.items() if c not in unseen}


def _joined(best: Fit, name: str, chosen: dict[int, Tried]) -> Hypothesis:
    """One hypothesis out of the trials of one effect on several joints."""
    out = best.hypothesis.copy()
    leader = chosen[max(chosen, key=lambda c: best.cost[c] - chosen[c].cost)].hypothesis[name]
    term = out.setdefault(name, Term(name, leader.form, dict(leader.shared), given=leader.given))
    shared = dict(term.shared)
    for column, trial in chosen.items():
        out.take(column, trial.hypothesis)
    out[name].shared = shared
    return out


def _merged(best: Fit, name: str, chosen: dict[int, Tried]) -> Fit:
    """The same, fitted."""
    out = _joined(best, name, chosen)
    cost = best.cost | {c: trial.cost for c, trial in chosen.items()}
    return refit_to_win(best, out) if out[name].shared else Fit(out, cost, best.context)


def everywhere(best: Fit, desk: Desk, leader: Fit) -> Iterator[Fit]:
    """Hypotheses with a further effect that acts on all joints alike, where they may beat a ``leader``."""
    context = best.context
    kinds = kinds_of_all(context, best.hypothesis)
    if not kinds:
        return
    screen = Screen(context, best.hypothesis)
    for candidate in promising(best, desk, screen, kinds):
        if context.work.over:
            return
        there = extended(context, best.hypothesis, candidate)
        if not may_win(leader, there, screen, candidate.gain):
            continue
        trial = refit(context, there)
        if candidate.lasts and priced(trial) >= score(best):
            continue  # moments that a fit makes nothing of are not worth the work of dating them
        trial = dated(trial, candidate.effect)
        if score(trial) < score(best) and not shared_by_most(best, trial, candidate.effect):
            trial = with_what_it_stood_for(best, trial)
        own = (of(move, candidate.effect) for move in (OPTION, EVENT, SPELL))
        trial = descend_with(
            shown_again(best, desk, trial, candidate.effect), (MEMBER, *own), desk, score(leader)
        )
        if candidate.effect not in trial.hypothesis or shared_by_most(best, trial, candidate.effect):
            leader = min(leader, trial, key=score)
            yield trial


def promising(best: Fit, desk: Desk, screen: Screen, kinds: list[type[Effect]]) -> list[Candidate]:
    """What a linear look finds on all joints: what always acts, which takes less work, the best first; kept
    while nothing changes.
    """
    context, key = best.context, exactly(best)
    if key not in desk.looked:
        found = on_all_joints(screen, kinds)
        most = REFITTED if local_kinds(context) else len(found)  # a servo's lags hide each other
        desk.looked[key] = sorted(found[:most], key=lambda candidate: candidate.lasts)
    return desk.looked[key]


def law_of_all(best: Fit, desk: Desk) -> float:
    """The most that a further effect that acts on all joints alike explains by a linear look."""
    kinds = kinds_of_all(best.context, best.hypothesis)
    looks = promising(best, desk, Screen(best.context, best.hypothesis), kinds) if kinds else []
    return max((candidate.gain for candidate in looks), default=0.0)


def shown_again(best: Fit, desk: Desk, trial: Fit, name: str) -> Fit:
    """A trial that is better but for what the motion cannot show any more beside the new effect, such as a
    link that would no longer ring: with what looks like that in its place, or without it, until all is shown.
    """
    if priced(trial) >= score(best):
        return trial
    return descend_with(trial, (SWAP_ALL, SWAP_MANY, DROP), desk, lacks=partial(_hides, name))


def _hides(name: str, now: Fit) -> bool:
    """Whether the motion cannot show something else beside an effect."""
    return any(hidden(now.context, term) for other, term in now.hypothesis.items() if other != name)


def shared_by_most(best: Fit, trial: Fit, name: str) -> bool:
    """Whether an effect on all joints explains what it should on most of those that it moves."""
    context, sides = trial.context, []
    less = trial.hypothesis.without(name)
    for column in context.judged(trial.hypothesis[name]):
        moved = change(context, trial.hypothesis, less, column)
        size = float(moved @ moved)
        if size > need(context, column, best.rest(column)):
            gain = best.cost[column] - trial.cost[column]
            left = best.cost[column] - context.count(column)
            sides.append(gain > SOME * size or gain > MOST * left)
    return sum(sides) > MOST * len(sides)


def _on_further_joints(best: Fit, desk: Desk) -> Iterator[Group]:
    """What other joints have already: a joint without it may be the last that the search came to."""

    def trials() -> Iterator[Fit]:
        return (trial for trial in on_joints(best, desk) if trial.hypothesis.keys() == best.hypothesis.keys())

    yield Group("joints", best.context.columns, trials)


ADD = Move("add", groups, grows=True, descends=True)
FURTHER_JOINTS = Move("further_joints", _on_further_joints, grows=True)
