"""The diagnosis beside what people would use instead, and the arms of the live graph, with intervals."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from test.concealed.intervals import Estimate, bootstrap, wilson

Marks: TypeAlias = dict[str, Any]
REMOVABLE = 0.2  # of the noise: what is less on the second run is not counted as removable
WORSE = 0.1  # of the noise: what is less is not counted as made worse
WAYS = {
    "diagnosis": "diagnosis",
    "refit": "refit of nominal parameters",
    "boosting": "gradient boosting",
    "sindy": "SINDy",
    "echo": "echo state network",
}


def _errors(case: Marks, way: str) -> Marks:
    return case if way == "diagnosis" else case["others"][way]


def comparable(cases: list[Marks]) -> list[Marks]:
    """Cases that every way was tried on, and whose joints err on both runs."""
    some = [c for c in cases if len(c.get("others", {})) == len(WAYS) - 1 and "before" in c]
    lowest = [min(c["before"], c["others"]["refit"]["fitted_before"]) / c["noise"] for c in some]
    return [c for c, least in zip(some, lowest, strict=True) if least > REMOVABLE]


def removed(case: Marks, way: str, run: str = "") -> float | None:
    """Share removed on the second run, or with ``fitted_`` on the first; 0 where it failed, None: not
    known.
    """
    errors = _errors(case, way)
    before = float(errors.get(f"{run}before", 0.0))
    if before <= REMOVABLE * case["noise"]:
        return None
    return 1 - float(errors.get(f"{run}after", before)) / before


def _shares(cases: list[Marks], way: str, run: str) -> list[float]:
    return [x for c in cases if (x := removed(c, way, run)) is not None]


def _worse(case: Marks, way: str) -> bool:
    errors = _errors(case, way)
    return bool(errors.get("after", errors["before"]) > errors["before"] + WORSE * case["noise"])


def median(values: list[float]) -> Estimate:
    """With the bootstrap's interval."""
    return bootstrap(values, lambda x: float(np.median(x)))


def share(values: list[bool]) -> Estimate:
    """With Wilson's interval."""
    return wilson(sum(values), len(values))


def compared(cases: list[Marks]) -> dict[str, dict[str, Estimate]]:
    """For each way: median removed on the fitted and on another run, how often 80 %, how often worse."""
    some = comparable(cases)
    out = {}
    for way in WAYS:
        fitted, other = (_shares(some, way, run) for run in ("fitted_", ""))
        out[way] = {
            "fitted": median(fitted),
            "other": median(other),
            "mostly": share([x >= 0.8 for x in other]),
            "worse": share([_worse(c, way) for c in some]),
        }
    return out


def shares_by_way(cases: list[Marks]) -> dict[str, list[float]]:
    """Shares removed on another run of the same cases, by the name of the way."""
    some = comparable(cases)
    return {words: _shares(some, way, "") for way, words in WAYS.items()}


def beaten(cases: list[Marks]) -> dict[str, Estimate]:
    """How often the diagnosis leaves less error on the second run than each other way."""
    some = comparable(cases)
    return {
        way: share([c["after"] < _errors(c, way).get("after", c["before"]) for c in some])
        for way in WAYS
        if way != "diagnosis"
    }


def live(arms: list[Marks]) -> dict[str, Estimate]:
    """Shares of the true error that the fitted model in the compensator takes away."""
    done = [one for one in arms if "failed" not in one]
    parts = {k: [1 - one["after"][k] / one["before"][k] for one in done] for k in ("joints", "tip")}
    return {
        "true joint error removed, median": median(parts["joints"]),
        "true tip error removed, median": median(parts["tip"]),
        "arms with at least 85 % of the joint error removed": share([x >= 0.85 for x in parts["joints"]]),
        "arms made worse": share([x < 0 for x in parts["joints"]]),
    }
