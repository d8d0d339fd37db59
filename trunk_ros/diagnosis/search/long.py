"""Recordings too long to try everything on all of it: effects are chosen on an excerpt, fitted and judged on
the whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.diagnosis.data.excerpt import excerpt
from trunk_ros.diagnosis.evidence.evidence import Evidence, evidence, one_evidence
from trunk_ros.diagnosis.search import revise
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.greedy import Progress, Search
from trunk_ros.diagnosis.stage import Problem

SCAN = 160  # moments over the whole recording, then as many between two of them
FURTHER = 3  # effects that only the whole shows


@dataclass
class Searched:
    """What was found: ``state`` on the whole by ``search``, and the search in which rivals are fitted."""

    search: Search
    state: Fit
    part: Search
    part_state: Fit
    found: dict[str, Evidence]


def searched(problem: Problem, say: Progress) -> Searched:
    """The explanation of a stage, and what speaks for it."""
    spans = [view.span for view in problem.views]
    parts = [excerpt(span) for span in spans]
    if all(part is span for part, span in zip(parts, spans, strict=True)):
        search = Search(problem, say)
        state = search.run()
        return Searched(search, state, search, state, evidence(search, state))
    some = problem.over(parts)
    part = Search(some, lambda text: say(f"excerpt: {text}"))
    begun = part.run()
    whole = Search(problem, say)
    say("the whole recording")
    state = _on_the_whole(whole, begun)
    some.look_again(state.explanation)
    some.noise = problem.noise
    again = part.refit(state.explanation)
    part.weigh(again)
    say("rivals")
    found = {
        name: one_evidence(part, again, name)
        if name in begun.explanation
        else one_evidence(whole, state, name)
        for name in state.explanation
    }
    return Searched(whole, state, part, again, found)


def _on_the_whole(search: Search, begun: Fit) -> Fit:
    """Fitted to all of it, without what that does not need, and with what only that shows."""
    search.begin()
    now = _settled(search, begun)
    for _ in range(FURTHER):
        grown = search.grow(now)
        if grown is None:
            break
        now = _settled(search, grown)
    return search.written(now)


def _settled(search: Search, now: Fit) -> Fit:
    search.problem.look_again(now.explanation)
    search.problem.estimate_noise(now.explanation)
    now = revise.moments(search, _anywhere(search, search.refit(now.explanation)))
    search.weigh(now)
    now = revise.drop(search, revise.incredible(search, now))
    search.weigh(now)
    return now


def _anywhere(search: Search, now: Fit) -> Fit:
    """What happens at one moment, moved to where it fits best: an excerpt only shows between which blocks."""
    grids = [view.span.grid for view in search.problem.views]
    first, end = min(float(grid[0]) for grid in grids), max(float(grid[-1]) for grid in grids)
    step = (end - first) / SCAN
    every = np.linspace(first, end, SCAN + 1)[1:-1]
    for term in list(now.explanation.values()):
        for column in [c for c in term.columns if revise.ONSET in term.own[c]]:
            rough = revise.moved(search, now, term.effect, column, every)
            begin = rough.explanation[term.effect].own[column][revise.ONSET]
            near = np.arange(begin - step, begin + step, revise.REACH, dtype=np.float64)
            now = revise.moved(search, rough, term.effect, column, near)
    return now
