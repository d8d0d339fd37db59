"""What does not help on samples that the fit did not see, or less than an effect has to, is no finding, and
is in no model.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Mapping

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence.as_given import unrounded
from trunk_ros.diagnosis.evidence.evidence import Evidence, evidence
from trunk_ros.diagnosis.evidence.unseen import unseen
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.search.candidates import usable
from trunk_ros.diagnosis.search.credible import unshown
from trunk_ros.diagnosis.search.descent import Desk, descend
from trunk_ros.diagnosis.search.fit import Fit, groups, refit
from trunk_ros.diagnosis.search.moves import CURVE, DROP
from trunk_ros.diagnosis.search.moves.drop import dropped
from trunk_ros.diagnosis.search.score import BETTER, beats, by_values, score
from trunk_ros.diagnosis.search.state import moments_of
from trunk_ros.effects import effect
from trunk_ros.guards import TINY
from trunk_ros.levels import HALF, SEVERAL


def believed(state: Fit, part: Fit) -> tuple[Fit, Fit, dict[str, Evidence]]:
    """A fit and one of the same to what rivals are fitted to, without the names that gain less than they have
    to, or than a rival gains beyond them, and the evidence for the others. One at a time, the weakest first.
    Then without those that are more likely wrong than right and do not help on blocks that were not seen.
    A rival that turns out to be better takes the place of the name: a search that ended early may not have
    come to it. After each change evidence is gathered anew for what it touched; once the work that is granted
    for that is spent, only for names that are new or that a rival had beaten, and the others are left as they
    are.
    """
    work, found, before = state.context.work.besides(), dict[str, Evidence](), part
    old = set[str]()
    while True:
        touched = {n for n in found if not _is_untouched(before, part, n)}
        stands = {n: e for n, e in found.items() if n not in touched or (work.over and not _is_beaten(e))}
        old = {n for n in stands if n in touched or n in old}
        found, before = evidence(part, state, work, stands), part
        better, both = _better(part, found), part is state
        if better is not None:
            part = better
            state = part if both else refit(state.context, part.hypothesis)
            continue
        weak = {n: e.gain_share for n, e in found.items() if _is_claimed(state, n) and n not in old}
        name = min(weak, key=weak.__getitem__, default=None)
        if name is None or weak[name] >= 1.0:
            doubted = {n for n in weak if found[n].confidence < HALF}
            helped = harmless(state, doubted) if doubted and not work.over else state
            if helped.hypothesis is state.hypothesis:
                state.context.work.took(work)
                return state, part, found
            state, part = helped, helped if both else refit(part.context, helped.hypothesis)
            continue
        state = dropped(state, name)
        part = state if both else dropped(part, name)


def _is_claimed(state: Fit, name: str) -> bool:
    return effect(name).named and name not in state.context.known


def _is_beaten(told: Evidence) -> bool:
    """Whether a rival explains more than a name: that may have been put in since."""
    return min(told.rivals.values(), default=0.0) < 0.0


def _is_untouched(before: Fit, now: Fit, name: str) -> bool:
    """Whether what is fitted on the joints of an effect is what was fitted there before."""
    if name not in now.hypothesis or now.context is not before.context:
        return False
    shared = [[n for n in fit.hypothesis if effect(n).everywhere] for fit in (before, now)]
    columns = now.context.columns if effect(name).everywhere else now.hypothesis[name].columns
    return shared[0] == shared[1] and all(before.hypothesis.key(c) == now.hypothesis.key(c) for c in columns)


def _better(part: Fit, found: Mapping[str, Evidence]) -> Fit | None:
    """The best fit with a rival that explains more than the name in the place of which it was tried, of those
    that the motion can show; or with fewer names for the same joints. None where none is better.
    """
    ahead = [
        _in_its_place(part.hypothesis, name, rival, there)
        for name, told in found.items()
        for rival, there in told.fitted.items()
        if told.rivals[rival] < 0.0 and name not in part.context.known
        if _is_shown(part.context, there[rival])
    ]
    fits = [unrounded(refit(part.context, there)) for there in ahead]
    best = min(fits, key=score, default=part)
    if beats(best, part):
        return best
    fewer = [fit for fit in fits if _says_less(fit.hypothesis, part.hypothesis) and _is_credible(fit)]
    best = min(fewer, key=by_values, default=part)
    return best if by_values(best) < by_values(part) - BETTER else None


def _says_less(some: Hypothesis, other: Hypothesis) -> bool:
    """Whether a hypothesis has some of the names of another one, for the same joints, and no moment or source
    besides.
    """
    return (
        some.keys() < other.keys()
        and _joints(some) == _joints(other)
        and moments_of(some) <= moments_of(other)
        and _sources(some) <= _sources(other)
    )


def _joints(one: Hypothesis) -> set[int]:
    return {c for term in one.values() for c in term.columns}


def _sources(one: Hypothesis) -> set[tuple[int, str]]:
    return {(c, word) for term in one.values() for c, said in term.words.items() for word in said.values()}


def _is_credible(fit: Fit) -> bool:
    return not unshown(fit.context, fit.hypothesis)


def _in_its_place(now: Hypothesis, name: str, rival: str, there: Hypothesis) -> Hypothesis:
    """With what was found ``there`` with a rival in the place of a name, beside what other joints have by
    now: names may have come and gone since.
    """
    out = now.without(name)
    if effect(rival).everywhere:
        out[rival] = there[rival].copy()
    for column in now[name].columns:
        out.take(column, there)
    return out


def _is_shown(context: Context, term: Term) -> bool:
    """Whether the motion can show an effect, on one of the joints of which it says something by itself: one
    that does not show it may have it beside one that does.
    """
    kind, said = effect(term.effect), [c for c in term.columns if term.own[c]]
    shown = [c in context.columns and kind.forms_shown(context.motion(c)) for c in said]
    return kind in usable(context) and any(shown or [True])


def harmless(state: Fit, doubted: Collection[str] = ()) -> Fit:
    """Without the effects, joint by joint, that blocks which a fit has not seen are better off without; those
    without a name also where that is so of recordings that it has not seen. If names are ``doubted``, only of
    these, and as of what has no name: for them as well nothing speaks but that they help.

    One at a time, the worst first, as far as the work goes that is granted for that. What the model has
    already stays. A name that is bent, without another one, to what the motion cannot show goes as well, and
    a curve may stand in for it.
    """
    known: dict[Hashable, Array] = {}
    granted, work = state.context.work, state.context.work.besides()
    state, bent = state.working(work), unshown(state.context, state.hypothesis)
    while not work.over:
        before = state.context
        if (worst := _worst(state, known, doubted)) is not None:
            state = dropped(state, *worst)
        elif unshown(state.context, state.hypothesis) > bent:
            state, bent = descend(state, (DROP, CURVE), Desk()), unshown(state.context, state.hypothesis)
        else:
            break
        known = known if state.context is before else {}
    granted.took(work)
    return state.working(granted)


def _worst(
    state: Fit, known: dict[Hashable, Array], doubted: Collection[str]
) -> tuple[str, int | None] | None:
    """What does most harm, of names only ``doubted`` ones if there are any. ``known``: what hypotheses leave
    of blocks that they have not seen, by all that this depends on; what did not change is not fitted anew.
    """
    asked: dict[Hashable, tuple[Hypothesis, list[int], bool]] = {}
    some: dict[tuple[str, int | None], list[tuple[Hashable, Hashable]]] = {}
    for name, column in _removable(state):
        if doubted and name not in doubted:
            continue
        columns = state.hypothesis[name].columns if column is None else [column]
        columns = [c for c in columns if c in state.context.columns]
        pair = state.hypothesis, state.hypothesis.without(name, column)
        several = len(state.context.views) >= SEVERAL and (bool(doubted) or not effect(name).named)
        for whole in (False, True) if several else (False,):
            keys = [(whole, _fitted_with(state.context, one, columns)) for one in pair]
            some.setdefault((name, column), []).append((keys[0], keys[1]))
            asked |= {key: (one, columns, whole) for key, one in zip(keys, pair, strict=True)}
    new = [key for key in asked if key not in known]
    left = each(state.context.work, lambda key: unseen(state.context, *asked[key]), new)
    known |= dict(zip(new, left, strict=True))
    harm = {
        which: max(
            _harm(known[with_it], known[without], not doubted and effect(which[0]).named)
            for with_it, without in pairs
        )
        for which, pairs in some.items()
    }
    worst = max(harm, key=harm.__getitem__, default=None)
    return worst if worst is not None and harm[worst] > 0.0 else None


def _fitted_with(context: Context, hypothesis: Hypothesis, columns: list[int]) -> Hashable:
    """What a fit of some columns depends on."""
    fitted = [c for group in groups(context, hypothesis) if set(group) & set(columns) for c in group]
    given = tuple((c, tuple(term.given for term in hypothesis.on(c))) for c in fitted)
    return (*columns, given, *(hypothesis.key(c) for c in fitted))


def _removable(state: Fit) -> Iterator[tuple[str, int | None]]:
    for name, term in state.hypothesis.items():
        if name not in state.context.known:
            seen = state.context.judged(term)
            yield from ((name, c) for c in ([None] if effect(name).everywhere and seen else seen))


def _harm(with_it: Array, without: Array, named: bool) -> float:
    """By how much squared residuals (2, BLOCKS) are larger with an effect, for sure: as unit noise, and for
    what has no name also, in the same measure, as they are, which is what ``simulate`` leaves. What noise
    remembers hides in the first what is slow. Names may be off by what else is still missing.
    """
    innovations = _surely(with_it[0], without[0], named)
    if named:
        return innovations
    plain, of_both = _surely(with_it[1], without[1], named), without.sum(axis=1)
    return max(innovations, plain * float(of_both[0] / max(of_both[1], TINY)))


def _surely(with_it: Array, without: Array, named: bool) -> float:
    """By how much squared residuals (BLOCKS,) are larger with an effect, for sure. For what has no name
    nothing else speaks than that it helps: it is enough that most blocks are worse, and all together.
    """
    harm = with_it - without
    if not named and np.median(harm) > 0.0:
        return float(harm.sum())
    return float(harm.sum() - np.sqrt(np.sum((harm - harm.mean()) ** 2)))
