"""The motion that tells rivals apart: simulate both and take the one on which they differ most.

Source: Atkinson & Fedorov (1975), "The design of experiments for discriminating between two rival models",
Biometrika 62: a T-optimal design maximises over the motion what is least over the rival's values. The rival
is refitted to the new motion together with the recordings at hand.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence.evidence import Evidence
from trunk_ros.diagnosis.experiment.discrimination import Difference, Duel, expected, span_of
from trunk_ros.diagnosis.experiment.motions import Stretch, elsewhere, limits_of, most_of, motion, stretches
from trunk_ros.diagnosis.experiment.rival_forms import sides_of
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.long import WORK
from trunk_ros.levels import CLEARLY, HARDLY, TENFOLD
from trunk_ros.trajectory import Trajectory
from trunk_ros.units import per_second, placed, sized
from trunk_ros.words import significant

DESIGNED = WORK / 12.0  # joint-steps, a second: then no further pair and no further motion is tried
LIKELIEST = 2  # equivalents of a finding that it is to be told from: each costs as much as the first
STRETCHES = 4  # stretches of a motion, and of the best ones that are tried in other postures or once more


@dataclass(frozen=True)
class Experiment:
    """A motion, and what is to be seen in it of each pair of rivals."""

    motion: Trajectory
    pairs: list[tuple[str, str]]
    duels: list[Duel]
    seen: list[Difference]
    mutual: list[bool]
    """Whether the other, taken for the truth, rules the duel's truth out as well."""


def experiment(state: Fit, found: dict[str, Evidence]) -> Experiment | None:
    """The motion that best tells the effects found from their likeliest equivalents, as far as the work that
    is granted goes; None where there are none.
    """
    work = Work(DESIGNED)
    state = state.working(work)
    alone = {name: [one for one in e.equivalents if isinstance(one, str)] for name, e in found.items()}
    pairs = [(name, k) for k in range(LIKELIEST) for name, others in alone.items() if k < len(others)]
    sides: list[list[Duel]] = []
    for name, k in pairs:
        if not (sides and work.over):
            duels = sides_of(state, name, alone[name][k], found[name])
            sides += [some] if (some := [d for d in duels if d.columns]) else []
    return Design(replace(state.context, work=Work(DESIGNED)), sides).run() if sides else None


