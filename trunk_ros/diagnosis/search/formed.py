"""What a first fit leaves, by which all else is measured: of it what formulas of effects may be off by."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.derivatives import gradient
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import Candidate, extended, local_kinds
from trunk_ros.diagnosis.search.fit import Fit, costed, fit
from trunk_ros.effects import effect
from trunk_ros.guards import ROUNDED
from trunk_ros.levels import CLEARLY, FAR_OFF, HALF, PART, SEVERAL, SLIGHT
from trunk_ros.machine import pieces

FORMULAS = 0.001
"""Of a joint's misfit: what the formulas of named effects may be off by, 3 % of their size. On arms that go
by other laws, what was said beside the right names explained up to 0.0008.
"""


def measured(first: Fit) -> Context:
    """The context of a first fit, in which all else is measured by what that leaves; what formulas may be off
    by in the noise that the right ratios leave: by others the motors' noise may hide all of it.
    """
    context, misfit = first.context, {c: first.rest(c) for c in first.cost}
    right = with_ratios(first)
    heard = context if right is context.known else context.weighed(right)
    louder = [(there.std / here.std) ** 2 for there, here in zip(heard.noise, context.noise, strict=True)]
    formed = formed_misfits(first if heard is context else costed(heard, first.hypothesis))
    return replace(context, misfit=misfit, formed_misfit={c: m * louder[c] for c, m in formed.items()})


def with_ratios(first: Fit) -> Hypothesis:
    """What the model knows, with the right ratio and zero of joints whose ratio it does not know at all, by
    what a first fit leaves.
    """
    context, out = first.context, first.context.known
    kinds = [k for k in local_kinds(context) if k.of_every_joint and k.id not in out]
    far = [c for c in first.cost if _is_far_off(*_rest_and_line(first, c))] if kinds else []
    for column in far:
        for kind in kinds:
            start = {p.name: p.null for p in kind.parameters}
            out = extended(context, out, Candidate(kind.id, kind.forms[0], column, start))
    return fit(context, out, far).hypothesis if far else out


def but_for_a_zero(context: Context, column: int, rest: Array) -> Array:
    """A whitened ``rest`` (rows,) of a column with the right zero: how far a sensor's is off is no law."""
    zero = context.whiten_change([np.ones(len(view.span.rows)) for view in context.views], column)
    return np.asarray(rest - (rest @ zero) / max(float(zero @ zero), ROUNDED) * zero)


def formed_misfits(first: Fit) -> dict[int, float]:
    """What formulas can be off in proportion to: what a fit leaves of each column above the noise, in squared
    unit-noise residuals, with the right zero, as a constant has no formula; where the ratio is FAR_OFF, with
    the right one of that as well; and where one lag of all joints leaves hardly a PART of that, without it:
    what is late, a reading or a setpoint, has no formula either.
    """
    context = first.context
    seen = {c: _rest_and_line(first, c) for c in first.cost}
    left = {c: min(first.rest(c), _right_line(context, c, *both)) for c, both in seen.items()}
    if len(seen) < SEVERAL:
        return left
    lag = np.median([np.linalg.lstsq(line, rest, rcond=ROUNDED)[0][2] for rest, line in seen.values()])
    prompt = {c: _right_line(context, c, rest - lag * line[:, 2], line) for c, (rest, line) in seen.items()}
    late = sum(prompt.values()) < PART * sum(left.values())
    return {c: min(left[c], prompt[c]) for c in left} if late else left


def off_by(context: Context, column: int) -> float:
    """Squared unit-noise residual of a column by which the model's own laws may be off."""
    if column not in context.off:
        wire = context.stage.name == "wire"
        off = SLIGHT * law_of(context, column) if wire else CLEARLY * behind(context, column)
        context.off[column] = float(off @ off)
    return context.off[column]


def law_of(context: Context, column: int) -> Array:
    """(rows,) what the laws of the model itself make of a wire, whitened and with the right zero: the play of
    its dead band and the effects that it has, but for geometry. Arms keep to them roughly, and who describes
    an arm rounds.
    """
    exact = Hypothesis({name: term for name, term in context.known.items() if effect(name).exact})
    changes = []
    for index, view in enumerate(context.views):
        known, geometry, bare = (
            context.stage.predict(context, index, one, column) for one in (context.known, exact, Hypothesis())
        )
        asked = view.span.measured(view.span.source[:, column]) * context.arm.ratio[column]
        changes.append(known - geometry + bare - asked)
    return but_for_a_zero(context, column, context.whiten_change(changes, column))


def behind(context: Context, column: int) -> Array:
    """(rows,) by how much a loop that goes on all the time is behind one in the stage's own steps, whitened:
    in proportion to the speed that the model predicts, not with each setpoint's step.
    """
    speeds = []
    for index, view in enumerate(context.views):
        went = context.stage.predict(context, index, context.known, column)
        speeds.append(-context.stage.ahead * gradient(went, view.span.stamp))
    return context.whiten_change(speeds, column)


def but_for_a_lag(context: Context, column: int, rest: Array) -> Array:
    """A whitened ``rest`` (rows,) of a servo without what a loop may be later, or earlier, than its model
    is described.
    """
    later = behind(context, column)
    share = float(rest @ later) / max(float(later @ later), ROUNDED)
    return np.asarray(rest - np.clip(share, -HALF, CLEARLY) * later)


def _right_line(context: Context, column: int, rest: Array, line: Array) -> float:
    """What a ``rest`` (rows,) has above the noise with the right zero, and the right ratio where that was
    not known.
    """
    line = line[:, (0 if _is_far_off(rest, line) else 1) : 2]
    found = np.linalg.lstsq(line, rest, rcond=ROUNDED)[0]
    return max(float(np.sum((rest - line @ found) ** 2)) - context.count(column), 0.0)


def _is_far_off(rest: Array, line: Array) -> bool:
    """Whether by a ``rest`` (rows,) the ratio is another one by far."""
    return bool(abs(np.linalg.lstsq(line[:, :2], rest, rcond=ROUNDED)[0][0]) > FAR_OFF)


def _rest_and_line(fit: Fit, column: int) -> tuple[Array, Array]:
    """(4,) what is left of a column, and (4, 3) its line: in the few coordinates in which all of them lie."""
    both = [*_line(fit, column), fit.context.whitened(fit.hypothesis, column)]
    few = np.empty((0, len(both)))
    for rows in pieces(len(both[0]), len(both)):
        piece = np.column_stack([one[rows] for one in both])
        few = np.asarray(np.linalg.qr(np.concatenate([few, piece]) if len(few) else piece, mode="r"))
    return few[:, -1], few[:, :-1]


def _line(fit: Fit, column: int) -> Iterator[Array]:
    """What another ratio, zero and time of reading change (rows,), whitened: per 1, rad and s."""
    context = fit.context
    ratio = context.arm.ratio[column] if context.stage.name == "wire" else 1.0
    spans = [view.span for view in context.views]
    yield context.whiten_change([span.measured(span.gearbox[:, column]) * ratio for span in spans], column)
    yield context.whiten_change([np.ones(len(span.rows)) for span in spans], column)
    yield context.whiten_change([-span.measured(span.velocity[:, column]) * ratio for span in spans], column)
