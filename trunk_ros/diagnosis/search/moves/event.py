"""When an effect that is there begins and ends, and when what the arm carries is taken up and put down."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import extended
from trunk_ros.diagnosis.search.descent import Desk, Group, Move, descend_with
from trunk_ros.diagnosis.search.fit import Fit, refit, refit_column
from trunk_ros.diagnosis.search.moves.onset import dated
from trunk_ros.diagnosis.search.moves.option import OPTION
from trunk_ros.diagnosis.search.score import score
from trunk_ros.diagnosis.search.screen import PROMISED, Screen
from trunk_ros.diagnosis.search.trial import Look, may_win, refit_to_win, refitted
from trunk_ros.diagnosis.search.windows import Window
from trunk_ros.effects import effect
from trunk_ros.guards import ROUNDED
from trunk_ros.parameter import Parameter


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each effect that may begin, on each of its joints, and each payload."""
    if len(best.context.views) > 1:
        return
    for name, term in best.hypothesis.items():
        alike = effect(name).begins and not any(term.moments(c) for c in term.columns)
        for mass in effect(name).carried() if alike else ():
            trials, promise = partial(_taken_up, best, desk, name, mass), partial(_promise, best, name, mass)
            yield Group((name, mass.name), best.context.columns, trials, promise)
        taken_up = any(m.name in term.shared for m in effect(name).moments())
        own = effect(name).begins and any(term.own.values()) and not taken_up
        for column in (c for c in term.columns if own and c in best.context.columns):
            change = _always if term.moments(column) else _for_a_while
            yield Group((name, column), [column], partial(change, best, name, column))


def _always(now: Fit, name: str, column: int) -> Iterator[Fit]:
    """Without one of its moments."""
    for moment in now.hypothesis[name].moments(column):
        trial = now.hypothesis.copy()
        del trial[name].own[column][moment]
        yield refit_column(now, trial, column)


def _for_a_while(now: Fit, name: str, column: int) -> Iterator[Fit]:
    """In the time in which it gains most, where that is not all the time."""
    bare, form = now.hypothesis.without(name, column), now.hypothesis[name].form
    screen = Screen(now.context, bare, [column])
    start = screen.local_form(effect(name), form, column)
    found = start and screen.lasting(start, [column])
    if found:
        there = extended(now.context, bare, found)
        for trial in refitted(now, column, [Look(there, screen.left(column), found.gain)]):
            yield dated(trial, name, column)


def _promise(now: Fit, name: str, mass: Parameter) -> float:
    """What a mass for a time may gain, and all that may be saved."""
    bare, carried = _without(now.hypothesis, name, mass)
    if any(when in carried for when in _when(name, mass)):
        return np.inf
    _, window = _seen(Screen(now.context, bare), name, mass)
    gain = 0.0 if window is None else float(_gained(mass, window.rd, window.dd))
    return score(now) - now.total + gain / PROMISED


def _taken_up(now: Fit, desk: Desk, name: str, mass: Parameter) -> Iterator[Fit]:
    """With a mass at the tip for the time in which that gains most, judged with the options that follow, or
    always where it was for a time. Either way beside what else looks like it: the effect itself that begins
    on joint after joint.
    """
    bare, carried = _without(now.hypothesis, name, mass)
    if any(when in carried for when in _when(name, mass)):
        always = bare.copy()
        always[name].shared[mass.name] = carried.get(mass.name) or mass.typical
        yield refit_to_win(now, always)
        yield _one_by_one(refit(now.context, bare), name)
        return
    yield _one_by_one(now, name)
    screen = Screen(now.context, bare)
    there, window = _seen(screen, name, mass)
    if window is None or not may_win(now, there, screen, float(_gained(mass, window.rd, window.dd))):
        return
    there[name].shared[mass.name] = _mass(mass, window.rd, window.dd)
    there[name].shared |= {f"{mass.name}_{when}": t for when, t in window.moments.items()}
    trial = dated(refit(now.context, there), name)
    yield descend_with(trial, (OPTION,), desk) if trial.total < score(now) else trial


def _one_by_one(now: Fit, name: str) -> Fit:
    """With an effect on each joint in the time in which it gains most there, where that pays."""
    best = now
    for column in now.hypothesis[name].columns:
        if column in now.context.columns:
            best = min([best, *_for_a_while(best, name, column)], key=score)
    return best


def _when(name: str, mass: Parameter) -> list[str]:
    return [m.name for m in effect(name).moments() if m.name.startswith(mass.name)]


def _without(hypothesis: Hypothesis, name: str, mass: Parameter) -> tuple[Hypothesis, dict[str, float]]:
    """A hypothesis in which an effect carries nothing, and what it carried."""
    bare, names = hypothesis.copy(), (mass.name, *_when(name, mass))
    return bare, {n: bare[name].shared.pop(n) for n in names if n in bare[name].shared}


def _seen(screen: Screen, name: str, mass: Parameter) -> tuple[Hypothesis, Window | None]:
    """With the usual mass, and the time in which it gains most by a linear look."""
    there = screen.hypothesis.copy()
    there[name].shared[mass.name] = mass.typical
    return there, screen.window(there, screen.context.columns, partial(_gained, mass), False)


def _gained(mass: Parameter, rd: Array | float, dd: Array | float) -> Array:
    """By the mass that gains most."""
    factor = np.clip(rd / np.maximum(dd, ROUNDED), 0.0, mass.bounds[1] / mass.typical)
    return np.asarray(factor * (2 * rd - factor * dd))


def _mass(mass: Parameter, rd: float, dd: float) -> float:
    return float(np.clip(mass.typical * rd / max(dd, ROUNDED), *mass.bounds))


EVENT = Move("event", groups)
