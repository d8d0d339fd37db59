"""Drives that seem to clip their setpoints: at an end of its way the shaft stands, and is asked further."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import Candidate, extended, usable
from trunk_ros.diagnosis.search.starts import Starts
from trunk_ros.levels import OUTLIERS, SLIGHT


def clipped(context: Context, column: int) -> Hypothesis | None:
    """What the model knows with limits of a joint's drive where its shaft stood short of its setpoints; None
    where it nowhere did. A loop without a limit turns back where it is asked to.
    """
    asked = np.concatenate([view.span.source[:, column] for view in context.views])
    went = np.concatenate([view.span.gearbox[:, column] for view in context.views])
    kinds = [k for k in usable(context) if k.clips and _short(k.clips * asked, k.clips * went)]
    if not kinds:
        return None
    out, begin = context.known, Starts(context, context.known, [column])
    for kind in kinds:
        starts = begin.on(kind, kind.forms[0], column)
        start = min(starts, key=lambda s: _off(s, kind.clips * went, kind.clips))
        out = extended(context, out, Candidate(kind.id, kind.forms[0], column, start))
    return out


def _short(asked: Array, went: Array) -> bool:
    """Whether a shaft (n,) at the upper end of its way was asked (n,) to go on, mostly."""
    there = went >= np.quantile(went, 1.0 - OUTLIERS)
    return bool(np.median(asked[there] - went[there]) > SLIGHT * np.ptp(went))


def _off(start: dict[str, float], went: Array, way: int) -> float:
    """How far a start is from where the shaft stood."""
    (at,) = start.values()
    return abs(way * at - float(np.quantile(went, 1.0 - OUTLIERS)))
