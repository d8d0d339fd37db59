"""Noise that only motion makes is none: what a sensor remembers goes on while its joint rests, and what is in
its readings makes them rough.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.noise import Noise, roughness_of
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.disturbances.knocks import standing
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.levels import CERTAIN, CLEARLY, ENOUGH, FEWEST, PART
from trunk_ros.recording.signal.resample import SLOW


def honest(context: Context, hypothesis: Hypothesis) -> Context:
    """With the noise that joints at rest show, where these surely lie still, each rest at a place of its own,
    rather than wander as their noise would: that a place is off by another amount is no noise of a sensor.
    Shafts are asked for what is exact: their noise is in their readings, or there is none.
    """
    if context.step >= SLOW:
        return context
    if context.stage.name != "wire":
        return _as_read(context)
    told = {c: _at_rest(context, hypothesis, c) for c in context.columns if context.noise[c].remembers > 0.0}
    if not any(told.values()):
        return context
    return context.in_noise([told.get(c) or n for c, n in enumerate(context.noise)])


def _as_read(context: Context) -> Context:
    """With noise that is in the readings, on columns whose readings are clearly smoother than theirs."""
    told = {}
    for c in context.columns:
        seen = [view.columns[c] for view in context.views]
        most = roughness_of([s.target for s in seen], [s.valid for s in seen])
        if CLEARLY * most < context.noise[c].roughness:
            told[c] = Noise(float(np.hypot(most, context.resolution[c])))
    noise = [told.get(c, n) for c, n in enumerate(context.noise)]
    return replace(context, louder=context.louder.but_on(told)).in_noise(noise) if told else context


def _at_rest(context: Context, hypothesis: Hypothesis, column: int) -> Noise | None:
    """The noise of a column's rests, None where they do not tell or the one that is known goes on in them."""
    noise, seen = context.noise[column], _rests(context, hypothesis, column)
    many = sum(len(rest) for rest in seen)
    if many < ENOUGH:
        return None
    about = [rest - rest.mean() for rest in seen]
    power = float(np.sum(np.concatenate(about) ** 2)) / (many - len(seen))
    as_white = replace(noise, white=np.sqrt(power), std=float(np.sqrt(noise.std**2 - noise.white**2 + power)))
    still = many * (np.log(power) + 1.0) + sum(np.log(len(r) * noise.std**2 / power + 1.0) for r in seen)
    wandering = min(sum(_unlikely(one, rest) for rest in seen) for one in (noise, as_white))
    std = float(np.hypot(np.sqrt(power), context.steps(column)))
    return Noise(std) if wandering - still > CERTAIN**2 and std < noise.std else None


def _unlikely(noise: Noise, rest: Array) -> float:
    """Twice the negative logarithm of the likelihood of what is left in one rest (k,), but for a constant."""
    rows = np.arange(len(rest))
    return noise.unlikely(rest, rows > 0, rows)


def _rests(context: Context, hypothesis: Hypothesis, column: int) -> list[Array]:
    """What a hypothesis leaves of a column while its motor stands, (k,) each."""
    out, ratio = [], context.stage.ratio(hypothesis, column)
    for off, view in zip(context.evened(hypothesis, column), context.views, strict=True):
        least = max(PART * float(context.arm.dead_band[column]), PART * context.noise[column].std)
        for first, last in standing(view.span.gearbox[:, column], view.span.rows, ratio, least):
            rest = off[first:last][view.span.valid[first:last, column]]
            if len(rest) >= FEWEST:
                out.append(rest)
    return out
