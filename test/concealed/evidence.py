"""From the marks of many cases to the numbers of the proof, every one with its interval."""

from __future__ import annotations

from collections import Counter
from dataclasses import fields, is_dataclass
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np

from test.concealed.calibration import calibration_error, classes, left_out, over_confident, said
from test.concealed.evidence_others import REMOVABLE, WORSE, beaten, compared, median
from test.concealed.intervals import NOTHING, ROUNDS, Estimate, bootstrap, wilson

Marks: TypeAlias = dict[str, Any]
STRENGTHS = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, float("inf"))
ERRORS = (REMOVABLE, 1.0, 4.0, float("inf"))


def rates(cases: list[Marks], effect: str | None = None) -> dict[str, Estimate]:
    """Recall, precision and F1 of one effect or of all pooled."""
    count = np.array([_counts(case, effect) for case in cases]).reshape(-1, 3)
    hit, missed, false = (int(n) for n in count.sum(axis=0))
    found = {"recall": wilson(hit, hit + missed), "precision": wilson(hit, hit + false)}
    return {**found, "f1": _f1(count)}


def _counts(case: Marks, effect: str | None) -> tuple[int, int, int]:
    hits = [h["effect"] for h in case["hits"]]
    sides = (hits, [name for name, _ in case["missed"]], case["false"])
    hit, missed, false = (len(x) if effect is None else x.count(effect) for x in sides)
    return hit, missed, false


def _f1(count: np.ndarray[Any, np.dtype[np.int64]]) -> Estimate:
    """F1 of (cases, 3) hits, missed, false; the interval by resampling cases."""
    if not count.any():
        return NOTHING
    some = np.concatenate([count[count.any(axis=1)]])
    picks = np.random.default_rng(0).integers(0, len(some), (ROUNDS, len(some)))
    total = some[picks].sum(axis=1)
    values = 2 * total[:, 0] / (2 * total[:, 0] + total[:, 1] + total[:, 2])
    hit, missed, false = some.sum(axis=0)
    low, high = np.percentile(values, [2.5, 97.5])
    return Estimate(float(2 * hit / (2 * hit + missed + false)), float(low), float(high), len(some))


def over_strength(cases: list[Marks]) -> list[tuple[float, float, Estimate]]:
    """Recall in classes of strength, effects pooled: (from, to, recall)."""
    found = [(h["strength"], True) for c in cases for h in c["hits"]]
    found += [(strength, False) for c in cases for _, strength in c["missed"]]
    out = []
    for low, high in pairwise(STRENGTHS):
        some = [hit for strength, hit in found if low <= strength < high]
        out.append((low, high, wilson(sum(some), len(some))))
    return out


def confusion(cases: list[Marks]) -> Counter[tuple[str, str]]:
    """(hidden, said): hits, what was said in the place of what was missed, and nothing as "-"."""
    count: Counter[tuple[str, str]] = Counter()
    for case in cases:
        count.update((h["effect"], h["by"]) for h in case["hits"])
        missed, false = [name for name, _ in case["missed"]], list(case["false"])
        count.update((a, b) for a in missed for b in false or ["-"])
        count.update(("-", b) for b in false if not missed)
    return count


def shares_removed(cases: list[Marks]) -> list[float]:
    """Share of the removable error removed on the other motion, of concealed cases that have any."""
    some = [c for c in cases if c["count"] and c.get("before") is not None]
    some = [c for c in some if c["before"] > REMOVABLE * c["noise"]]
    return [1 - c["after"] / c["before"] for c in some]


def made_worse(cases: list[Marks]) -> list[str]:
    """Cases where the fitted model errs more than the nominal arm, by a tenth of the noise and more."""
    some = [c for c in cases if c.get("before") is not None]
    return [c["name"] for c in some if c["after"] > c["before"] + WORSE * c["noise"]]


def _share(values: list[bool]) -> Estimate:
    return wilson(sum(values), len(values))


