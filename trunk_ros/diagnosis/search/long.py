"""Recordings too long, or too often read, to try everything on all of it: effects are chosen on an excerpt,
fitted and judged on the whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.data.excerpt import excerpt
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search.descent import Desk, descend
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.greedy import begun, plain, search
from trunk_ros.diagnosis.search.looked_again import renewed
from trunk_ros.diagnosis.search.moves import ADD, DROP, ONSET
from trunk_ros.diagnosis.search.moves.onset import REACH, moments, moved
from trunk_ros.diagnosis.search.score import beats
from trunk_ros.diagnosis.search.windows import EDGES
from trunk_ros.diagnosis.sparse import Sparse, noise_of_every, sparse
from trunk_ros.heap import give_back

WORK = 1.2e8  # simulated joint-steps that a search may take: eight seconds of one core
EACH = 0.5 * WORK  # more for each effect that it finds


def granted() -> Work:
    """What a search may take."""
    return Work(WORK, each=EACH)


@dataclass(frozen=True)
class Searched:
    """What was found: ``state`` on the whole, and ``part`` on what rivals are fitted to."""

    state: Fit
    part: Fit
    early: bool
    """Whether the work that was granted ended before the search did."""


def searched(context: Context, say: Callable[[str], None]) -> Searched:
    """The hypothesis of a stage."""
    context = replace(context, work=granted())
    spans = [view.span for view in context.views]
    parts = [excerpt(span) for span in spans]
    whole = all(part is span for part, span in zip(parts, spans, strict=True))
    some = sparse(context if whole else context.over(parts))
    if some is context:
        state = search(context, Desk(say))
        return Searched(state, state, context.work.over)
    give_back(libraries=True)
    first = search(replace(some, work=granted()), Desk(lambda text: say(f"excerpt: {text}")))
    first.context.forget()  # nobody asks for it until rivals are fitted
    context = replace(context, wide=first.context.wide)
    say("the whole recording")
    give_back(libraries=True)
    state = _on_the_whole(context, first.hypothesis, Desk(lambda text: _tidied(say, text)))
    noise = (
        noise_of_every(state.context.noise, some.every) if isinstance(some, Sparse) else state.context.noise
    )
    some = first.context.seen_with(state.hypothesis).in_noise(noise)
    return Searched(state, refit(some, state.hypothesis), context.work.over or first.context.work.over)


def _on_the_whole(context: Context, found: Hypothesis, desk: Desk) -> Fit:
    """Fitted to all of it, without what that does not need, and with what only that shows."""
    context.work.finds(len(found) - len(context.known))
    weights = begun(context).context
    now = renewed(refit(weights, found))
    context.forget()  # at other angles
    now = _anywhere(now)
    return plain(descend(now, (ONSET, DROP, ADD), desk, steady=True))


def _tidied(say: Callable[[str], None], text: str) -> None:
    give_back()
    say(text)


def _anywhere(now: Fit) -> Fit:
    """What happens at one moment, moved to where it fits best: an excerpt only shows between which blocks."""
    grids = [view.span.grid for view in now.context.views]
    first, end = min(float(grid[0]) for grid in grids), max(float(grid[-1]) for grid in grids)
    step = (end - first) / EDGES
    every = np.linspace(first, end, EDGES + 1)[1:-1]
    for moment in list(moments(now)):
        rough = _better(now, moved(now, moment, every))
        begin = moment.home(rough.hypothesis)[moment.name]
        near = np.arange(begin - step, begin + step, REACH, dtype=np.float64)
        now = _better(rough, moved(rough, moment, near))
    return now


def _better(now: Fit, trial: Fit) -> Fit:
    return trial if beats(trial, now) else now
