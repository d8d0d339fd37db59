"""Gearbox angle to joint reading, as a stage to be diagnosed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.data.seen import beside
from trunk_ros.data.span import Span
from trunk_ros.data.surroundings import View, following
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.disturbances.stood import Read, begun, held
from trunk_ros.diagnosis.disturbances.swung import swung
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term, bind_column, payload_of
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.stages.side_by_side import Seen, bind_together
from trunk_ros.diagnosis.stages.stage import Sight, Stage
from trunk_ros.effects import effect
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.moments import Payload
from trunk_ros.levels import ROUGH
from trunk_ros.model import Model
from trunk_ros.stage import Order, wire_pass
from trunk_ros.start import Driven, first_rows, history

SHAKEN = 40  # joint-steps that one of joints costs which shake each other
STOOD = 40  # steps that a stand is looked at


class WireStage(Stage):
    """Gearbox angle to joint reading."""

    name = "wire"

    def _load(self, spans: Sequence[Span]) -> None:
        super()._load(spans)
        self._stands: dict[tuple[str, int], tuple[Array, tuple[int, ...], Read]] = {}

    def predict(self, sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> Array:
        return self._swinging(sight, index, hypothesis, column)[0]

    def swings(self, sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> Array:
        if not _swings(sight, index, hypothesis, column):
            return super().swings(sight, index, hypothesis, column)
        return self._swinging(sight, index, hypothesis, column)[1]

    def _swinging(self, sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> tuple[Array, Array]:
        payload, blocks = payload_of(hypothesis), hypothesis.bound(column)
        shown, _ = self._passed(sight, index, column, payload, blocks)
        span, now = sight.views[index].span, sight.now(index, column, payload)
        return swung(span, column, now, blocks, span.measured(shown[:, 0]))

    def _predict_alike(self, sight: Sight, index: int, pairs: Sequence[Seen]) -> Sequence[Array]:
        hypothesis, column = pairs[0]
        payload, blocks = payload_of(hypothesis), bind_together(pairs) if len(pairs) > 1 else []
        if not blocks:
            return super()._predict_alike(sight, index, pairs)
        shown, _ = self._passed(sight, index, column, payload, blocks, len(pairs))
        span, now = sight.views[index].span, sight.now(index, column, payload)
        out = [span.measured(each) for each in shown.T]
        return [
            swung(span, column, now, some.bound(column), one)[0] if _free(some, column) else one
            for one, (some, _) in zip(out, pairs, strict=True)
        ]

    def path(self, sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> Array:
        """(m,) the joint's own angle that a hypothesis predicts, at all steps of a span."""
        payload, blocks = payload_of(hypothesis), hypothesis.bound(column)
        return np.ascontiguousarray(self._passed(sight, index, column, payload, blocks)[1][:, 0])

    def _passed(
        self, sight: Sight, index: int, column: int, payload: Payload, blocks: list[Effect], times: int = 1
    ) -> tuple[Array, Array]:
        """The joint's reading and its own angle (m, times), by blocks that have so many columns."""
        span, order = sight.views[index].span, Order.of(blocks)
        width = self.arm.dead_band[None, column : column + 1].repeat(times, axis=1)
        now = beside(sight.now(index, column, payload), times)

        def lies(u: Array, scale: Array | None, core: Core) -> Any:
            rows, read = self._stand(span, column)
            swings = any(block.form in block.dear for block in blocks)
            each = tuple(range(rows[-1] + 1)) if swings else rows

            def stood() -> Now:
                return beside(sight.now(index, column, payload, each), times)

            some = list(rows)
            if swings or core.rounding is not None:
                return begun(stood(), order, width, read, some if swings else slice(None))
            came = u[some] if scale is None else u[some] * scale
            wide = core.width[some] if len(core.width) > 1 else core.width
            behind = stood() if order.after or order.sensor else None
            return held(came, core, wide, order, behind, read, slice(None))

        core = Core(nominal_width=width, width=width)
        shown, true, _ = wire_pass(
            now.gearbox, now, order, core, None, lies if len(span.start[column]) else None
        )
        return shown, true

    def _stand(self, span: Span, column: int) -> tuple[tuple[int, ...], Read]:
        """Steps (k,) over the time in which a motor stands as it began, the first of all at first, and what
        the joint's sensor reads until each.
        """
        known = self._stands.get((span.name, column))
        if known is None or known[0] is not span.target:
            seen = span.start[column]
            chosen = seen[np.linspace(0, len(seen) - 1, min(len(seen), STOOD)).astype(int)]
            rows = np.unique(np.concatenate([[0], span.rows[chosen]]))
            until = np.maximum(np.searchsorted(span.rows[seen], rows, "right"), 1)
            since = np.concatenate([[0], np.minimum(until[:-1], until[1:] - 1)])
            known = span.target, tuple(rows.tolist()), Read.of(span.target[seen, column], until, since)
            self._stands[span.name, column] = known
        return known[1:]

    def seen(self, sight: Sight, hypothesis: Hypothesis) -> tuple[View, ...]:
        columns = range(len(self.joints))
        if hypothesis.shakes:
            chain = _chain(self.arm, hypothesis)
            paths = [_together(chain, view.span) for view in sight.views]
            sight.work.done += SHAKEN * sum(path.size for path in paths)
        else:
            paths = [
                np.column_stack([self.path(sight, index, hypothesis, c) for c in columns])
                for index in range(len(sight.views))
            ]
        pairs = list(zip(sight.views, paths, strict=True))
        same = ROUGH**2 if hypothesis.shakes else ROUGH  # what shakes links goes by the angles' curvature
        if all(view.apart(path) <= same * np.ptp(path) for view, path in pairs):
            return sight.views
        return tuple(view.turned(path, ROUGH if hypothesis.shakes else 0.0) for view, path in pairs)


