"""Other effects in the place of one that was found, fitted to the same data."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import REFITTED
from trunk_ros.diagnosis.search.candidates import extended, is_open, usable
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.fit import Fit, refit, refit_column
from trunk_ros.diagnosis.search.screen import Screen
from trunk_ros.effects import Effect, confused, effect


def rivals(state: Fit, name: str, bare: Fit, limit: float) -> dict[str, tuple[float, Hypothesis]]:
    """Loss of each promising effect in the place of one, and the hypothesis with it: on the same joints, and
    on all joints where others show too little of it to rule it out. Also of what the motion cannot show, as
    it cannot rule it out either. ``limit``: a loss that tells.
    """
    context = state.context.doubting()
    bare = replace(bare, context=context)
    columns = [c for c in state.hypothesis[name].columns if c in context.columns]
    kinds = [k for k in usable(context) if k.id != name]
    losses = _local_rivals(state, bare, columns, [k for k in kinds if not k.everywhere], confused(name))
    whole = effect(name).everywhere or len(columns) == len(context.columns)
    for kind in (k for k in kinds if k.everywhere and k.id not in state.hypothesis):
        if not (whole or kind.id in confused(name)):
            continue
        screen = Screen(context, bare.hypothesis)
        candidate = screen.everywhere(kind)
        if candidate is not None:
            there = extended(context, bare.hypothesis, candidate)
            if whole or screen.may_come_to(there, candidate.gain) < state.total + limit:
                trial = refit(context, there)
                losses[kind.id] = float(trial.total - state.total), trial.hypothesis
    return losses


def _local_rivals(
    state: Fit, bare: Fit, columns: list[int], kinds: list[type[Effect]], like: Collection[str]
) -> dict[str, tuple[float, Hypothesis]]:
    """The same of effects that a joint has by itself, of all ``like`` it among them; where a joint has one
    already, that is refitted.
    """
    context, screen = bare.context, Screen(bare.context, bare.hypothesis, columns)
    new = {k.id: without(bare.hypothesis, k.id, columns) for k in kinds}
    kinds = [
        k for k in kinds if new[k.id] and all(is_open(context, bare.hypothesis, k, c) for c in new[k.id])
    ]
    ranked = {c: screen.ranked([k for k in kinds if c in new[k.id]], c, REFITTED, like) for c in columns}
    losses: dict[str, tuple[float, Hypothesis]] = {}
    for name in dict.fromkeys(candidate.effect for some in ranked.values() for candidate in some):
        loss, fitted = 0.0, bare.hypothesis.copy()
        for c in columns:
            found = [x for x in ranked[c] if x.effect == name]
            trials = found or screen.forms(effect(name), c)[:1] if c in new[name] else []
            fits = [refit_column(bare, extended(context, bare.hypothesis, x), c) for x in trials]
            fits = [f for f in fits if c not in hidden(context, f.hypothesis[name])]
            best = min(fits, key=lambda f: f.cost[c], default=bare)
            loss += best.cost[c] - state.cost[c]
            fitted.take(c, best.hypothesis)
        losses[name] = float(loss), fitted
    return losses


def without(hypothesis: Hypothesis, name: str, columns: list[int]) -> list[int]:
    """Those of the columns that do not have an effect."""
    has = hypothesis[name].columns if name in hypothesis else []
    return [c for c in columns if c not in has]