class Design:
    """A search over motions for one that tells all rivals apart."""

    def __init__(self, context: Context, sides: list[list[Duel]]):
        """``sides``: of each pair, the one to be told first if a motion can."""
        self.context, self.sides = context, sides
        self.duels = [duels[0] for duels in sides]
        self.own = {c for duel in self.duels for c in duel.columns}
        self.limits = limits_of(context)
        self.most = most_of(context, STRETCHES**2)

    def run(self) -> Experiment:
        """Stretch by stretch; repeated where that is not enough."""
        pairs = [(duel.truth, duel.other) for duel in self.duels]
        ranked, faced = self.ranked()
        parts = self.grown(ranked) if self.duels else ranked[:1]
        if self.duels and self.ratios(parts).min() < CLEARLY:
            parts = self.repeated(parts)
        there = self.motion(parts)
        seen = [duel.seen_in(self.context, there) for duel in faced]
        mutual = [self.back(duel, duels, there) for duel, duels in zip(faced, self.sides, strict=True)]
        return Experiment(there, pairs, faced, seen, mutual)

    def repeated(self, parts: list[Stretch]) -> list[Stretch]:
        """As often as it takes to rule out what repeating rules out at all; where that is nothing, the most
        that was tried.
        """
        times = range(1, min(STRETCHES, self.most // len(parts)) + 1)
        told = [int(np.sum(self.ratios(parts * many) >= CLEARLY)) for many in times]
        return parts * (times[int(np.argmax(told))] if max(told) else times[-1])

    def back(self, faced: Duel, duels: list[Duel], there: Trajectory) -> bool:
        """Whether a motion rules out the truth of ``faced`` if it is the other, in whatever form."""
        turned = [duel for duel in duels if duel.truth == faced.other]
        return all(duel.seen_in(self.context, there).decides for duel in turned)

    def motion(self, parts: list[Stretch]) -> Trajectory:
        """Stretches as a trajectory of all joints."""
        return motion(self.context, self.limits, parts, self.own)

    def ratios(self, parts: list[Stretch]) -> Array:
        """(duels,) misfit of each refitted rival, over what it takes to rule it out."""
        span = span_of(self.context, self.motion(parts))
        bases = {id(duel.base): duel.base for duel in self.duels}
        told = {key: expected(self.context, base, span) for key, base in bases.items()}
        return np.array([duel.ratio(told[id(duel.base)]) for duel in self.duels])

    def score(self, parts: list[Stretch]) -> float:
        """How far all rivals together are apart; logarithms, so that the nearest count most."""
        return float(np.sum(np.log1p(self.ratios(parts))))

    def ranked(self) -> tuple[list[Stretch], list[Duel]]:
        """The stretches that tell most, the best of them in other postures too, and each pair from the side
        that shows most. ``duels`` become all that a motion may decide.
        """
        candidates = stretches(len(self.context.joints), self.own)
        self.duels = [duel for duels in self.sides for duel in duels]
        seen = self.shown(candidates)
        best = sorted(range(len(seen)), key=lambda k: -float(np.log1p(seen[k]).sum()))[:STRETCHES]
        moved = [there for k in best for there in elsewhere(candidates[k])]
        candidates, ratios = candidates[: len(seen)], np.array(seen)
        if not self.context.work.over:
            more = self.shown(moved)
            candidates, ratios = candidates + moved[: len(more)], np.array(seen + more)
        peaks, ends = ratios.max(axis=0), np.cumsum([len(duels) for duels in self.sides])
        told = [_told(peaks, range(end - len(d), end)) for end, d in zip(ends, self.sides, strict=True)]
        faced, all_told = [self.duels[which[0]] for which in told], [k for which in told for k in which]
        self.duels = [self.duels[k] for k in all_told if peaks[k] > 1.0 / TENFOLD]
        order = np.argsort(-np.log1p(ratios[:, all_told]).sum(axis=1), kind="stable")
        return [candidates[k] for k in order[:STRETCHES]], faced

    def shown(self, candidates: list[Stretch]) -> list[Array]:
        """What the first ones of single stretches tell of each pair: all, or as many as the work allows."""
        out: list[Array] = []
        while len(out) < len(candidates) and not (out and self.context.work.over):
            some = candidates[len(out) : len(out) + STRETCHES]
            out += each(self.context.work, lambda part: self.ratios([part]), some)
        return out

    def grown(self, ranked: list[Stretch]) -> list[Stretch]:
        """The best stretch, then the best after it, and so on until every rival is ruled out."""
        parts = ranked[:1]
        while (
            len(parts) < min(STRETCHES, self.most)
            and not self.context.work.over
            and self.ratios(parts).min() < TENFOLD
        ):
            parts = max(([*parts, part] for part in ranked), key=self.score)
        return parts


def _told(peaks: Array, sides: range) -> list[int]:
    """The sides of a pair to design for: the first if a motion tells it, or all that one tells and the first
    as well if it shows at all, or the one that shows most.
    """
    order = sorted(sides, key=lambda k: -float(peaks[k]))
    sure = [k for k in order if peaks[k] >= CLEARLY]
    if sides[0] in sure:
        return [sides[0]]
    return [*sure, *sides[:1]] if sure else order[:1]


def proposals(done: Experiment, file: str, units: dict[str, str]) -> list[dict[str, Any]]:
    """What ``diagnosis.json`` says of an experiment, an entry for each pair of rivals.

    ``trajectory`` is empty where no motion within the limits tells a pair apart.
    """
    told = zip(done.pairs, done.duels, done.seen, done.mutual, strict=True)
    return [
        {
            "separates": list(pair),
            "statement": statement(duel, seen, mutual, done.motion, units, file),
            "trajectory": file if seen.decides else "",
        }
        for pair, duel, seen, mutual in told
    ]


def statement(
    duel: Duel, seen: Difference, mutual: bool, there: Trajectory, units: dict[str, str], file: str
) -> str:
    """What to play, what to look for, and what its absence means."""
    joint = there.joints[seen.column]
    unit = units.get(joint, "rad")
    truth, other = _words(duel.truth, duel.base[duel.truth].form), _words(duel.other)
    gap = sized(abs(seen.gap), unit, 2)
    times = f"{significant(abs(seen.gap) / seen.noise, 2)} times the noise"
    if not seen.decides:
        part = seen.ratio / CLEARLY
        short = f"{f'{part:.0%}' if part >= HARDLY else 'less than 1%'} of what a decision takes"
        return (
            f"No motion within the joint limits decides between {truth} and {other}: in the best one "
            f"that was found, once both are fitted to it, they differ by {gap} in one sample of {joint} "
            f"({times}), but over all samples by {significant(seen.rms, 2)} times the noise (rms): {short}."
        )
    moves = f"at {seen.speed:+.2f} {per_second(unit)}" if round(seen.speed, 2) else "at rest"
    where = f"{joint} at {seen.time:.1f} s ({placed(seen.angle, unit)}, {moves})"
    whole, play = f"{significant(seen.rms, 2)} times", f"Play {file} ({ceil(there.duration)} s)"
    if abs(seen.gap) < seen.noise:
        return (
            f"{play} on the arm that was recorded, and diagnose it: no sample of {joint} shows whether it is "
            f"{truth} or {other} ({gap} at most, {times}), all of them do ({whole} rms)."
        )
    told = (
        f"{play} on the arm that was recorded, and look at {where}: if it is {truth}, the joint reads {gap} "
        f"{'higher' if seen.gap > 0 else 'lower'} than if it is {other} "
        f"({times}; {whole} rms over the whole motion)."
    )
    absent = f" If that is not seen, both remain possible: {truth} can do what {other} does."
    return told if mutual else told + absent


def _words(name: str, form: str = "") -> str:
    """An effect and its form as words."""
    return f"{name} ({form})".replace("_", " ") if form else name.replace("_", " ")
