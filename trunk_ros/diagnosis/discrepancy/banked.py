"""Banks beside the named effects of a joint, where those leave much and the banks win on blocks not seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.bank_weights import CUTS, Cuts, Source
from trunk_ros.diagnosis.discrepancy.curves import curves_beside, redrawn
from trunk_ros.diagnosis.discrepancy.memory import drawn, redrawn_banks, sources, without_banks
from trunk_ros.diagnosis.evidence.at_rest import honest
from trunk_ros.diagnosis.evidence.residual_dependence import rests
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import shown_forms
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.fit import Fit, costed_on, fit
from trunk_ros.diagnosis.search.formed import FORMULAS
from trunk_ros.diagnosis.search.moves.form import refinements
from trunk_ros.diagnosis.search.score import CURVE
from trunk_ros.effects import effect
from trunk_ros.effects.curve import HALF
from trunk_ros.levels import HARDLY, NOTABLE, SLIGHT


def with_banks(state: Fit) -> Fit:
    """The hypothesis with banks on the joints that need them."""
    context = state.context
    if context.stage.name != "wire":
        return state
    left = rests(honest(context, state.hypothesis), state.hypothesis)
    for column in [c for c, power in left.items() if power > 1.0]:
        misfit = context.formed_misfit[column] / context.count(column)
        if left[column] > CURVE * FORMULAS * misfit:
            state = _banked(_curved(state, column, misfit), column, misfit)
    return state


def _curved(state: Fit, column: int, misfit: float) -> Fit:
    """With a curve beside the names of a joint that never comes back: it shows nothing of memory, and what
    bends over its way or its load is all that can be told of the rest.
    """
    context, hypothesis = state.context, state.hypothesis
    if column not in context.stage.one_way or column in hypothesis.curved:
        return state
    tried = [
        Judged(trial, unseen(context, trial, column)) for trial in curves_beside(context, hypothesis, column)
    ]
    best = min(tried, key=lambda trial: float(trial.unseen.mean()))
    if not _wins(unseen(context, hypothesis, column), best.unseen, misfit):
        return state
    return costed_on(state, best.hypothesis, column)


def _banked(state: Fit, column: int, misfit: float) -> Fit:
    context, found = state.context, list(sources(state.context, column))
    if not found:
        return state
    plain = [source for source in found if not source.kind.by_posture]
    fewer = _lean(context, state.hypothesis, column, plain).hypothesis
    best = _refitted(context, state.hypothesis, column, found)
    if _names(fewer, column) != _names(state.hypothesis, column):
        lean = _refitted(context, fewer, column, found)
        best = lean if lean.unseen.mean() < (1.0 - SLIGHT) * best.unseen.mean() else best
    before = unseen(context, state.hypothesis, column)
    best = _refined(context, best, column, found)
    if not _wins(before, best.unseen, misfit):
        return state
    return costed_on(state, best.hypothesis, column)


def _refined(context: Context, best: Judged, column: int, found: list[Source]) -> Judged:
    """With names of a column in forms that have more to them, where those are clearly better beside banks:
    before, others may have stood in for them.
    """
    for name in _names(best.hypothesis, column):
        kind, term = effect(name), best.hypothesis[name]
        if term.columns != [column] or term.form in kind.refined or name in context.known:
            continue
        shown = shown_forms(kind, context, term.columns)
        for form in [f for f in kind.refined if f in shown and f not in kind.shaking]:
            for trial in refinements(best.hypothesis, name, form):
                judged = _refitted(context, trial, column, found)
                there = not hidden(context, judged.hypothesis[name])
                if there and clearly(best.unseen, judged.unseen, SLIGHT):
                    best = judged
    return best


def _wins(before: Array, after: Array, misfit: float) -> bool:
    """Whether the power that is left in blocks that nothing was fitted to is clearly less than before, and
    little of the misfit.
    """
    return clearly(before, after, SLIGHT) and float(after.mean()) - 1.0 < HALF * misfit


def clearly(before: Array, after: Array, share: float) -> bool:
    """Whether the mean power of blocks (CUTS,) is less than before by a ``share``, and by more than the
    blocks' scatter.
    """
    gain = before - after
    error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain))
    return bool(gain.mean() > max(share * float(before.mean()), NOTABLE * error))


@dataclass(frozen=True)
class Judged:
    """An hypothesis, and what it leaves of blocks that it was not fitted to, (CUTS,) mean squares."""

    hypothesis: Hypothesis
    unseen: Array


def _lean(context: Context, hypothesis: Hypothesis, column: int, found: list[Source]) -> Judged:
    """The hypothesis with banks on a column, and without its own effects that the banks make superfluous; a
    zero of a sensor is none of these, as others follow where a bank takes the joint.
    """
    best = _refitted(context, hypothesis, column, found)
    while True:
        kinds = {n: effect(n) for n in _names(best.hypothesis, column) if n not in context.known}
        trials = [
            _refitted(context, best.hypothesis.without(name, column), column, found)
            for name, kind in kinds.items()
            if not (kind.everywhere or kind.shifts_readings)
        ]
        least = min(trials, key=lambda t: float(t.unseen.mean()), default=None)
        if least is None or least.unseen.mean() > (1.0 + HARDLY) * best.unseen.mean():
            return best
        best = least


def _names(hypothesis: Hypothesis, column: int) -> list[str]:
    return [term.effect for term in without_banks(hypothesis, column).on(column)]


def _refitted(context: Context, hypothesis: Hypothesis, column: int, found: list[Source]) -> Judged:
    """Named values of a column fitted, and banks on what they leave."""
    bare = fit(context, without_banks(hypothesis, column), [column]).hypothesis
    out = drawn(context, bare, column, found)
    return Judged(out, unseen(context, out, column))


def unseen(context: Context, hypothesis: Hypothesis, column: int) -> Array:
    """(CUTS,) mean squares of blocks of time, by named values and banks that were fitted to the others; what
    a wide loop does before its first turn is fitted where it counts, and not judged.
    """
    late = [view.span.late[:, column] for view in context.views]
    out, cuts = np.zeros(CUTS), Cuts.of([int(np.count_nonzero(rows)) for rows in late])
    numbers = _everywhere(late, cuts)
    for fold in np.unique(cuts.fold):
        judged = cuts.fold == fold
        here = [rows & judged[number] for rows, number in zip(late, numbers, strict=True)]
        seen = context.only([~rows for rows in here])
        fitted = fit(seen, without_banks(hypothesis, column), [column]).hypothesis
        if column in context.stage.one_way:
            fitted = redrawn(seen, fitted, column)
        fitted = redrawn_banks(seen, fitted, column, hypothesis)
        valid = [view.span.valid[:, column] for view in context.views]
        counted = np.concatenate([rows[there] for rows, there in zip(late, valid, strict=True)])
        power = context.whitened(fitted, column)[counted] ** 2
        out[judged] = _by_blocks(power, cuts)[judged]
    return out


def _everywhere(late: list[np.ndarray], cuts: Cuts) -> list[np.ndarray]:
    """(n,) number of the block that each row of a span is in, by what is judged before it."""
    before = np.maximum(np.cumsum(np.concatenate(late)) - 1, 0)
    return np.split(cuts.number[before], np.cumsum([len(rows) for rows in late])[:-1])


def _by_blocks(power: Array, cuts: Cuts) -> Array:
    """(CUTS,) means of what is judged (rows,) over the blocks."""
    total, many = np.bincount(cuts.number, power, CUTS), np.bincount(cuts.number, minlength=CUTS)
    return np.asarray(total / np.maximum(many, 1))