def _swings(sight: Sight, index: int, hypothesis: Hypothesis, column: int) -> bool:
    """Whether a hypothesis lets a joint swing by what nobody saw."""
    free = _free(hypothesis, column)
    if not free:
        return False
    now = sight.now(index, column, payload_of(hypothesis))
    return any(bind_column(term, column).transients(now) is not None for term in free)


def _free(hypothesis: Hypothesis, column: int) -> list[Term]:
    """What a hypothesis has on a joint that may swing or creep by what nobody saw."""
    return [term for name, term in hypothesis.items() if column in term.own and _may_swing(name)]


@cache
def _may_swing(name: str) -> bool:
    """Whether an effect knows of free swings at all: asked at each prediction."""
    return effect(name).transients is not Effect.transients


def _chain(arm: Arm, hypothesis: Hypothesis) -> Chain:
    """All joints at once."""
    return Chain(Model(arm, hypothesis.model_effects(len(arm.joints))), "wire")


def _together(chain: Chain, span: Span) -> Array:
    """(m, joints) angles of joints that move each other."""
    return chain.angles(span.gearbox, span.grid, span.velocity, span.resistance)


def settled(state: Fit, seconds: float) -> Fit:
    """Fitted with recordings that stop to measure beginning as a hypothesis says that their wires lay, going
    by the joint angles of the first ``seconds``.
    """
    looked = _starting(state, seconds, lambda span: span.before > 0 and span.early is None)
    return state if looked is None else refit(looked, state.hypothesis)


def opened(state: Fit, seconds: float) -> Fit | None:
    """Fitted from the start on also where loops are wide, with joints that lay as a hypothesis says; None
    where there are none.
    """
    looked = _starting(state, seconds, lambda span: span.early is not None)
    return None if looked is None else refit(looked, state.hypothesis)


def _starting(state: Fit, seconds: float, begins: Callable[[Span], bool]) -> Context | None:
    context = state.context
    if seconds <= 0.0 or not any(begins(view.span) for view in context.views):
        return None
    chain = _chain(context.arm, state.hypothesis)
    views = [_with_a_start(chain, view, seconds) if begins(view.span) else view for view in context.views]
    return context.viewing(views).seen_with(state.hypothesis)


def _with_a_start(chain: Chain, view: View, seconds: float) -> View:
    span = view.span
    early = np.zeros_like(span.valid) if span.early is None else span.early
    valid, told = span.valid | early, np.asarray(early.any(axis=0) | (span.early is None))
    path = span.gearbox.copy()
    path[: span.before] += _history(chain, replace(span, valid=valid & told), seconds) / chain.arm.ratio
    start = tuple(
        stood[:0] if by_history else stood for stood, by_history in zip(span.start, told, strict=True)
    )
    span = replace(span, source=path, gearbox=path, valid=valid, start=start)
    return replace(view, span=span, told=view.angles, posture=view.angles, follows=following(valid))


def _history(chain: Chain, span: Span, seconds: float) -> Array:
    """(before, joints) rad that the motors came from, by what counts of the first ``seconds``."""
    before, seen = span.before, first_rows(span.stamp, seconds)
    angles = np.where(span.valid, span.target, np.nan)[:seen]
    known = None if span.resistance is None else span.resistance.part(slice(before, None))
    rows = span.rows[:seen] - before
    driven = Driven(span.gearbox[before:], span.grid[before:], rows, angles, span.velocity[before:], known)
    return history(chain, driven)
