"""When an effect that is there begins and ends, and when what the arm carries is taken up and put down."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial

import numpy as np

from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.candidates import extended
from trunk_ros.diagnosis.search.descent import Desk, Group, Move, descend_with, only
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.moves.onset import dated
from trunk_ros.diagnosis.search.moves.option import OPTION, put_down
from trunk_ros.diagnosis.search.moves.spell import SPELL
from trunk_ros.diagnosis.search.score import for_a_time, score
from trunk_ros.diagnosis.search.screen import PROMISED, Screen
from trunk_ros.diagnosis.search.trial import Look, may_win, refitted
from trunk_ros.diagnosis.search.windows import Reach, Window
from trunk_ros.effects import effect
from trunk_ros.effects.moments import LASTING
from trunk_ros.parameter import Parameter

Seen = Callable[[], tuple[Screen, Hypothesis, Window | None]]
"""A look that is made once it is asked for."""


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each effect that may begin, on each of its joints, and each payload."""
    if len(best.context.views) > 1:
        return
    for name, term in best.hypothesis.items():
        for mass in effect(name).carried() if effect(name).begins else ():
            seen = cache(partial(_seen, best, name, mass))
            trials = partial(_taken_up, best, desk, name, mass, seen)
            promise = partial(_promise, best, name, mass, seen)
            yield Group((name, mass.name), best.context.columns, trials, promise)
        taken_up = any(m.name in term.shared for m in effect(name).moments())
        own = effect(name).begins and any(term.own.values()) and not taken_up
        for column in (c for c in term.columns if own and c in best.context.columns):
            if not term.moments(column):
                yield Group((name, column), [column], partial(_for_a_while, best, name, column))


def _for_a_while(now: Fit, name: str, column: int) -> Iterator[Fit]:
    """In the time in which it gains most, where that is not all the time."""
    bare, form = now.hypothesis.without(name, column), now.hypothesis[name].form
    screen = Screen(now.context, bare, [column])
    start = screen.local_form(effect(name), form, column)
    found = start and (screen.lasting(start, [column]) or start)
    if found and any(moment.name in found.start for moment in LASTING):
        there = extended(now.context, bare, found)
        for trial in refitted(now, column, [Look(there, screen.left(column), found.gain)]):
            yield dated(trial, name, column)


def _promise(now: Fit, name: str, mass: Parameter, seen: Seen) -> float:
    """What a mass for a time may gain, and all that may be saved."""
    if _is_timed(now.hypothesis[name], mass):
        return np.inf
    *_, window = seen()
    gain = 0.0 if window is None else window.gain(_reach(mass))
    return score(now) - now.total + gain / PROMISED


def _taken_up(now: Fit, desk: Desk, name: str, mass: Parameter, seen: Seen) -> Iterator[Fit]:
    """With a mass at the tip for the time in which that gains most, judged with the options that follow, and
    what else looks like it: the effect itself that begins on joint after joint.
    """
    if _is_timed(now.hypothesis[name], mass):
        yield _one_by_one(refit(now.context, _without(now.hypothesis, name, mass)), name)
        return
    yield _one_by_one(now, name)
    screen, usual, window = seen()
    if window is None or not may_win(now, usual, screen, window.gain(_reach(mass))):
        return
    there = usual.copy()
    there[name].shared[mass.name] = float(np.clip(mass.typical * window.size, *mass.bounds))
    there[name].shared |= {f"{mass.name}_{when}": t for when, t in window.moments.items()}
    trial = refit(now.context, there, score(now))
    sizes = only(SPELL, (name, None, f"{mass.name}_"))
    least = sum(cost + for_a_time(trial.context, c, cost) for c, cost in trial.cost.items())
    yield descend_with(dated(trial, name), (sizes, OPTION), desk) if least < score(now) else trial


def _one_by_one(now: Fit, name: str) -> Fit:
    """With an effect on each joint in the time in which it gains most there, where that pays."""
    best = now
    for column in now.hypothesis[name].columns:
        if column in now.context.columns:
            best = min([best, *_for_a_while(best, name, column)], key=score)
    return best


def _is_timed(term: Term, mass: Parameter) -> bool:
    """Whether a mass is not always there."""
    return any(name.startswith(f"{mass.name}_") for name in term.shared)


def _without(hypothesis: Hypothesis, name: str, mass: Parameter) -> Hypothesis:
    """A hypothesis in which an effect carries nothing, and acts all the time."""
    bare = hypothesis.copy()
    put_down(bare[name], mass.name)
    for own in bare[name].own.values():
        for moment in LASTING:
            own.pop(moment.name, None)
    return bare


def _seen(now: Fit, name: str, mass: Parameter) -> tuple[Screen, Hypothesis, Window | None]:
    """A look at an effect that carries nothing, the same with the usual mass, and the time in which that
    gains most.
    """
    screen = Screen(now.context, _without(now.hypothesis, name, mass))
    there = screen.hypothesis.copy()
    there[name].shared[mass.name] = mass.typical
    changes = {c: screen.change(there, c) for c in screen.context.columns}
    return screen, there, screen.window(changes, _reach(mass))


def _reach(mass: Parameter) -> Reach:
    return 0.0, mass.bounds[1] / mass.typical


EVENT = Move("event", groups, settles=True)
