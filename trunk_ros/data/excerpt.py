"""A part of a long recording that stands for the whole while effects are searched for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trunk_ros.chain import REMEMBERED
from trunk_ros.compiled import Array
from trunk_ros.data.align import SETTLING
from trunk_ros.data.motion_content import MOVED, extent
from trunk_ros.data.span import Span
from trunk_ros.levels import MOST, ROWS
from trunk_ros.recording.signal.resample import FINE, LONGEST_GAP

PARTS = 6
LENGTH = 50.0  # s of a block
WARM = 15.0  # s of it after which it has forgotten what went before
STRETCH = 10.0  # s: to and fro, of what forgets at once
FORGOTTEN = REMEMBERED + SETTLING  # s of a stretch after which a servo has forgotten what went before
LONG = 2.0  # times all blocks, from which on a recording is not searched as a whole


def excerpt(span: Span) -> Span:
    """Blocks spread over a span, with their own stamps and gaps between them; a short span as it is.

    The first block begins with the recording, the last one ends with it.
    """
    time = recorded_time(span.grid)
    length = max(LENGTH, ROWS * _usual(np.diff(time)))
    if time[-1] < LONG * PARTS * length:
        return span
    starts = np.linspace(0.0, time[-1] - length, PARTS)
    steps = [slice(*np.searchsorted(time, (s, s + length)).tolist()) for s in starts]
    steps = [step for step in steps if step.start < step.stop]
    chosen = np.zeros(len(span.grid), dtype=bool)
    forgotten = np.zeros(span.gearbox.shape, dtype=bool)
    for step in steps:
        chosen[step] = True
    for step in steps[1:]:
        forgotten[step] = ~_warm(time[step], span.gearbox[step], np.ptp(span.gearbox, axis=0))
    return taken(span, chosen, forgotten)


def sparser(spans: Sequence[Span]) -> tuple[list[Span], int] | None:
    """Recordings of an arm's wires with one of so many readings, and of how many: those of which all joints
    together have more steps than a joint of a long recording, with steps that are as far apart as a model may
    be computed. None for others.
    """
    if sum(span.gearbox.size for span in spans) < LONG * PARTS * ROWS:
        return None
    read, computed = (
        min((max(1, int(FINE / step)) for time in times if (step := _mean_step(time)) > 0.0), default=1)
        for times in ([span.stamp for span in spans], [span.grid for span in spans])
    )
    if computed == 1:
        return None
    fewer = [_sparser(span, read, computed) for span in spans]
    few = sum(len(span.grid) for span in fewer) <= MOST * sum(len(span.grid) for span in spans)
    return (fewer, read) if few else None


def _mean_step(time: Array) -> float:
    """The mean of the steps between stamps (n,) s, gaps left out: readings may come in packets."""
    return float(recorded_time(time)[-1]) / (len(time) - 1) if len(time) > 1 else 0.0


def _sparser(span: Span, read: int, computed: int) -> Span:
    """One of so many readings of a span, with one of so many steps."""
    kept = replace(
        span,
        rows=span.rows[::read],
        target=span.target[::read],
        valid=span.valid[::read],
        start=tuple(rows[rows % read == 0] // read for rows in span.start),
        early=None if span.early is None else span.early[::read],
    )
    chosen = np.zeros(len(span.grid), dtype=bool)
    chosen[: span.before] = chosen[kept.rows] = chosen[::computed] = True
    return taken(kept, chosen, np.zeros(span.gearbox.shape, dtype=bool))


def moving(spans: Sequence[Span], column: int) -> list[Span]:
    """The stretches, each a span of its own, in which a joint was asked to go furthest; none where all that
    was recorded is not much more.
    """
    times = [recorded_time(span.grid) for span in spans]
    if sum(float(time[-1]) for time in times) < LONG * PARTS * STRETCH:
        return []
    cut = [(s, time // STRETCH == k) for s, time in zip(spans, times, strict=True)
           for k in np.unique(time // STRETCH)]  # fmt: skip
    far = [float(np.abs(np.diff(span.source[rows, column])).sum()) for span, rows in cut]
    chosen = [cut[k] for k in sorted(np.argsort(far)[-PARTS:].tolist())]
    return [taken(span, rows, _begins(span, rows)) for span, rows in chosen]


def _begins(span: Span, rows: np.ndarray) -> np.ndarray:
    """(m, joints): where the ``rows`` (m,) of a span begin: what went before is not known."""
    early = span.grid < span.grid[rows][0] + FORGOTTEN
    return np.repeat(early[:, None], span.gearbox.shape[1], axis=1)


def recorded_time(grid: Array) -> Array:
    """(m,) s since the first of the stamps (m,), without the gaps in which nothing was recorded."""
    step = np.diff(grid)
    if not len(step):
        return np.zeros(len(grid))
    return np.concatenate([[0.0], np.cumsum(np.minimum(step, max(LONGEST_GAP, 4.0 * _usual(step))))])


def _usual(steps: Array) -> float:
    """The usual one of time steps (k,) s, without those in which no time goes by."""
    some = steps[steps > 0.0]
    return float(np.median(some)) if len(some) else 0.0


def taken(span: Span, chosen: np.ndarray, forgotten: np.ndarray) -> Span:
    """The ``chosen`` (m,) steps of a span; those that are ``forgotten`` (m, joints) do not count."""
    seen, at = chosen[span.rows], np.cumsum(chosen) - 1
    arrives = span.arrives
    whole = chosen[arrives - 1] & chosen[arrives] & chosen[arrives + 1]
    known = span.resistance
    return replace(
        span,
        grid=span.grid[chosen],
        source=span.source[chosen],
        velocity=span.velocity[chosen],
        rows=at[span.rows[seen]],
        target=span.target[seen],
        valid=(span.valid & ~forgotten[span.rows])[seen],
        gearbox=span.gearbox[chosen],
        start=tuple(rows[seen[rows]] for rows in span.start),
        resistance=None if known is None else known.part(chosen),
        arrives=at[arrives[whole]],
        early=None if span.early is None else span.early[seen],
    )


def _warm(time: Array, gearbox: Array, reach: Array) -> np.ndarray:
    """(m, joints) where a block counts: after some time, and once a joint has moved in it."""
    return np.asarray((extent(gearbox) > MOVED * reach) & (time > time[0] + WARM)[:, None])
