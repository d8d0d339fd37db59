"""What remains after all findings: how much, and what it still depends on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.motion_content import PLACES
from trunk_ros.data.spectrum import spectrum
from trunk_ros.data.surroundings import counted
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.curves import variables
from trunk_ros.diagnosis.evidence.cross_validation import Error
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.formed import behind, but_for_a_lag, off_by
from trunk_ros.effects.curve import abscissa, words_of
from trunk_ros.levels import HALF, PART, ROUGHLY, SLIGHT, SURE
from trunk_ros.recording.signal.resample import SLOW


def rests(
    context: Context, hypothesis: Hypothesis, errors: Mapping[int, Error] | None = None
) -> dict[int, float]:
    """Columns whose residual is above the noise, and what the model's own laws may be off by: power over the
    noise's, less one. Of the noise as the context has it, see ``at_rest.honest``. ``errors``: also what
    surely is so of blocks that the fit has not seen, of columns on which something was found.
    """
    power = {c: _power(context, hypothesis, c) for c in context.columns}
    for c, error in (errors or {}).items():
        if c in power and hypothesis.new_on(c, context.known):
            sure = (error.sure / context.noise[c].std) ** 2 - 1.0
            power[c] = max(power[c], sure - _of_a_lag(context, hypothesis, c))
    least = {c: max(context.rest(c), _of_laws(context, c) / context.count(c)) for c in power}
    return {c: p for c, p in power.items() if p > least[c] and _coherent(context, hypothesis, c)}


def _of_laws(context: Context, column: int) -> float:
    """Squared unit-noise residual that the model's own laws may leave: of a loop, beside how far it lags,
    which is not counted.
    """
    if context.stage.name != "servo":
        return off_by(context, column)
    later = ROUGHLY * behind(context, column)
    return float(later @ later)


def _of_a_lag(context: Context, hypothesis: Hypothesis, column: int) -> float:
    """Power of a residual, over the noise's, that a loop's lag explains; it is in blocks left out as well."""
    if context.stage.name != "servo":
        return 0.0
    rest = context.whitened(hypothesis, column)
    return float(np.mean(rest**2) - np.mean(but_for_a_lag(context, column, rest) ** 2))


def _power(context: Context, hypothesis: Hypothesis, column: int) -> float:
    """Of the innovations; beside an effect that was found of the residual itself where that surely goes
    further than its noise does: the slow part of what a law is off by is no innovation.
    """
    rest = context.whitened(hypothesis, column)
    if context.stage.name == "servo":
        rest = but_for_a_lag(context, column, rest)
    power = float(np.mean(rest**2)) - 1.0
    noise = context.noise[column]
    if noise.remembers == 0.0 or not hypothesis.new_on(column, context.known):
        return power
    rest = counted(context.views, context.evened(hypothesis, column), column)
    further = float(np.mean(rest**2)) / noise.std**2 - 1.0
    worth = len(rest) * (1.0 - noise.remembers) / (1.0 + noise.remembers)
    return max(power, further) if further > SURE * np.sqrt(2.0 / max(worth, 1.0)) else power


def _coherent(context: Context, hypothesis: Hypothesis, column: int) -> bool:
    """Whether a residual goes on from sample to sample, which outliers and bursts of noise do not."""
    if context.step >= SLOW:
        return True
    noise, products = context.noise[column], []
    for rest, view in zip(context.evened(hypothesis, column), context.views, strict=True):
        follows = view.follows[:, column]
        products.append((rest[1:] * rest[:-1])[follows[1:]])
    return goes_on(np.concatenate(products), noise.goes_on, HALF * context.rest(column) * noise.std**2)


def goes_on(products: Array, own: float, least: float) -> bool:
    """Whether products (n,) of a residual and itself one sample before are more than the noise's ``own``, by
    ``least`` and by more than chance makes of noise that comes in bursts.
    """
    chance = float(np.sqrt(np.sum(products**2))) / max(len(products), 1)
    return float(np.mean(products)) - own > max(least, SURE * chance)


def depends_on(context: Context, hypothesis: Hypothesis, column: int) -> list[str]:
    """Words for what the residual of a column still varies with, the strongest first."""
    scores: dict[str, float] = {}
    left = [context.residual(i, hypothesis, column) for i in range(len(context.views))]
    residual = counted(context.views, left, column)
    if len(residual) < 20 * PLACES or not np.any(residual):
        return []
    for name in ("direction", *variables(context, column)):
        parts = []
        for i, view in enumerate(context.views):
            now = context.now(i, column)
            values = np.sign(now.speed[:, 0]) if name == "direction" else abscissa(name, now, 0)
            parts.append(view.span.measured(values))
        over = counted(context.views, parts, column)
        scores[name] = accounted(over, residual, context.noise[column].remembers)
    index = context.telling(column)[0]
    _, share = spectrum(context.views[index].span.stamp, context.residual(index, hypothesis, column))
    if share > PART:
        scores.setdefault("time", 0.0)
        scores["time"] = max(scores["time"], share)
    told = [name for name in sorted(scores, key=lambda n: -scores[n]) if scores[name] > SLIGHT][:3]
    return list(dict.fromkeys(word for name in told for word in words_of(name)))


def accounted(x: Array, residual: Array, correlation: float = 0.0) -> float:
    """Share of a residual's power in its means over cells of ``x``, less what chance gives (Kelley 1935, PNAS
    21(9)); ``correlation``: of the noise, of which so much less is by chance alone.
    """
    edges = np.quantile(x, np.linspace(0, 1, PLACES + 1)[1:-1])
    cell = np.searchsorted(edges, x)
    counts = np.bincount(cell, minlength=PLACES)
    sums = np.bincount(cell, weights=residual, minlength=PLACES)
    between = float(np.sum(sums[counts > 0] ** 2 / counts[counts > 0]) - residual.sum() ** 2 / len(residual))
    total = float(np.sum((residual - residual.mean()) ** 2))
    if total == 0.0:
        return 0.0
    share, free = between / total, len(residual) * (1.0 - correlation) / (1.0 + correlation)
    chance = (np.count_nonzero(counts) - 1) / max(free - 1.0, 1.0)
    return max((share - chance) / max(1.0 - chance, 0.5), 0.0)