def _details(hits: list[Marks]) -> dict[str, Estimate]:
    z = np.array([v for h in hits for v in h["z"].values()])
    onset = [h["onset_error"] < 0.5 for h in hits if h["onset_error"] is not None]
    return {
        "named first": _share([h["exact"] for h in hits]),
        "joints IoU, mean": bootstrap([h["iou"] for h in hits], lambda x: float(np.mean(x))),
        "joints all right": _share([h["iou"] > 0.999 for h in hits]),
        "regime right": _share([h["regime"] for h in hits]),
        "onset within 0.5 s": _share(onset),
        "parameters within 2 std": wilson(int((np.abs(z) < 2).sum()), z.size),
        "parameters within 3 std": wilson(int((np.abs(z) < 3).sum()), z.size),
    }


def _removed(cases: list[Marks]) -> dict[str, Estimate]:
    shares = shares_removed(cases)
    return {
        "removed, median": bootstrap(shares, lambda x: float(np.median(x))),
        "removed, tenth percentile": bootstrap(shares, lambda x: float(np.percentile(x, 10))),
        "at least 80 % removed": _share([s >= 0.8 for s in shares]),
        "made worse": wilson(len(made_worse(cases)), sum(c.get("before") is not None for c in cases)),
    }


def removed_over_error(cases: list[Marks]) -> list[tuple[float, float, dict[str, Estimate]]]:
    """The same in classes of the nominal arm's error over the noise: (from, to, shares)."""
    out = []
    for low, high in pairwise(ERRORS):
        some = [c for c in cases if low * c["noise"] <= (c.get("before") or 0.0) < high * c["noise"]]
        out.append((low, high, _removed(some)))
    return out


def evidence(cases: list[Marks]) -> dict[str, Any]:
    """All numbers as Estimates, or lists and tables of them. ``cases``: marks as `judged` keeps them."""
    done = [c for c in cases if "not_drawn" not in c]
    known = [c for c in done if c["known"] and c["count"]]
    strange, clean = [c for c in done if not c["known"]], [c for c in done if not c["count"]]
    names = sorted({e for c in known for e in c["effects"]} | {e for c in known for e in c["false"]})
    kinds = sorted({c["kind"] for c in done})
    of = {kind: [c for c in done if c["kind"] == kind] for kind in kinds}
    seen = [h for c in strange for h in c["hits"]]
    return {
        "all": rates(known),
        "kinds": {
            kind: rates(of[kind]) for kind in kinds if not kind.startswith("clean") and kind != "unknown"
        },
        "effects": {name: rates(known, name) for name in names},
        "details": _details([h for c in known for h in c["hits"]]),
        "removed": _removed(done),
        "removed_over_error": removed_over_error(done),
        "removed_over_error_known": removed_over_error([c for c in done if c["known"]]),
        "removed_worst": min(shares_removed(done), default=None),
        "removed_from": {k: _removed(of[k])["removed, median"] for k in kinds if not k.startswith("clean")},
        "others": compared(done),
        "beaten": beaten(done),
        "over_confident": over_confident(said(done)),
        "calibration_error": calibration_error(said(done)),
        "left_out": left_out(done),
        "seconds": median([c["seconds"] for c in done if not c.get("failed")]),
        "false_alarms": {
            "all": _share([bool(c["false"]) for c in clean]),
            **{k: _share([bool(c["false"]) for c in of[k]]) for k in kinds if k.startswith("clean")},
        },
        "unknown": {
            "reported as unknown": _share([bool(c["hits"]) for c in strange]),
            "what it depends on right": _share([bool(h["depends_on"]) for h in seen]),
            "a known effect named as well or instead": _share(
                [any(f != "unknown" for f in c["false"]) for c in strange]
            ),
        },
        "strength": over_strength(known),
        "calibration": classes(said(done)),
        "confusion": confusion(known),
    }


def as_json(value: Any) -> Any:
    """The same as plain lists, dicts and numbers; infinite and NaN become null."""
    if isinstance(value, Estimate):
        return value.told()
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: as_json(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Counter):
        return [{"hidden": a, "said": b, "n": n} for (a, b), n in value.most_common()]
    if isinstance(value, dict):
        return {k: as_json(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_json(v) for v in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
