"""Whether a stated confidence means what it says on plants that had no part in it: each left out in turn."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from test.concealed.intervals import Estimate, bootstrap, wilson

CONFIDENCES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.97, 1.01)
BUILT = ("masses", "everyday", "events", "awkward")
PLANTS = {**dict.fromkeys(BUILT, "masses"), "mujoco": "mujoco", "wire": "wire"}
FORMULA = "formula"
SURE = 1e-3  # of a logit's confidence: nothing is said at 0 or 1

Floats = NDArray[np.float64]
Said = list[tuple[float, bool]]


@dataclass(frozen=True)
class LeftOut:
    """One plant: what was said on it, and what a map of confidence fitted to the others makes of it."""

    plant: str
    right: Estimate
    said: float
    """Mean confidence."""
    off: Estimate
    """Mean confidence less the share that was right."""
    error: float
    """Expected calibration error: mean distance of a class of confidence from the share right in it."""
    brier: tuple[float, float]
    """Mean squared error of the confidence, as it was said and as the others would have it."""


def plant(kind: str) -> str:
    """The plant that a kind of case comes from."""
    return PLANTS.get(kind.removeprefix("clean_"), FORMULA)


def said(cases: list[dict[str, Any]]) -> Said:
    """(confidence, right) of every finding."""
    return [(float(c), bool(right)) for case in cases for c, right in case["confidence"] if c is not None]


def classes(some: Said) -> list[tuple[float, Estimate]]:
    """Mean confidence in a class of it, and the share of its findings that was right."""
    out = []
    for low, high in pairwise(CONFIDENCES):
        inside = [(c, right) for c, right in some if low <= c < high]
        mean = float(np.mean([c for c, _ in inside])) if inside else float("nan")
        out.append((mean, wilson(sum(right for _, right in inside), len(inside))))
    return out


def calibration_error(some: Said) -> float:
    """Mean distance of the classes from the share that was right in them, over findings."""
    held = [(mean, share) for mean, share in classes(some) if share.n]
    return float(sum(share.n * abs(mean - share.value) for mean, share in held) / max(len(some), 1))


def over_confident(some: Said) -> Estimate:
    """Mean confidence said, less the share of findings that was right."""
    return bootstrap(some, lambda few: float(np.mean([c - right for c, right in few])))


def left_out(cases: list[dict[str, Any]]) -> list[LeftOut]:
    """Each plant of which findings were said, judged with the others alone."""
    of: dict[str, Said] = {}
    for case in cases:
        of.setdefault(plant(case["kind"]), []).extend(said([case]))
    of = {name: some for name, some in of.items() if some}
    out = []
    for name, some in of.items():
        rest = [one for other, more in of.items() if other != name for one in more]
        c, right = _arrays(some)
        mapped = _mapped(c, _map(rest)) if rest else c
        brier = float(np.mean((c - right) ** 2)), float(np.mean((mapped - right) ** 2))
        share = wilson(int(right.sum()), len(right))
        off, error = over_confident(some), calibration_error(some)
        out.append(LeftOut(name, share, float(np.mean(c)), off, error, brier))
    return out


def _arrays(some: Said) -> tuple[Floats, Floats]:
    return np.array([c for c, _ in some]), np.array([float(right) for _, right in some])


def _logit(c: Floats) -> Floats:
    held = np.clip(c, SURE, 1.0 - SURE)
    return np.asarray(np.log(held / (1.0 - held)))


def _map(some: Said) -> tuple[float, float]:
    """Slope and offset of the logit (Platt, 1999), held to leaving it as it is by one finding's worth."""
    c, right = _arrays(some)
    x = _logit(c)

    def cost(at: Floats) -> float:
        z = at[0] * x + at[1]
        return float(np.sum(np.logaddexp(0.0, z) - right * z) + 0.5 * ((at[0] - 1.0) ** 2 + at[1] ** 2))

    slope, offset = minimize(cost, np.array([1.0, 0.0])).x
    return float(slope), float(offset)


def _mapped(c: Floats, how: tuple[float, float]) -> Floats:
    return np.asarray(1.0 / (1.0 + np.exp(-(how[0] * _logit(c) + how[1]))))
