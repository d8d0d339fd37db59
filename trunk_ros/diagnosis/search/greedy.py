"""The search: the first change that pays is taken, until none does or the work that was granted is done.

Where that leaves much, the best first step led astray: the next best ones are gone as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.disturbances.arrivals import arrived
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import DYNAMIC, OTHERS
from trunk_ros.diagnosis.search.descent import Desk, Move, descend, of
from trunk_ros.diagnosis.search.fit import Fit, costed, refit
from trunk_ros.diagnosis.search.formed import measured
from trunk_ros.diagnosis.search.looked_again import renewed
from trunk_ros.diagnosis.search.moves import CURVE, DROP, EARLY_CURVE, FURTHER_JOINTS, MOVES, NAMED, PLAINER
from trunk_ros.diagnosis.search.moves.add import additions
from trunk_ros.diagnosis.search.score import beats, score
from trunk_ros.effects import effect
from trunk_ros.levels import LITTLE, REFITTED


def search(context: Context, desk: Desk) -> Fit:
    """The hypothesis that no single change improves by what is needed; what would not be claimed is left out
    even where the work that was granted is done, as far as what is granted on top goes. What is claimed is
    judged in the noise that it leaves itself: what was left out since had told another one.
    """
    first = told_by_speed(context, desk) or renewed(begun(context))
    best = descend(first, MOVES, desk, steady=True)
    others = sorted(additions(first, desk), key=score)[1:REFITTED] if incomplete(best) else []
    for other in others:
        if incomplete(best):
            again = Desk(desk.say, vain=desk.vain)
            best = better_of(best, descend(renewed(other), MOVES, again, steady=True))
    over = best.context.work.over
    done = renewed(_besides(best, _settling(best), desk) if over else best)
    done = replace(done, context=replace(done.context, claims=True))
    for moves in ((DROP, PLAINER, FURTHER_JOINTS), (DROP, CURVE, NAMED)) if over else ((DROP,),):
        done = _besides(done, moves, desk)
    return plain(done)


def told_by_speed(context: Context, desk: Desk) -> Fit | None:
    """What explains a recording with what goes by speed, where all loops are wide and the motion looks alike
    throughout: any lag is a form of such a loop, so it is believed where names leave only noise with it, and
    none do without it that are better. None else; of the columns of what is returned none is hidden by its
    loop. A lag that comes first may take the place of the loop, so it is also looked for beside names that
    are found without it; and other joints, which move as often, may take the place of the lag, so that it is
    also looked for without them.
    """
    if not set(context.columns) <= context.wide:
        return None
    by_speed = replace(context, wide=frozenset())
    found = _named(by_speed, context.known, desk)
    without = _named(context, context.known, desk)
    if not _lags(found):
        found = _named(by_speed, without.hypothesis, desk)
    if not _lags(found) and any(OTHERS in effect(name).needs for name in found.hypothesis):
        own = _named(replace(context, alone=True), context.known, desk)
        found = _named(replace(by_speed, alone=True), own.hypothesis, desk)
        found = replace(found, context=replace(found.context, alone=False))
    better = _leaves_noise(without) and better_of(found, without) is without
    return found.working(context.work) if _lags(found) and not better else None


def _named(context: Context, start: Hypothesis, desk: Desk) -> Fit:
    """What names explain from a start on, by a share of the work that is no part of what was granted."""
    names = [move for move in MOVES if move not in (CURVE, EARLY_CURVE)]
    granted = context.work.besides()
    begins = begun(replace(context, work=granted))
    first = begins if start is context.known else refit(begins.context, start)
    found = descend(renewed(first), names, Desk(desk.say), steady=True)
    context.work.was_beside(granted)
    return found


def _lags(found: Fit) -> bool:
    """Whether effects of speed leave only noise."""
    return _leaves_noise(found) and any(effect(name).regime in DYNAMIC for name in found.hypothesis)


def _leaves_noise(found: Fit) -> bool:
    return all(found.beyond_noise(c) <= 0.0 for c in found.cost)


def _settling(best: Fit) -> list[Move]:
    """What finds out how the effect that was put in last is what it is: the search may have ended before."""
    return [of(move, *list(best.hypothesis)[-1:]) for move in MOVES if move.settles]


def _besides(best: Fit, moves: Sequence[Move], desk: Desk) -> Fit:
    """What some moves make of a fit by the work that is granted on top."""
    work, closing = best.context.work, best.context.work.besides()
    done = descend(best.working(closing), moves, desk)
    work.took(closing)
    return done.working(work)


def incomplete(best: Fit) -> bool:
    """Whether something is left that is as strong as the noise, and more than formulas may be off by."""
    least = {c: max(best.context.count(c), LITTLE * best.context.misfit[c]) for c in best.cost}
    return any(best.rest(c) > least[c] for c in best.cost)


def better_of(best: Fit, other: Fit) -> Fit:
    """The better of two, both judged by the noise of the first."""
    alike = other.context.in_noise(best.context.noise)
    return other if beats(costed(alike, other.hypothesis), best) else best


def begun(context: Context) -> Fit:
    """What is known, fitted; all else is measured by what it leaves."""
    first = refit(arrived(context, context.known), context.known)
    return replace(first, context=measured(first))


def plain(now: Fit) -> Fit:
    """The same physics in the values that one would write down."""
    out = now.hypothesis.copy()
    for term in out.values():
        term.own = {c: effect(term.effect).plain(values) for c, values in term.own.items()}
    return replace(now, hypothesis=out)
