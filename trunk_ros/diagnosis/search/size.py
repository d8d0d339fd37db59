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
from trunk_ros.parameter import leading


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
    """Within which multiples of its start the leading parameter may be."""
    lead = leading(kind.own_parameters(trial.form))
    if not kind.scalable:
        return 1.0, 1.0
    ends = (np.array(lead.bounds) - lead.absent) / (trial.start[lead.name] - lead.absent)
    return float(ends.min()), float(ends.max())


def scaled(
    kind: type[Effect], trial: Candidate, rd: float, dd: float, known: Collection[str] = ()
) -> Candidate | None:
    """The candidate with its leading parameter scaled to the optimum of a linear look; None where it
    cannot help.
    """
    if dd <= ROUNDED:
        return None
    lead = leading(kind.own_parameters(trial.form))
    off = lead.absent
    if not kind.scalable or lead.name in known:
        return replace(trial, gain=2 * rd - dd) if 2 * rd > dd else None
    factor = rd / dd
    value = off + (trial.start[lead.name] - off) * factor
    low, high = lead.bounds
    if not low <= value <= high:
        value = min(max(value, low), high)
        factor = (value - off) / (trial.start[lead.name] - off)
    gain = factor * (2 * rd - factor * dd)
    if gain <= 0.0 or factor == 0.0:
        return None
    return replace(trial, start={**trial.start, lead.name: value}, gain=gain)
