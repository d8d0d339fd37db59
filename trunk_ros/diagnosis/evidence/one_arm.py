"""Whether several recordings are of one arm: what one of them shows must hold in the others, too, where their
motions overlap.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.data.excerpt import excerpt
from trunk_ros.data.noise import rms
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.credible import BY_THE_WAY
from trunk_ros.diagnosis.search.descent import Desk
from trunk_ros.diagnosis.search.fit import refit
from trunk_ros.diagnosis.search.greedy import search
from trunk_ros.diagnosis.search.long import granted
from trunk_ros.diagnosis.sparse import apart
from trunk_ros.effects import effect
from trunk_ros.levels import CLEARLY, FEWEST, NOTABLE
from trunk_ros.units import sized

TELLS = NOTABLE**2  # times the power of noise, or of what is left where an effect holds: less tells nothing


@dataclass(frozen=True)
class Contradiction:
    """What ``first`` shows on a joint, and what that leaves in ``other``: rms residuals in its ``unit``."""

    first: str
    other: str
    joint: str
    effects: tuple[str, ...]
    nominal: float
    left: float
    unit: str
    is_nominal: bool
    """The other one is the nominal arm down to the noise."""

    def statement(self) -> str:
        """One line, with what to do."""
        made = (
            f": {self.other} is the nominal simulation down to the noise, as `bringup` by itself records it"
            if self.is_nominal
            else ", or it has changed in between"
        )
        shows = f"What {self.first} shows on {self.joint} ({', '.join(self.effects)})"
        left, nominal = sized(self.left, self.unit), sized(self.nominal, self.unit)
        sizes = f"{left} rms in {self.other}, the nominal arm {nominal}"
        return (
            f"{self.first} and {self.other} are not of one arm{made}. "
            f"{shows} leaves {sizes}: diagnose each by itself"
        )


def contradiction(context: Context, say: Callable[[str], None]) -> Contradiction | None:
    """The recording with most to explain is explained by itself, then held against the others; None where
    they agree, and where there is one only.
    """
    if len(context.views) < 2 or not context.columns:
        return None
    alone = apart(context.over([excerpt(view.span) for view in context.views]))
    parts = [replace(part, work=granted()) for part in alone]
    base = max(parts, key=lambda part: sum(_power(part, part.known, c) for c in context.columns))
    say("the recording with most to explain")
    found = _lasting(search(base, Desk(lambda text: say(f"one recording: {text}"))).hypothesis)
    for part in parts:
        if part is not base and (place := _contradicts(base, part, found)) is not None:
            both = context.over([base.views[0].span, part.views[0].span])
            if not _agree(replace(both, work=granted()), base, part, place[1], found):
                return _told(base, *place, found)
    return None


def _agree(both: Context, base: Context, other: Context, column: int, found: Hypothesis) -> bool:
    """Whether one set of values explains a joint in two recordings nearly as well as values of each: then
    what was found in one alone was bent to it.
    """
    common = refit(both, found).hypothesis
    pairs = ((base, found), (other, refit(other, found).hypothesis))
    return all(
        power(part, common, column) < TELLS * max(power(part, own, column), 1.0)
        for part, own in pairs
        for power in (_power, _plain)
    )


def _contradicts(base: Context, other: Context, found: Hypothesis) -> tuple[Context, int] | None:
    """The column on which an explanation of one recording is furthest from holding in another, and what is
    compared of that.
    """
    worst: dict[int, tuple[float, Context]] = {}
    there: Hypothesis | None = None
    for c in (c for c in base.columns if found.on(c) and other.count(c)):
        nominal, left = _power(base, base.known, c), _power(base, found, c)
        if nominal < TELLS or TELLS * left > nominal:
            continue  # it was not explained where it was found
        both = _overlap(base, other, found, c)
        if both.count(c) < min(FEWEST, other.count(c)):
            continue  # it says nothing of where the other went
        before, after = _power(both, other.known, c), _power(both, found, c)
        if after < TELLS or TELLS * after < before:
            continue  # it holds
        there = there or refit(other, found).hypothesis
        if after > before or TELLS * _power(both, there, c) < after:
            worst[c] = after, both
    column = max(worst, key=lambda c: worst[c][0], default=None)
    return None if column is None else (worst[column][1], column)


def _overlap(base: Context, other: Context, found: Hypothesis, column: int) -> Context:
    """What the other shows of a joint within the angles that it, and those whose angles act on it, went
    through: beyond them an explanation that goes by angles is an extrapolation.
    """
    terms = found.on(column)
    if all(effect(term.effect).regime in BY_THE_WAY for term in terms):
        return other
    words = [word for term in terms for word in term.words.get(column, {}).values()]
    acting = {column, *(base.joints.index(word) for word in words if word in base.joints)}
    went, goes = (part.views[0].span.measured(part.views[0].angles) for part in (base, other))
    counts = base.views[0].span.valid[:, column]
    low, high = went[counts].min(axis=0), went[counts].max(axis=0)
    inside = (goes >= low) & (goes <= high)
    return other.only([inside[:, sorted(acting)].all(axis=1)])


def _power(context: Context, hypothesis: Hypothesis, column: int) -> float:
    """Mean square of the residuals as unit noise."""
    white = context.seen_with(hypothesis).whitened(hypothesis, column)
    return float(np.mean(white**2)) if len(white) else 0.0


def _plain(context: Context, hypothesis: Hypothesis, column: int) -> float:
    """Mean square of the residuals as they are, in units of the noise."""
    return (_rms(context, hypothesis, column) / context.noise[column].std) ** 2


def _lasting(hypothesis: Hypothesis) -> Hypothesis:
    """Without effects of time and load: each recording begins anew, and may have a payload of its own. Nor
    with those that have no name: what no physics is known for need not be the same in another motion.
    """
    for name, term in list(hypothesis.items()):
        kind = effect(name)
        if kind.regime == "time" or kind.bears(term.form) or not kind.named:
            hypothesis = hypothesis.without(name)
    return hypothesis


def _told(base: Context, other: Context, column: int, found: Hypothesis) -> Contradiction:
    first, second = (part.views[0].span for part in (base, other))
    nominal, left = _rms(other, other.known, column), _rms(other, found, column)
    names = tuple(term.effect for term in found.on(column))
    is_nominal = all(_power(other, other.known, c) < CLEARLY for c in other.columns)
    joint, unit = other.joints[column], other.stage.unit(column)
    return Contradiction(first.name, second.name, joint, names, nominal, left, unit, is_nominal)


def _rms(context: Context, hypothesis: Hypothesis, column: int) -> float:
    kept = context.views[0].span.valid[:, column]
    residual = context.seen_with(hypothesis).residual(0, hypothesis, column)
    return rms(residual[kept])
