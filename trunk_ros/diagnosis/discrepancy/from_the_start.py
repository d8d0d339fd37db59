"""Banks with and without what wide loops do before their first turn, when it is not known how they lay."""

from __future__ import annotations

from trunk_ros.diagnosis.discrepancy.banked import unseen, with_banks
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.stages.wire import opened, settled
from trunk_ros.levels import SLIGHT


def from_the_start(state: Fit, seconds: float) -> Fit:
    """The hypothesis with the banks that it needs, fitted from the start on to what a wide loop does not do
    again, where what comes later is predicted as well as without.

    How it lay is told by the joint angles of the first ``seconds``. One that had never been moved so far may
    go another way than ever again.
    """
    plain, whole = with_banks(settled(state, seconds)), opened(state, seconds)
    columns = _early(state)
    if whole is None or not columns:
        return plain
    banked = with_banks(whole)
    return banked if all(_left(banked, c) <= (1.0 + SLIGHT) * _left(plain, c) for c in columns) else plain


def _early(state: Fit) -> list[int]:
    """Columns that do something before their first turn and not again."""
    spans = [view.span for view in state.context.views if view.span.early is not None]
    return [
        c for c in state.context.columns if any(s.early[:, c].any() for s in spans if s.early is not None)
    ]


def _left(state: Fit, column: int) -> float:
    """What is left of blocks not seen [rad^2]."""
    return (
        float(unseen(state.context, state.hypothesis, column).mean()) * state.context.noise[column].std ** 2
    )
