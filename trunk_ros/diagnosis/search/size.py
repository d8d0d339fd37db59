"""How large an effect has to be to explain most, from the products of its change with what is left."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np

from trunk_ros.diagnosis.search.candidates import Candidate
from trunk_ros.diagnosis.search.windows import Reach
from trunk_ros.effects import Effect
from trunk_ros.guards import ROUNDED
from trunk_ros.parameter import Parameter, leading


def too_large(products: list[tuple[float, float]]) -> float:
    """By what a start has to be made smaller to fit the joints that it helps; 1 where it is not too large."""
    helped = [(rd, dd) for rd, dd in products if rd > 0.0 and dd > 0.0]
    return min(1.0, sum(rd for rd, _ in helped) / sum(dd for _, dd in helped)) if helped else 1.0


def different(starts: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Those that differ."""
    return list({tuple(start.items()): start for start in starts}.values())


def merit(kind: type[Effect], form: str, rd: float, dd: float) -> float:
    """How well a start fits a joint, whatever its size where that can be scaled."""
    if not kind.scalable:
        return 2 * rd - dd
    along = rd / np.sqrt(max(dd, ROUNDED))
    return float(along if leading(kind.own_parameters(form)).shared else abs(along))


def reach(kind: type[Effect], trial: Candidate) -> Reach:
    """Within which multiples of its start what an effect is in proportion to may be."""
    if not kind.scalable:
        return 1.0, 1.0
    ends = [
        sorted((end - p.absent) / (trial.start[p.name] - p.absent) for end in p.bounds)
        for p in _sizes(kind, trial)
    ]
    return max(low for low, _ in ends), min(high for _, high in ends)


def _sizes(kind: type[Effect], trial: Candidate) -> list[Parameter]:
    """The leading parameter, and what else the effect is in proportion to."""
    own = kind.own_parameters(trial.form)
    lead, begun = leading(own), {n for n in kind.sizes if n in trial.start}
    return [p for p in own if p is lead or ({p.name, lead.name} <= begun and trial.start[p.name] != p.absent)]


def scaled(
    kind: type[Effect], trial: Candidate, rd: float, dd: float, known: Collection[str] = ()
) -> Candidate | None:
    """The candidate with what it is in proportion to scaled to the optimum of a linear look; None where it
    cannot help.
    """
    if dd <= ROUNDED:
        return None
    if not kind.scalable or leading(kind.own_parameters(trial.form)).name in known:
        return replace(trial, gain=2 * rd - dd) if 2 * rd > dd else None
    least, most = reach(kind, trial)
    factor = min(max(rd / dd, least), most)
    gain = factor * (2 * rd - factor * dd)
    if gain <= 0.0 or factor == 0.0:
        return None
    start = {p.name: p.absent + (trial.start[p.name] - p.absent) * factor for p in _sizes(kind, trial)}
    return replace(trial, start={**trial.start, **start}, gain=gain)
