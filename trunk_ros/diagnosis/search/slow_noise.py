"""Noise of a sensor so slow that it looks like physics, and goes with nothing that the arm does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from hashlib import blake2b
from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from trunk_ros.compiled import Array
from trunk_ros.data.noise import WHITE, Noise, rms
from trunk_ros.data.surroundings import counted
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.bank_weights import CUTS, FOLDS, WORTHS, Cuts, Source, Sums
from trunk_ros.diagnosis.discrepancy.curves import curve_fits
from trunk_ros.diagnosis.discrepancy.memory import sources
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.search.candidates import extended, kinds_of_all, open_kinds
from trunk_ros.diagnosis.search.fit import Fit, costed, refit, refit_column
from trunk_ros.diagnosis.search.formed import measured
from trunk_ros.diagnosis.search.of_the_arm import of_the_arm, untimed
from trunk_ros.diagnosis.search.score import CURVE, FURTHER, need, score
from trunk_ros.diagnosis.search.screen import PROMISED, Kept, Screen
from trunk_ros.diagnosis.search.trial import looks, on_all_joints
from trunk_ros.levels import JOINTS, NOTABLE, PART, REFITTED, SOME, SURE, TENFOLD, THREEFOLD
from trunk_ros.recording.signal.resample import SLOW

Parts = list[tuple[Array, np.ndarray, np.ndarray]]
LAGS = 2 ** np.arange(8)  # samples
LOST = np.log(np.finfo(float).max) / 4.0  # of a logarithm: the squares of what goes further are no numbers


def told_from_noise(now: Fit, kept: Callable[[int], Kept]) -> Fit:
    """With the noise of joints that show nothing else than one that wanders: it explains all that is left
    there, better than any further effect of the joint's own or a curve would, and neither the motion nor
    another joint tells anything of it. ``kept``: looks at a column. What was told once stays: noise is
    measured by that without it.
    """
    context, laws = now.context, cache(partial(_laws, now))
    if context.step >= SLOW or context.work.over:
        return now
    columns = [c for c in context.columns if c not in context.wanders]
    columns = [c for c in columns if not is_plain(context, context.noise[c], now.hypothesis, c)]
    likely = [one for one in each(context.work, partial(_wanderer, now), columns) if one is not None]
    alone = [(one, kept(one.column)) for one in likely if not one.alike]
    found = dict[int, Noise]()
    seen = each(context.work, partial(_is_of_the_sensor, now), alone)
    for (one, looked), (yes, more) in zip(alone, seen, strict=True):
        looked |= more  # another process has its own
        found |= {one.column: one.noise} if yes else {}
    for one in (one for one in likely if one.alike):  # together, as the laws of all joints are fitted once
        if _is_of_the_sensor(now, (one, kept(one.column)), laws)[0]:
            found[one.column] = one.noise
    if not found:
        return now
    return costed(measured(costed(wandering_in(context, found), context.known)), now.hypothesis)


def wandering_in(context: Context, found: Mapping[int, Noise]) -> Context:
    """A context with the noise that was ``found`` of columns whose readings wander."""
    wanders = {**context.wanders, **dict(sorted(found.items()))}
    noise = tuple(wanders.get(c, n) for c, n in enumerate(context.noise))
    return replace(context, wanders=wanders).in_noise(noise)


class Wanderer(NamedTuple):
    """A column, a noise that may be all that is left there, what it gains, and whether sensors are alike."""

    column: int
    noise: Noise
    gained: float
    alike: bool


def _wanderer(now: Fit, column: int) -> Wanderer | None:
    """A column of which more than its own noise is left."""
    context, hypothesis = now.context, now.hypothesis
    likely = likelier(context, hypothesis, hypothesis, column)
    if likely is None:
        return None
    # a law that is not quite the right one leaves what wanders
    alike = not hypothesis.new_on(column, context.known) and _is_near(context, hypothesis, column)
    return Wanderer(column, *likely, alike and is_shared(context, hypothesis, column))


def _is_of_the_sensor(
    now: Fit, some: tuple[Wanderer, Kept], laws: Callable[[], list[Hypothesis]] | None = None
) -> tuple[bool, Kept]:
    """Whether noise is all that is left of a column, and all looks at it, those that were kept among them."""
    one, kept = some
    context, hypothesis, column = now.context, now.hypothesis, one.column
    known = of_the_arm(context, hypothesis, column, one.noise)  # what is cheap to see comes first
    known = known or _may_be_named(now, column, kept, one.gained, laws)
    known = known or _may_be_drawn(now, column, one.gained, one.alike)
    return not (known or told(context, hypothesis, column)), kept


def likelier(
    context: Context, less: Hypothesis, hypothesis: Hypothesis, column: int
) -> tuple[Noise, float] | None:
    """The noise that is all that is left of a column with ``less``, and by how much more than the price of a
    name it is likelier than what a hypothesis leaves in the noise as it is known; None where it is not, or
    goes too far. One that wanders beside a curve has its name already: without it the curve's price is saved.
    """
    known, name = context.noise[column], need(context, column)
    noise, cost = _own_or_theirs(context, less, column)
    saved = CURVE * name if column in context.wanders else -name
    gained = unlikely(context, known, hypothesis, column) + saved - cost
    if gained <= 0.0 or not is_plain(context, noise, less, column):
        return None
    near = _is_near(context, less, column)
    return (noise, gained) if near or is_shared(context, less, column) else None


def _own_or_theirs(context: Context, hypothesis: Hypothesis, column: int) -> tuple[Noise, float]:
    """The likeliest noise of a column, or of other joints whose readings wander, where that is as likely but
    for the price of its values: sensors of one unit are alike.
    """
    own, cost = likeliest_noise(context, hypothesis, column)
    unit = context.stage.unit(column)
    donors = [noise for c, noise in context.wanders.items() if c != column and context.stage.unit(c) == unit]
    able = [_as_white_as(own, noise) for noise in donors]
    theirs = [
        (noise, unlikely(context, noise, hypothesis, column))
        for noise in able
        if is_plain(context, noise, hypothesis, column)
    ]
    usual = min(theirs, key=lambda one: one[1], default=(own, np.inf))
    return usual if usual[1] < cost + _price_of(own) else (own, cost)


def _as_white_as(own: Noise, noise: Noise) -> Noise:
    """A noise that wanders, with the white noise that a column has of its own."""
    std = float(np.sqrt(noise.std**2 - noise.white**2 + own.white**2))
    return replace(noise, white=own.white, std=std)


def _price_of(noise: Noise) -> float:
    """Of the values of what wanders in a noise."""
    return FURTHER * (4 if noise.slow[0] > 0.0 else 2)


def _is_near(context: Context, hypothesis: Hypothesis, column: int) -> bool:
    """Whether what a hypothesis leaves goes no further than three times the noise of a column as it is."""
    rest = counted(context.views, context.evened(hypothesis, column), column)
    return rms(rest) < THREEFOLD * context.noise[column].std


def is_shared(context: Context, hypothesis: Hypothesis, column: int) -> bool:
    """Whether the noise of a column is all that is left of three joints or more, each with white noise of its
    own: sensors of one unit are alike, and what physics does has a size of its own on each joint.
    """
    usual, _ = likeliest_noise(context, untimed(hypothesis, column), column)

    def shares(c: int) -> bool:
        less = untimed(hypothesis, c)
        own, cost = likeliest_noise(context, less, c)
        noise = _as_white_as(own, usual)
        near = unlikely(context, noise, less, c) - cost < _price_of(usual)
        return near and is_plain(context, noise, less, c)

    alike = (c for c in context.columns if context.stage.unit(c) == context.stage.unit(column))
    return sum(map(shares, alike)) >= JOINTS


def _may_be_drawn(now: Fit, column: int, gained: float, alike: bool) -> bool:
    """Whether the best curve there is likelier than the noise, which has ``gained`` so much, or one of tied
    values pays where sensors are not ``alike``: levels go with whatever wanders.
    """
    curve, tied = curve_fits(now.context, now.hypothesis, column)
    if curve is not None and _gains(now, column, curve.hypothesis, CURVE) > gained:
        return True
    tied = None if alike else tied
    return tied is not None and score(Fit(tied.hypothesis, now.cost | tied.cost, now.context)) < score(now)


def _may_be_named(
    now: Fit, column: int, kept: Kept, gained: float, laws: Callable[[], list[Hypothesis]] | None
) -> bool:
    """Whether a further effect of a column may by a linear look explain more than noise that wanders, which
    has ``gained`` so much. With the ``laws`` of all joints, where sensors are alike: whether one of all these
    leaves nothing that wanders, or is likelier, once it is fitted; one that goes through the slowest part, as
    a step or a constant does, leaves all the rest of it.
    """
    context, known = now.context, now.context.noise[column]
    kinds = open_kinds(context, now.hypothesis, column)
    found = list(looks(context, now.hypothesis, column, kinds, kept=kept))
    able = [look for look in found if look.gain / PROMISED > gained]
    if laws is None:
        return bool(able)
    best = sorted(able, key=lambda look: -look.gain)[:REFITTED]
    fits = (refit_column(now, look.hypothesis, column).hypothesis for look in best)
    trials = chain(fits, laws())
    return any(is_plain(context, known, t, column) or _gains(now, column, t, 1.0) > gained for t in trials)


def _laws(now: Fit) -> list[Hypothesis]:
    """With each of the effects of all joints that by a linear look explain most, fitted."""
    context, screen = now.context, Screen(now.context, now.hypothesis)
    best = on_all_joints(screen, kinds_of_all(context, now.hypothesis))[:REFITTED]
    return [refit(context, extended(context, now.hypothesis, one)).hypothesis for one in best]


def _gains(now: Fit, column: int, more: Hypothesis, names: float) -> float:
    """By how much more than the price of so many ``names`` what a hypothesis with ``more`` leaves of a column
    is likelier, in the noise as it is known, or in one that wanders, which is a further name.
    """
    context, known, name = now.context, now.context.noise[column], need(now.context, column)
    left = unlikely(context, known, more, column)
    if not is_plain(context, known, more, column):
        left = min(left, likeliest_noise(context, more, column)[1] + name)
    return unlikely(context, known, now.hypothesis, column) - left - names * name


def likeliest_noise(context: Context, hypothesis: Hypothesis, column: int) -> tuple[Noise, float]:
    """The noise by which what a hypothesis leaves of a column is likeliest, and twice the negative logarithm
    of that likelihood, but for a constant; a slow part more where it is likelier by the price of its values.
    """
    parts, known = _parts(context, hypothesis, column), context.noise[column].std
    key = blake2b(np.float64(known).tobytes())
    for array in chain.from_iterable(parts):
        key.update(array.tobytes())
    if key.digest() not in context.likely:
        context.likely[key.digest()] = _likeliest(parts, known)
    return context.likely[key.digest()]


def _likeliest(parts: Parts, known: float) -> tuple[Noise, float]:
    longest = SOME * max(len(rest) for rest, _, _ in parts)
    rest_std = rms(np.concatenate([rest[rows] for rest, _, rows in parts]))

    def noise_at(x: Array) -> Noise:
        white, *coloured = np.exp(np.clip(x, -LOST, LOST)).tolist()
        std = float(np.linalg.norm([white, *coloured[::2]]))
        remembered = [float(np.exp(-1.0 / min(max(forgets, 1.0), longest))) for forgets in coloured[1::2]]
        return Noise(std, remembered[0], white, (coloured[2], remembered[1]) if coloured[2:] else (0.0, 0.0))

    def fitted(first: list[float]) -> tuple[Array, float]:
        options = {"xatol": 0.02, "fatol": 1.0, "maxfev": 50 * len(first)}
        best = minimize(cost, np.log(first), method="Nelder-Mead", options=options)
        return best.x, float(best.fun)

    def cost(x: Array) -> float:
        noise = noise_at(x)
        return sum(noise.unlikely(*part) for part in parts)

    slow = np.sqrt(max(rest_std**2 - known**2, 0.01 * known**2))
    one = fitted([known, slow, PART * longest])
    white, coloured, forgets = np.exp(one[0]).tolist()
    half = [coloured / np.sqrt(2.0), max(forgets / THREEFOLD, 1.0), coloured / np.sqrt(2.0)]
    two = fitted([white, *half, min(TENFOLD * forgets, longest)])
    price = FURTHER * (len(two[0]) - len(one[0]))
    x, least = two if two[1] < one[1] - price else one
    return noise_at(x), least


def unlikely(context: Context, noise: Noise, hypothesis: Hypothesis, column: int) -> float:
    """Twice the negative logarithm of the likelihood of what a hypothesis leaves of a column."""
    return sum(noise.unlikely(*part) for part in _parts(context, hypothesis, column))


def _parts(context: Context, hypothesis: Hypothesis, column: int) -> Parts:
    """By span the residual (n,), where the sample before counts as well, and which rows count."""
    seen = [view.columns[column] for view in context.views]
    rests = context.evened(hypothesis, column)
    return [(rest, s.follows, np.flatnonzero(s.valid)) for rest, s in zip(rests, seen, strict=True)]


def is_plain(context: Context, noise: Noise, hypothesis: Hypothesis, column: int) -> bool:
    """Whether a noise is all that a hypothesis leaves of a column: what swings is more."""
    for rest, follows, rows in _parts(context, hypothesis, column):
        white = noise.whiten(rest, follows)[rows]
        chance = SURE / np.sqrt(max(len(white), 1))
        lags = (lag for lag in LAGS if lag < len(white) // 2)
        if any(abs(float(np.mean(white[lag:] * white[:-lag]))) > WHITE + chance for lag in lags):
            return False
    return True


def told(context: Context, hypothesis: Hypothesis, column: int) -> bool:
    """Whether the motion tells of parts of the recording what a hypothesis leaves there, by what it left of
    the others, beside a constant, which any curve holds.
    """
    cuts = replace(Cuts.on(context, column), fold=np.arange(CUTS) * FOLDS // CUTS)
    rest = context.whitened(hypothesis, column)
    rest = rest - (rest.mean() if len(rest) else 0.0)
    return any(map(partial(_tells, rest, cuts), sources(context, column)))  # none is there beside the next


def _tells(rest: Array, cuts: Cuts, source: Source) -> bool:
    sums = Sums.of([source], rest, cuts)
    nothing = sums.tried([], 1.0).left
    gains = (1.0 - sums.tried([0], worth).left / nothing for worth in WORTHS[::2])
    return any(g.mean() - NOTABLE * g.std(ddof=1) / np.sqrt(len(g)) > PART for g in gains)
