"""Readings that wander: noise of a sensor so slow that it looks like physics, and goes with nothing that the
arm does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.data.noise import WHITE, Noise
from trunk_ros.diagnosis.discrepancy.bank_weights import CUTS, FOLDS, WORTHS, Cuts, Sums
from trunk_ros.diagnosis.discrepancy.memory import sources
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import NOTABLE, SEVERAL, SURE
from trunk_ros.diagnosis.search.descent import Desk, descend
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.moves import DROP, SWAP, SWAP_ALL
from trunk_ros.diagnosis.search.score import need
from trunk_ros.effects import effect
from trunk_ros.effects.curve import Curve
from trunk_ros.recording.signal.resample import SLOW

TELLS = 0.1  # of a rest, on parts of the recording not seen: what goes with the motion is physics
LAGS = (1, 2, 3, 5, 8, 13, 21, 34, 55, 89, 144)  # samples
FURTHEST = 3.0  # times the noise without it: what goes further is no noise
SLOWEST = 0.3  # of the recording: what takes longer to forget itself is a drift


def steadied(now: Fit) -> Fit:
    """Without what only follows the readings about, where a noise that wanders explains it as well, and with
    names that hold in that noise.
    """
    context, bare, found = now.context, now.hypothesis, dict[int, Noise]()
    if context.step >= SLOW:
        return now
    for column in context.columns:
        less, known = _untimed(now.hypothesis, column), context.noise[column]
        timed = less is not now.hypothesis
        if timed or not _plain(context, known, less, column):
            noise, cost = likeliest_noise(context, less, column)
            followed = _unlikely(context, known, now.hypothesis, column)
            small = noise.std < FURTHEST * known.std
            clear = cost < followed - need(context, column)
            alone = small and clear and _plain(context, noise, less, column)
            if alone and (timed or not _told(context, less, column)):
                found[column] = noise
                bare = _untimed(bare, column)
    if not found:
        return now
    found = _of_the_others(context, now.hypothesis, found) | found
    noises = tuple(found.get(c, noise) for c, noise in enumerate(context.noise))
    again = context.work.besides()
    steady = replace(context, noise=noises, claims=True, shown_before={}, work=again)
    done = descend(refit(steady, bare), (DROP, SWAP_ALL, SWAP), Desk())
    context.work.took(again)
    return replace(done, context=replace(done.context, work=context.work))


def _of_the_others(context: Context, hypothesis: Hypothesis, found: dict[int, Noise]) -> dict[int, Noise]:
    """The middle one of several noises that were ``found``, on joints that show more than their own, where it
    is likelier by more than the price of a name: sensors of one unit are alike.
    """
    out = {}
    for column in [c for c in context.columns if c not in found]:
        donors = [noise for c, noise in found.items() if _unit(context, c) == _unit(context, column)]
        known = context.noise[column]
        if len(donors) < SEVERAL or _plain(context, known, hypothesis, column):
            continue
        usual = sorted(donors, key=lambda noise: noise.std)[(len(donors) - 1) // 2]
        gain = _unlikely(context, known, hypothesis, column) - _unlikely(context, usual, hypothesis, column)
        if gain > need(context, column):
            out[column] = usual
    return out


def _unit(context: Context, column: int) -> str:
    return context.stage.units.get(context.joints[column], "rad")


def likeliest_noise(context: Context, hypothesis: Hypothesis, column: int) -> tuple[Noise, float]:
    """The noise by which what a hypothesis leaves of a column is likeliest, and twice the negative logarithm
    of that likelihood, but for a constant.
    """
    parts = _parts(context, hypothesis, column)
    known = context.noise[column]
    longest = SLOWEST * max(len(rest) for rest, _, _ in parts)
    rest_std = float(np.sqrt(np.mean(np.concatenate([rest[counted] for rest, _, counted in parts]) ** 2)))

    def noise_at(x: Array) -> Noise:
        coloured, forgets, white = np.exp(x)
        correlation = float(np.exp(-1.0 / min(max(forgets, 1.0), longest)))
        return Noise(float(np.hypot(coloured, white)), correlation, float(white))

    def cost(x: Array) -> float:
        noise = noise_at(x)
        return sum(noise.unlikely(*part) for part in parts)

    slow = np.sqrt(max(rest_std**2 - known.std**2, 0.01 * known.std**2))
    first = np.log([slow, 0.1 * longest, known.std])
    best = minimize(cost, first, method="Nelder-Mead", options={"xatol": 0.02, "fatol": 1.0, "maxfev": 150})
    return noise_at(best.x), float(best.fun)


def _unlikely(context: Context, noise: Noise, hypothesis: Hypothesis, column: int) -> float:
    return sum(noise.unlikely(*part) for part in _parts(context, hypothesis, column))


def _parts(
    context: Context, hypothesis: Hypothesis, column: int
) -> list[tuple[Array, np.ndarray, np.ndarray]]:
    """By span the residual (n,), where the sample before counts as well, and which rows count."""
    seen = [view.columns[column] for view in context.views]
    rests = context.evened(hypothesis, column)
    return [(rest, s.follows, s.counted) for rest, s in zip(rests, seen, strict=True)]


def _untimed(hypothesis: Hypothesis, column: int) -> Hypothesis:
    """Without the curves over time on a column that a reading which wanders looks like."""
    names = [
        term.effect
        for term in hypothesis.on(column)
        if issubclass(kind := effect(term.effect), Curve) and kind.follows_readings
        if "time" in term.words.get(column, {}).values()
    ]
    return hypothesis.less(names, column) if names else hypothesis


def _plain(context: Context, noise: Noise, hypothesis: Hypothesis, column: int) -> bool:
    """Whether a noise is all that a hypothesis leaves of a column: what swings is more."""
    for rest, follows, counted in _parts(context, hypothesis, column):
        white = noise.whiten(rest, follows)[counted]
        chance = SURE / np.sqrt(max(len(white), 1))
        lags = (lag for lag in LAGS if lag < len(white) // 2)
        if any(abs(float(np.mean(white[lag:] * white[:-lag]))) > WHITE + chance for lag in lags):
            return False
    return True


def _told(context: Context, hypothesis: Hypothesis, column: int) -> bool:
    """Whether the motion tells of parts of the recording what a hypothesis leaves there, by what it left of
    the others.
    """
    found = sources(context, column)
    if not found:
        return False
    cuts = replace(Cuts.on(context, column), fold=np.arange(CUTS) * FOLDS // CUTS)
    sums = Sums.of(found, context.whitened(hypothesis, column), cuts)
    nothing = sums.tried([], 1.0).left
    gains = [1.0 - sums.tried([k], w).left / nothing for k in range(len(found)) for w in WORTHS[::2]]
    return any(g.mean() - NOTABLE * g.std(ddof=1) / np.sqrt(len(g)) > TELLS for g in gains)
