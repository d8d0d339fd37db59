"""What else may explain what an effect does: others in its place on the same joints, refitted."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.levels import REFITTED
from trunk_ros.diagnosis.search.candidates import extended, is_open, usable
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.fit import Fit, refit, refit_column
from trunk_ros.diagnosis.search.moves.swap_all import alike, inherited
from trunk_ros.diagnosis.search.score import priced
from trunk_ros.diagnosis.search.screen import Screen
from trunk_ros.effects import Effect, confused, effect


def rivals_of(state: Fit, name: str, bare: Fit) -> dict[str, tuple[float, Hypothesis]]:
    """Loss of each promising effect in the place of one, on the same joints, and the hypothesis with it: also
    of what the motion cannot show, as it cannot rule it out either.
    """
    context = state.context.doubting()
    bare = replace(bare, context=context)
    columns = [c for c in state.hypothesis[name].columns if c in context.columns]
    kinds = [k for k in usable(context) if k.id != name]
    losses = _local_rivals(state, bare, columns, [k for k in kinds if not k.everywhere], confused(name))
    if effect(name).everywhere or len(columns) == len(context.columns):
        for kind in (k for k in kinds if k.everywhere and k.id not in state.hypothesis):
            trials = [refit(context, there) for there in _in_its_place(bare, state.hypothesis[name], kind)]
            if trials:
                trial = min(trials, key=lambda fit: fit.total)
                losses[kind.id] = loss(state, trial), trial.hypothesis
    return losses


def _in_its_place(bare: Fit, old: Term, kind: type[Effect]) -> list[Hypothesis]:
    """An effect on all joints in the place of another one: as a linear look finds it, and of its like also
    with the values that this has, but for one that includes it and with those values is the same.
    """
    candidate = Screen(bare.context, bare.hypothesis).everywhere(kind)
    found = [] if candidate is None else [extended(bare.context, bare.hypothesis, candidate)]
    if alike(kind, effect(old.effect)) and old.effect not in kind.replaces:
        found += inherited(bare.context, bare.hypothesis, old, kind)
    return found


def loss(state: Fit, rival: Fit) -> float:
    """By how much a rival leaves more, or has a worse score where that is less: what says the same with one
    value for all joints may leave more than one of each.
    """
    return float(min(rival.total - state.total, priced(rival) - priced(state)))


def _local_rivals(
    state: Fit, bare: Fit, columns: list[int], kinds: list[type[Effect]], like: Collection[str]
) -> dict[str, tuple[float, Hypothesis]]:
    """The same of effects that a joint has by itself, of all ``like`` it among them; where a joint has one
    already, that is refitted.
    """
    context, screen = bare.context, Screen(bare.context, bare.hypothesis, columns)
    new = {k.id: lacking(bare.hypothesis, k.id, columns) for k in kinds}
    kinds = [
        k for k in kinds if new[k.id] and all(is_open(context, bare.hypothesis, k, c) for c in new[k.id])
    ]
    ranked = {c: screen.ranked([k for k in kinds if c in new[k.id]], c, REFITTED, like) for c in columns}
    losses: dict[str, tuple[float, Hypothesis]] = {}
    for name in dict.fromkeys(candidate.effect for some in ranked.values() for candidate in some):
        cost, fitted = dict(state.cost), bare.hypothesis.copy()
        for c in columns:
            found = [x for x in ranked[c] if x.effect == name]
            trials = found or screen.forms(effect(name), c)[:1] if c in new[name] else []
            fits = [refit_column(bare, extended(context, bare.hypothesis, x), c) for x in trials]
            fits = [f for f in fits if c not in hidden(context, f.hypothesis[name])]
            best = min(fits, key=lambda f: f.cost[c], default=bare)
            cost[c] = best.cost[c]
            fitted.take(c, best.hypothesis)
        losses[name] = loss(state, Fit(fitted, cost, context)), fitted
    return losses


def lacking(hypothesis: Hypothesis, name: str, columns: list[int]) -> list[int]:
    """Those of the columns that do not have an effect."""
    has = hypothesis[name].columns if name in hypothesis else []
    return [c for c in columns if c not in has]


def by_its_own_angles(state: Fit, rival: Hypothesis) -> Fit | None:
    """A rival refitted with the joint angles that it predicts itself; None where couplings and loads see the
    same in ``state``.
    """
    seen = state.context.seen_with(rival)
    return None if seen is state.context else refit(seen, rival)
