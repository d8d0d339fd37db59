"""The values that an effect may start with on a joint."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.size import different
from trunk_ros.effects import Effect
from trunk_ros.levels import SEVERAL
from trunk_ros.machine import precision
from trunk_ros.parameter import leading

SHARES = (0.05, 0.15, 0.3)  # of the motion: half-widths of wide loops that a fit starts at


def whens(hypothesis: Hypothesis, kind: type[Effect], form: str, column: int) -> list[dict[str, float]]:
    """The moments of an effect on other joints: what happened to them may have happened to a further one."""
    others = hypothesis[kind.id].own if kind.id in hypothesis else {}
    lasting = kind.moments()
    names = [p.name for p in kind.used(form) if not p.shared and (p.moment or p in lasting)]
    found = [{n: own[n] for n in names if n in own} for c, own in others.items() if c != column]
    return different([when for when in found if when])


class Starts:
    """Of effects beside a hypothesis, on some columns."""

    def __init__(self, context: Context, hypothesis: Hypothesis, columns: Iterable[int]):
        self.context, self.hypothesis = context, hypothesis
        self._telling = {c: context.telling(c)[:SEVERAL] for c in columns}
        self._left = {  # beforehand: what is left counts as work once, on any number of cores
            (c, k): self._residual(c, k) for c in columns if c not in context.wide for k in self._telling[c]
        }

    def _residual(self, column: int, index: int) -> Array:
        """(m,) residual of a recording over its whole grid."""
        span = self.context.views[index].span
        valid = span.valid[:, column]
        off = self.context.residual(index, self.hypothesis, column)[valid]
        rest = np.interp(span.grid, span.stamp[valid], off) if valid.any() else np.zeros(len(span.grid))
        return np.asarray(rest, precision(len(rest)))

    def on(self, kind: type[Effect], form: str, column: int) -> list[dict[str, Any]]:
        """Where an effect may begin on a column, by the recordings with most to explain."""
        return different([s for k in self._telling[column] for s in self._in(k, kind, form, column)])

    def _in(self, index: int, kind: type[Effect], form: str, column: int) -> Iterator[dict[str, Any]]:
        context = self.context
        rest = np.asarray(self._left[column, index], float) if (column, index) in self._left else None
        begun = kind({}, {}, form).starts(context.shown(column, index), 0, rest)
        options = ({},) if kind.id in self.hypothesis else kind.options(form)  # others share what is there
        both = [{**start, **option} for option in options for start in begun]
        others = [{**start, **when} for when in whens(self.hypothesis, kind, form, column) for start in both]
        if kind.scalable:  # a look scales it by itself
            lead = leading(kind.own_parameters(form)).name
            others = list({tuple((n, v) for n, v in s.items() if n != lead): s for s in others}.values())
        for start in different([*both, *others]):
            if not kind.texts:
                yield start
                yield from self._wide(index, kind, form, column, start)
                continue
            words = self.hypothesis.get_words(kind.id, column)
            for joint in context.joints:
                if joint != context.joints[column] and joint not in words:
                    yield {**start, kind.texts[0]: joint}

    def _wide(
        self, index: int, kind: type[Effect], form: str, column: int, start: dict[str, Any]
    ) -> Iterator[dict[str, Any]]:
        """Starts far from null for what makes a wide loop: a linear look does not reach that far."""
        if column in self.context.wide and kind.regime == "reversal":
            now, lead = self.context.now(index, column), kind.own_parameters(form)[0]
            for share in SHARES:
                yield {**start, lead.name: share * float(np.ptp(now.gearbox) * now.ratio[0])}
