"""How far each value may be off: by noise, by what is off for longer than a sample, and by what the fit was
not allowed to move.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.evidence.cross_validation import BLOCKS
from trunk_ros.diagnosis.hypothesis import Free, Hypothesis, bounds
from trunk_ros.diagnosis.search.candidates import given
from trunk_ros.diagnosis.search.fit import Fit, groups, step
from trunk_ros.diagnosis.search.formed import behind
from trunk_ros.diagnosis.search.residuals import Residuals
from trunk_ros.effects import effect
from trunk_ros.guards import BLIND, ROUNDED
from trunk_ros.levels import HARDLY, NOTABLE, ROUGH

Spreads = dict[tuple[str, str, int | None], float]
WIDER = 1.5  # times: timing is in no noise, and part of what is off hides in the values that it moves


class _Seen(NamedTuple):
    """What the residuals of a fit and their slopes J tell of its values, all on the scales of the fit."""

    slope: Array
    """(n,) J^T r."""
    normal: Array
    """(n, n) J^T J."""
    alone: Array
    """(n, n) variance of ``slope`` if each sample were off by itself."""
    blocks: Array
    """(n, n) the same if all that is in one of BLOCKS of time were off together."""
    stepped: Array
    """(n,) J^T of what goes on between the stage's own steps."""


def spreads(state: Fit) -> Spreads:
    """Standard deviation of each fitted value, in its own unit, by (effect, parameter, column). What the
    arm's description states is as uncertain as the recordings leave it, and all beside it with that.
    """
    out: Spreads = {}
    context, hypothesis = state.context, _with_what_is_stated_free(state)
    for group in groups(context, hypothesis):
        residuals = Residuals(context, hypothesis, group)
        if residuals.free:
            x = np.clip(hypothesis.free_values(residuals.free), *bounds(residuals.free))
            out |= _no_flatter(residuals, x, _deviations(residuals, x, _seen(residuals, x)))
    return out


def _with_what_is_stated_free(state: Fit) -> Hypothesis:
    out = state.hypothesis.copy()
    for name, term in out.items():
        if name not in state.context.known:
            term.given -= given(effect(name), state.context).keys()
    return out


def _seen(residuals: Residuals, x: Array) -> _Seen:
    n = len(x)
    blocks = np.zeros((BLOCKS, n))
    normal, alone, stepped = *np.zeros((2, n, n)), np.zeros(n)
    seen = zip(residuals.columns, residuals.slopes(x), residuals.parts(x), strict=True)
    for column, (free, slopes), rest in seen:
        if residuals.context.stage.ahead:
            stepped[free] += slopes.T @ behind(residuals.context, column)
        square, here = slopes.T @ slopes, np.ix_(free, free)
        normal[here] += square
        alone[here] += max(float(np.mean(rest**2)), 1.0) * square
        ends = pairwise(np.arange(BLOCKS + 1) * len(rest) // BLOCKS)
        blocks[:, free] += [slopes[begin:end].T @ rest[begin:end] for begin, end in ends]
    return _Seen(blocks.sum(axis=0), normal, alone, BLOCKS / (BLOCKS - 1) * blocks.T @ blocks, stepped)


def _deviations(residuals: Residuals, x: Array, seen: _Seen) -> Spreads:
    std = np.linalg.norm([WIDER * _pulled(seen), _still_to_go(residuals, x, seen), _stepped(seen)], axis=0)
    late = HARDLY * residuals.context.step
    return {
        (f.effect, f.parameter.name, f.column): _natural(f, residuals.hypothesis, float(s), late)
        for f, s in zip(residuals.free, std, strict=True)
    }


def _pulled(seen: _Seen) -> Array:
    """(n,) standard deviations, the larger ones of what each sample and what each block says apart. What
    rounding leaves of ``normal`` is in its variance as well: of values that only do the same together it
    would say that each is half of it.
    """
    size = np.sqrt(np.diag(seen.normal))
    told = size > BLIND
    here, scale = np.ix_(told, told), np.outer(size[told], size[told])
    rounded = ROUNDED * np.eye(len(scale))
    inverse = np.linalg.inv(seen.normal[here] / scale + rounded)
    variances = seen.alone[here] / scale + rounded, seen.blocks[here] / scale
    power = [np.diag(inverse @ variance @ inverse) for variance in variances]
    out = np.full(len(size), np.inf)
    out[told] = np.sqrt(np.max(power, axis=0, initial=0.0)) / size[told]
    return out


def _stepped(seen: _Seen) -> Array:
    """(n,) by how much values would be others if the stage's own steps were finer."""
    size = np.maximum(np.sqrt(np.diag(seen.normal)), BLIND)
    scaled = seen.normal / np.outer(size, size) + ROUNDED * np.eye(len(size))
    return np.asarray(np.abs(np.linalg.solve(scaled, seen.stepped / size)) / size)


def _still_to_go(residuals: Residuals, x: Array, seen: _Seen) -> Array:
    """(n,) by how much the fit would still move its values, within their bounds."""
    low, high = bounds(residuals.free)
    normal = seen.normal + np.diag(residuals.scale**-2.0)
    out: Array = np.clip(x - step(normal, seen.slope, 0.0, x, low, high), low, high) - x
    return out


def _natural(f: Free, hypothesis: Hypothesis, std: float, late: float) -> float:
    """From the fitted scale to the parameter's own unit."""
    value = hypothesis[f.effect].home(f.column)[f.parameter.name]
    if f.parameter.scale != "linear":
        return float(value * np.hypot(std, ROUGH))
    if f.parameter.unit == "s" and not f.parameter.moment:
        return float(np.hypot(std, late))
    return std if f.parameter.moment else float(np.hypot(std, ROUGH * value))


def _no_flatter(residuals: Residuals, x: Array, found: Spreads) -> Spreads:
    """Spreads of moments, widened until the data tell their ends apart: near its best a moment may be moved
    for nothing.
    """
    out = dict(found)
    moments = [(k, f) for k, f in enumerate(residuals.free) if f.parameter.moment and f.column is not None]
    if not moments:
        return out
    best, least = float(np.sum(residuals(x) ** 2)), HARDLY * residuals.context.step
    longest = max(float(np.ptp(view.span.stamp)) for view in residuals.context.views)
    for k, f in moments:
        key = (f.effect, f.parameter.name, f.column)
        std = float(np.clip(out[key], least, longest)) if np.isfinite(out[key]) else least
        while std < longest and _moved(residuals, x, k, std) - best < NOTABLE**2:
            std *= 1.5
        out[key] = std
    return out


def _moved(residuals: Residuals, x: Array, k: int, off: float) -> float:
    """Squared residuals with a value moved by ``off``, to the side where that is cheaper."""
    costs = []
    for side in (-off, off):
        moved = x.copy()
        moved[k] = max(moved[k] + side, 0.0)
        costs.append(float(np.sum(residuals(moved) ** 2)))
    return min(costs)
