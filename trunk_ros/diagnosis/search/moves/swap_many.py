"""An effect in the place of one that several joints have and that it is confused with, on all of them at
once: what the arm shares moves along, and joint by joint each would have to show the form that all have.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.search.candidates import local_kinds, shown_forms
from trunk_ros.diagnosis.search.credible import unshown
from trunk_ros.diagnosis.search.descent import Desk, Group, Move, descend_with
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.moves.drop import DROP
from trunk_ros.diagnosis.search.score import score
from trunk_ros.diagnosis.search.trial import begun_on
from trunk_ros.effects import Effect, confused, effect
from trunk_ros.levels import SEVERAL


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each effect of several joints, by each that it is confused with."""
    for name in [name for name in best.hypothesis if _on_several(best, name)]:
        for rival in map(effect, sorted(confused(name))):
            if rival in local_kinds(best.context):
                yield Group(
                    (name, rival.id), best.context.columns, partial(_on_the_same, best, desk, name, rival)
                )


def _on_several(best: Fit, name: str) -> bool:
    return len(best.context.judged(best.hypothesis[name])) >= SEVERAL


def on_most(best: Fit, name: str) -> bool:
    """Whether an effect acts on all joints, or is on most of them."""
    there = best.context.judged(best.hypothesis[name])
    return effect(name).everywhere or 2 * len(there) > len(best.context.columns)


def _on_the_same(best: Fit, desk: Desk, name: str, kind: type[Effect]) -> Iterator[Fit]:
    """An effect in the place of another on all of its joints, and of all that these have of its regime."""
    columns, less = best.context.judged(best.hypothesis[name]), best.hypothesis.without(name)
    alone = less.less([other for other in less if effect(other).regime == kind.regime])
    for bare in (less, alone) if len(alone) < len(less) else (less,):
        there = bare.get(kind.id)
        new = [c for c in columns if there is None or c not in there.own]
        for form in shown_forms(kind, best.context, new) if there is None else (there.form,):
            out = begun_on(best.context, bare, kind, form, new)
            if out is not None:
                trial = refit(best.context, out, score(best))
                if trial.total < score(best) and not unshown(trial.context, trial.hypothesis):
                    yield descend_with(trial, (DROP,), desk)


SWAP_MANY = Move("swap_many", groups, descends=True)
