"""The motion that tells rivals apart: simulate both and take the one on which they differ most.

Source: Atkinson & Fedorov (1975), "The design of experiments for discriminating between two rival models",
Biometrika 62: a T-optimal design maximises over the motion what is least over the rival's values. The rival
is refitted to the new motion together with the recordings at hand.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.criterion import need
from trunk_ros.diagnosis.evidence import Evidence
from trunk_ros.diagnosis.excitation import Stretch, limits_of, motion, stretches
from trunk_ros.diagnosis.explanation import Explanation
from trunk_ros.diagnosis.fit import Fit
from trunk_ros.diagnosis.problem import Problem
from trunk_ros.diagnosis.search import Search
from trunk_ros.diagnosis.separation import HOPELESS, Difference, Duel, Other, expected, span_of
from trunk_ros.effects import effect
from trunk_ros.parameter import Parameter
from trunk_ros.trajectory import Trajectory

FORMS = 2  # of a rival beside its best one
MOST = 4  # stretches of a motion
AGAIN = 6  # stretches that are tried once more beside the best one
SURE = 1.5  # times what it takes to rule a rival out: what an experiment must promise
AMPLE = 4.0  # likewise: no further stretch is added
REPEATS = 4  # of a motion that is too short
TRIALS, FEWEST = 48, 8  # simulations of rivals in the local search; motions that it tries at least
STANDS = 1e-3  # rad/s
LOW, HIGH = np.array([-1.0, 0.02, 0.03, 0.0]), np.array([1.0, 1.0, 1.0, 3.0])
FIRST = np.array([0.2, 0.15, 0.2, 0.5])  # steps of the local search in centre, size, speed, hold


@dataclass(frozen=True)
class Experiment:
    """A motion, and what is to be seen in it of each pair of rivals."""

    motion: Trajectory
    pairs: list[tuple[str, str]]
    duels: list[Duel]
    seen: list[Difference]


def experiment(search: Search, state: Fit, found: dict[str, Evidence]) -> Experiment | None:
    """The motion that best tells the effects found from their equivalents; None where there are none."""
    sides = [
        sides_of(search, state, name, rival, evidence)
        for name, evidence in found.items()
        for rival in evidence.equivalents
    ]
    done = Design(search.problem, sides).run() if sides else None
    search.problem.look_again(state.explanation)
    return done


def sides_of(search: Search, state: Fit, name: str, rival: str, evidence: Evidence) -> tuple[Duel, Duel]:
    """What was found taken for the truth, and the rival taken for it: one effect may be able to turn into the
    other, and then only one of the two can be ruled out.
    """
    limit = sum(need(search.problem, c) for c in evidence.gain)
    loss, there = evidence.rivals[rival], evidence.fitted[rival]
    others = forms_of(search, Other(search, there, loss), rival, state.total, limit)
    own = forms_of(search, Other(search, state.explanation, -loss), name, state.total + loss, limit)
    return Duel(name, rival, state.explanation, others), Duel(rival, name, there, own)


def forms_of(search: Search, best: Other, name: str, total: float, limit: float) -> list[Other]:
    """An effect in the forms and with the sources that lose less than ``limit`` against ``total``, best
    first.
    """
    kind, there = effect(name), best.explanation
    forms = [form for form in kind.forms if form != there[name].form and kind.own_parameters(form)]
    trials = [in_form(there, name, form) for form in forms]
    if kind.texts:
        trials += [from_source(there, name, joint, search.problem.joints) for joint in search.problem.joints]
    fits = [search.refit(trial) for trial in trials if trial != there]
    close = sorted((fit for fit in fits if fit.total - total < limit), key=lambda fit: fit.total)[:FORMS]
    return [best, *(Other(search, fit.explanation, fit.total - total) for fit in close)]


def from_source(explanation: Explanation, name: str, source: str, joints: tuple[str, ...]) -> Explanation:
    """An effect that another joint causes, wherever it is not that joint itself."""
    out, first = explanation.copy(), effect(name).texts[0]
    for column, words in out[name].words.items():
        if joints[column] != source and source not in words.values():
            words[first] = source
    return out


def in_form(explanation: Explanation, name: str, form: str) -> Explanation:
    """An effect in another form, from the values that it has; others from their usual ones."""
    out = explanation.copy()
    term, needed = out[name], effect(name).own_parameters(form)
    term.form = form
    term.shared = {
        p.name: term.shared.get(p.name, p.typical) for p in needed if p.shared and _has(p, term.shared)
    }
    term.own = {
        c: {p.name: own.get(p.name, p.typical) for p in needed if not p.shared and _has(p, own)}
        for c, own in term.own.items()
    }
    return out


def _has(parameter: Parameter, values: dict[str, float]) -> bool:
    return not parameter.optional or parameter.name in values


class Design:
    """A search over motions for one that tells all rivals apart."""

    def __init__(self, problem: Problem, sides: list[tuple[Duel, Duel]]):
        self.problem, self.sides = problem, sides
        self.duels = [forward for forward, _ in sides]
        self.own = {c for duel in self.duels for c in duel.columns}
        self.limits = limits_of(problem)

    def run(self) -> Experiment:
        """Stretch by stretch, then in small steps; repeated where that is not enough."""
        pairs = [(duel.truth, duel.other) for duel in self.duels]
        ranked, faced, peaks = self.ranked()
        self.duels = [duel for duel, peak in zip(faced, peaks, strict=True) if peak > HOPELESS]
        parts = self.polished(self.grown(ranked)) if self.duels else ranked[:1]
        if self.duels and self.ratios(parts).min() < SURE:
            parts = max((parts, parts * REPEATS), key=self.score)
        there = self.motion(parts)
        return Experiment(there, pairs, faced, [duel.seen_in(self.problem, there) for duel in faced])

    def motion(self, parts: list[Stretch]) -> Trajectory:
        """Stretches as a trajectory of all joints."""
        return motion(self.problem, self.limits, parts, self.own)

    def ratios(self, parts: list[Stretch]) -> Array:
        """(duels,) misfit of each refitted rival, over what it takes to rule it out."""
        span = span_of(self.problem, self.motion(parts))
        told = {id(base): expected(self.problem, base, span) for base in (d.base for d in self.duels)}
        return np.array([duel.ratio(told[id(duel.base)]) for duel in self.duels])

    def score(self, parts: list[Stretch]) -> float:
        """How far all rivals together are apart; logarithms, so that the nearest count most."""
        return float(np.sum(np.log1p(self.ratios(parts))))

    def ranked(self) -> tuple[list[Stretch], list[Duel], Array]:
        """The stretches that tell most; each pair from the side from which it can be told; its best ratio."""
        candidates = stretches(len(self.problem.joints), self.own)
        ratios = np.array([self.ratios([part]) for part in candidates])
        back, alike = np.zeros_like(ratios), ratios.max(axis=0) < SURE
        self.duels = [turned for (_, turned), a in zip(self.sides, alike, strict=True) if a]
        if self.duels:
            back[:, alike] = [self.ratios([part]) for part in candidates]
        turned = back.max(axis=0) > ratios.max(axis=0)
        faced = [pair[int(t)] for pair, t in zip(self.sides, turned, strict=True)]
        ratios = np.where(turned, back, ratios)
        order = np.argsort(-np.log1p(ratios).sum(axis=1), kind="stable")
        return [candidates[k] for k in order[:AGAIN]], faced, ratios.max(axis=0)

    def grown(self, ranked: list[Stretch]) -> list[Stretch]:
        """The best stretch, then the best after it, and so on until every rival is ruled out."""
        parts = ranked[:1]
        while len(parts) < MOST and self.ratios(parts).min() < AMPLE:
            parts = max(([*parts, part] for part in ranked), key=self.score)
        return parts

    def polished(self, parts: list[Stretch]) -> list[Stretch]:
        """The last stretch moved to where its neighbours are no better."""
        *before, last = parts
        start = np.array([last.centre, last.size, last.speed, last.hold])

        def loss(x: Array) -> float:
            return -self.score([*before, _at(last, x)])

        simplex = np.vstack([start, start + np.diag(np.where(start + FIRST > HIGH, -FIRST, FIRST))])
        tries = max(TRIALS // sum(len(duel.others) for duel in self.duels), FEWEST)
        found = minimize(
            loss, start, method="Nelder-Mead", bounds=list(zip(LOW, HIGH, strict=True)),
            options={"maxfev": tries, "initial_simplex": simplex},
        )  # fmt: skip
        return max((parts, [*before, _at(last, found.x)]), key=self.score)


def _at(part: Stretch, x: Array) -> Stretch:
    centre, size, speed, hold = (float(value) for value in np.clip(x, LOW, HIGH))
    return replace(part, centre=centre, size=size, speed=speed, hold=hold)


def proposals(done: Experiment, file: str, units: dict[str, str]) -> list[dict[str, Any]]:
    """What ``diagnosis.json`` says of an experiment, an entry for each pair of rivals.

    ``trajectory`` is empty where no motion within the limits tells a pair apart.
    """
    return [
        {
            "separates": list(pair),
            "statement": statement(duel, seen, done.motion, units),
            "trajectory": file if seen.ratio >= SURE else "",
        }
        for pair, duel, seen in zip(done.pairs, done.duels, done.seen, strict=True)
    ]


def statement(duel: Duel, seen: Difference, there: Trajectory, units: dict[str, str]) -> str:
    """What to look for, in one sentence."""
    joint = there.joints[seen.column]
    unit = units.get(joint, "rad")
    gap, times = f"{1e3 * abs(seen.gap):.2g} m{unit}", f"{abs(seen.gap) / seen.noise:.2g} times the noise"
    if seen.ratio < SURE:
        return (
            f"No motion within the limits tells {duel.truth} from {duel.other}: fitted anew, the two would "
            f"differ by no more than {gap}, {times}, on {joint}."
        )
    moves = f"at {seen.speed:+.2f} {unit}/s" if abs(seen.speed) > STANDS else "at rest"
    where = f"{joint} at {seen.time:.1f} s ({seen.angle:+.2f} {unit}, {moves})"
    return (
        f"In {there.duration:.0f} s of motion look at {where}: with {duel.truth} it reads {gap} "
        f"{'more' if seen.gap > 0 else 'less'}, {times}, than with any {duel.other} that fits these data; "
        f"over the whole motion they differ by {seen.rms:.2g} times the noise."
    )
