"""Options that an effect is without, such as on which side of its friction a wire gives way, though the data
are explained as well with them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.score import chance
from trunk_ros.effects import effect
from trunk_ros.guards import SAME
from trunk_ros.levels import NOTABLE


def untold(state: Fit, name: str, limit: float) -> list[str]:
    """Those of which something is to be said, with which an effect loses less than ``limit``; not what makes
    no difference to it at all: without a play both sides of it are one.
    """
    kind, term = effect(name), state.hypothesis[name]
    said = {p.name for p in kind.own_parameters(term.form) if p.untold and p.name not in term.shared}
    out = []
    for option in kind.options(term.form):
        if not option or not option.keys() <= said:
            continue
        there = state.hypothesis.copy()
        there[name].shared |= option
        there[name].given |= option.keys()  # else a fit comes back to what is without it
        if _differ(state, Fit(there, state.cost, state.context), term.columns):
            trial = refit(state.context, there, state.total + limit)
            out += sorted(option) if trial.total < state.total + limit else []
    return out


def likelier(state: Fit, options: Mapping[str, Sequence[str]]) -> Fit:
    """With those of ``options`` that leave less than without: of two laws that the data hardly tell one has
    to be in the model, and neither is a claim that needs a proof. What the model had stays as it had it.
    """
    new = state.hypothesis.keys() - state.context.known.keys()
    for name, option in [(name, option) for name, some in options.items() for option in some if name in new]:
        there = state.hypothesis.copy()
        there[name].shared[option] = effect(name).parameter(option).bounds[1]
        trial = refit(state.context, there, state.total)
        likely = max((chance(state.context, c) for c in state.context.judged(there[name])), default=1.0)
        if trial.total < state.total - NOTABLE**2 * likely:
            state = trial
    return state


def _differ(one: Fit, other: Fit, columns: list[int]) -> bool:
    """Whether two hypotheses predict anything different of some joints, beside their noise."""
    for c in [c for c in columns if c in one.cost]:
        pairs = zip(*(f.context.predictions(f.hypothesis, c) for f in (one, other)), strict=True)
        if any(np.abs(a - b).max(initial=0.0) > SAME * one.context.noise[c].std for a, b in pairs):
            return True
    return False
