"""Options that an effect is without, such as on which side of its friction a wire gives way, though the data
are explained as well with them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.score import chance
from trunk_ros.effects import effect
from trunk_ros.guards import SAME
from trunk_ros.levels import NOTABLE


def untold(state: Fit, name: str, limit: float) -> list[str]:
    """Those of which something is to be said, with which an effect loses less than ``limit``; not what makes
    no difference to it at all: without a play both sides of it are one.
    """
    term, out = state.hypothesis[name], list[str]()
    said = {p.name for p in effect(name).own_parameters(term.form) if p.untold and p.name not in term.shared}
    for option in _options(state, name, said):
        there = _with(state, name, option)
        there[name].given |= option.keys()  # else a fit comes back to what is without it
        if _differ(state, Fit(there, state.cost, state.context), term.columns):
            trial = refit(state.context, there, state.total + limit)
            out += sorted(option) if trial.total < state.total + limit else []
    return out


def with_likelier_options(state: Fit, options: Mapping[str, Sequence[str]]) -> Fit:
    """With those of ``options`` that leave less than without: of two laws that the data hardly tell one has
    to be in the model, and neither is a claim that needs a proof. What the model had stays as it had it.
    """
    new = state.hypothesis.keys() - state.context.known.keys()
    for name, option in [(n, o) for n, some in options.items() if n in new for o in _options(state, n, some)]:
        there = _with(state, name, option)
        trial = refit(state.context, there, state.total)
        likely = max((chance(state.context, c) for c in state.context.judged(there[name])), default=1.0)
        if trial.total < state.total - NOTABLE**2 * likely:
            state = trial
    return state


def _options(state: Fit, name: str, some: Collection[str]) -> list[dict[str, float]]:
    """Those of an effect that are of ``some`` parameters."""
    return [o for o in effect(name).options(state.hypothesis[name].form) if o and set(some) >= o.keys()]


def _with(state: Fit, name: str, option: Mapping[str, float]) -> Hypothesis:
    there = state.hypothesis.copy()
    there[name].shared |= option
    return there


def _differ(one: Fit, other: Fit, columns: list[int]) -> bool:
    """Whether two hypotheses predict anything different of some joints, beside their noise."""
    for c in [c for c in columns if c in one.cost]:
        pairs = zip(*(f.context.predictions(f.hypothesis, c) for f in (one, other)), strict=True)
        if any(np.abs(a - b).max(initial=0.0) > SAME * one.context.noise[c].std for a, b in pairs):
            return True
    return False
