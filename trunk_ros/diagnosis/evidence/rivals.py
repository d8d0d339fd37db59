"""Other effects in the place of one that was found, fitted to the same data."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.search.candidates import Candidate, extended, is_open, usable
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.fit import Fit, refit, refit_column
from trunk_ros.diagnosis.search.formed import off_by
from trunk_ros.diagnosis.search.moves.swap_all import alike, inherited
from trunk_ros.diagnosis.search.score import priced
from trunk_ros.diagnosis.search.screen import Kept, Screen
from trunk_ros.effects import Effect, confused, effect
from trunk_ros.levels import REFITTED

FAR = 5.0
"""Losses that tell: what loses so many is no rival, and how much it loses makes no difference."""

Found = dict[str, tuple[float, Hypothesis]]
"""Loss of each rival, and the hypothesis with it."""


@dataclass(frozen=True)
class Looks:
    """A linear look at some columns without an effect, and by column what it promised of each other one."""

    screen: Screen
    kept: dict[int, Kept]

    @classmethod
    def of(cls, bare: Fit, columns: list[int]) -> Looks:
        """Nothing looked at so far."""
        return cls(Screen(bare.context, bare.hypothesis, columns), {c: {} for c in columns})

    def promising(self, column: int, but: Collection[str]) -> list[Candidate]:
        """The best start of each effect that a column may have all the time, but of some; of what another
        joint causes, one from each.
        """
        kept = [[one for one in some if not one.lasts] for some in self.kept[column].values()]
        best = [max(some, key=lambda x: x.gain) for some in kept if some]
        found = []
        for one in [one for one in best if one.effect not in but]:
            starts = (
                self.screen.starts.on(effect(one.effect), one.form, column)
                if effect(one.effect).texts
                else []
            )
            found += [replace(one, start=start) for start in starts] or [one]
        return found


def rivals(state: Fit, name: str, bare: Fit, looks: Looks, limit: float) -> Found:
    """Loss of each promising effect in the place of one, and the hypothesis with it: on the same joints, and
    on all joints where others show too little of it to rule it out. Also of what the motion of some of them
    cannot show, as it cannot rule it out either. ``limit``: a loss that tells.
    """
    context, far = bare.context, FAR * limit
    columns = context.judged(state.hypothesis[name])
    kinds, like = [k for k in usable(context) if k.id != name], confused(name)
    losses = _local_rivals(state, bare, looks, columns, [k for k in kinds if not k.everywhere], like, far)
    whole = effect(name).everywhere or len(columns) == len(context.columns)
    others = [k for k in kinds if k.everywhere and k.id not in state.hypothesis and (whole or k.id in like)]
    screen = Screen(context, bare.hypothesis, None if others else [])

    def everywhere(kind: type[Effect]) -> Found:
        found = screen.all_everywhere(kind)
        # what lasts just as long as one joint moves is a claim more
        kept = found if whole else [c for c in found if not c.lasts]
        candidate = max(kept, key=lambda c: c.gain, default=None)
        if candidate is None:
            return {}
        there = extended(context, bare.hypothesis, candidate)
        if not whole and screen.may_come_to(there, candidate.gain) >= state.total + limit:
            return {}
        tried = [there, *_as_it_is(bare, state.hypothesis[name], kind)]
        trial = _best_of(context, tried, state.total + far)
        return {kind.id: (loss(state, trial, columns), trial.hypothesis)}

    for some in each(context.work, everywhere, others):
        losses |= some
    return losses


def _best_of(context: Context, tried: list[Hypothesis], goal: float) -> Fit:
    """The best of them, refitted; given up where they come neither to a ``goal`` nor below each other."""
    best = refit(context, tried[0], goal)
    for one in tried[1:]:
        best = min(best, refit(context, one, min(goal, best.total)), key=lambda fit: fit.total)
    return best


def _as_it_is(bare: Fit, old: Term, kind: type[Effect]) -> list[Hypothesis]:
    """An effect of its like in the place of another one with the values that this has, but for one that
    includes it and with those values is the same.
    """
    if not alike(kind, effect(old.effect)) or old.effect in kind.replaces:
        return []
    return inherited(bare.context, bare.hypothesis, old, kind)


def loss(state: Fit, rival: Fit, columns: Collection[int]) -> float:
    """By how much a rival of a name on some columns leaves more, or has a worse score where that is less:
    what says the same with one value for all joints may leave more than one of each. On other joints a rival
    gains nothing by what the model's own laws may be off by.
    """
    gains = {c: state.cost[c] - cost for c, cost in rival.cost.items() if c not in columns}
    spared = sum(min(gain, off_by(state.context, c)) for c, gain in gains.items() if gain > 0.0)
    return float(min(rival.total - state.total, priced(rival) - priced(state)) + spared)


def _local_rivals(
    state: Fit, bare: Fit, looks: Looks, columns: list[int], kinds: list[type[Effect]],
    like: Collection[str], far: float,
) -> Found:  # fmt: skip
    """The same of effects that a joint has by itself, of all ``like`` it among them; where a joint has one
    already, that is refitted. Given up where a joint loses as much as ``far``.
    """
    context, screen = bare.context, looks.screen
    new = {k.id: without(bare.hypothesis, k.id, columns) for k in kinds}
    kinds = [
        k for k in kinds if new[k.id] and all(is_open(context, bare.hypothesis, k, c) for c in new[k.id])
    ]
    open_ = {c: [k for k in kinds if c in new[k.id]] for c in columns}
    ranked = {c: screen.ranked(open_[c], c, REFITTED, like, looks.kept[c]) for c in columns}

    def local(name: str) -> Found:
        cost, fitted = dict(state.cost), bare.hypothesis.copy()
        for c in columns:
            found = [x for x in ranked[c] if x.effect == name]
            trials = found or screen.forms(effect(name), c)[:1] if c in new[name] else []
            goal = state.cost[c] + far
            fits = [refit_column(bare, extended(context, bare.hypothesis, x), c, goal) for x in trials]
            fits = [f for f in fits if c not in hidden(context, f.hypothesis[name])]
            best = min(fits, key=priced, default=bare)  # a form with more to it has to gain that
            cost[c] = best.cost[c]
            fitted.take(c, best.hypothesis)
        if len(without(fitted, name, columns)) == len(new[name]):  # the motion hides it on all of them
            return {}
        return {name: (loss(state, Fit(fitted, cost, context), columns), fitted)}

    losses: Found = {}
    names = dict.fromkeys(candidate.effect for some in ranked.values() for candidate in some)
    for some in each(context.work, local, [*names]):
        losses |= some
    return losses


def without(hypothesis: Hypothesis, name: str, columns: list[int]) -> list[int]:
    """Those of the columns that do not have an effect."""
    has = hypothesis[name].columns if name in hypothesis else []
    return [c for c in columns if c not in has]


def by_its_own_angles(state: Fit, rival: Hypothesis) -> Fit | None:
    """A rival refitted with the joint angles that it predicts itself; None where couplings and loads see the
    same in ``state``.
    """
    seen = state.context.seen_with(rival)
    return None if seen is state.context else refit(seen, rival)
