"""What set a link going that nobody saw leaves it swinging, by its own frequency and as it is damped. How far
no recording tells beforehand: it is as far as was measured.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.data.span import Span
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.guards import ROUNDED


def swung(span: Span, column: int, now: Now, blocks: Sequence[Effect], shown: Array) -> tuple[Array, Array]:
    """The prediction (n,) rad with the free swings of a column, which was ``shown`` (n,) without; and the sum
    of squares (k,) of each where it counts, of which nothing says how far it goes.
    """
    far = [np.empty(0)]
    for block in blocks:
        swings = block.transients(now)
        if swings is not None:
            which = np.searchsorted(swings.moments, span.stamp, side="right") - 1
            shown, squares = shown.copy(), np.zeros(len(swings.moments))
            off = span.target[:, column] - shown
            valid = span.valid[:, column]
            _swing(swings.ways(span.stamp), which, swings.most, off, valid, shown, squares)
            far.append(squares)
    return shown, np.concatenate(far)


@compiled
def _swing(
    ways: Array, which: np.ndarray, most: Array, off: Array, valid: np.ndarray, shown: Array, squares: Array
) -> None:
    """Least squares of what is ``off`` (n,) by two ``ways`` (n, 2) from each moment on, or by the first where
    there is no other, each by ``most`` (k,) at most; ``which`` (n,) was the last one, -1 before all.
    """
    begin = 0
    while begin < len(off):
        moment, end = which[begin], begin
        aa, ab, bb, at, bt = 0.0, 0.0, 0.0, 0.0, 0.0
        while end < len(off) and which[end] == moment:
            if valid[end]:
                a, b = ways[end]
                aa, ab, bb, at, bt = aa + a * a, ab + a * b, bb + b * b, at + a * off[end], bt + b * off[end]
            end += 1
        det = aa * bb - ab * ab
        if moment >= 0 and aa > ROUNDED and (bb == 0.0 or det > ROUNDED * (aa + bb) ** 2 + ROUNDED):
            first, second = at / aa, 0.0
            if bb > 0.0:
                first, second = (at * bb - bt * ab) / det, (bt * aa - at * ab) / det
            first = min(max(first, -most[moment]), most[moment])
            second = min(max(second, -most[moment]), most[moment])
            squares[moment] = max(
                first * (2.0 * at - first * aa - 2.0 * second * ab) + second * (2.0 * bt - second * bb), 0.0
            )
            for k in range(begin, end):
                shown[k] += first * ways[k, 0] + second * ways[k, 1]
        begin = end
