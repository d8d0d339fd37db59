"""From the marks of many cases to the table: recall, precision, joints, regime, what was removed."""

from __future__ import annotations

from collections import Counter, defaultdict
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np

from test.concealed.calibration import CONFIDENCES, classes, said

Entry: TypeAlias = dict[str, Any]
STRENGTHS = (0.0, 1.0, 2.0, 4.0, 8.0, 16.0, np.inf)


def _ratio(a: float, b: float) -> float | None:
    return a / b if b else None


def _rates(hit: int, false: int, missed: int) -> Entry:
    return {
        "hits": hit, "false": false, "missed": missed, "precision": _ratio(hit, hit + false),
        "recall": _ratio(hit, hit + missed), "f1": _ratio(2 * hit, 2 * hit + false + missed),
    }  # fmt: skip


def pooled_rates(cases: list[Entry]) -> Entry:
    """Hits, false and missed over all effects of the cases, with F1."""
    return _rates(*(sum(len(case[key]) for case in cases) for key in ("hits", "false", "missed")))


def per_effect(cases: list[Entry]) -> dict[str, Entry]:
    """The same for each effect."""
    count: dict[str, Counter[str]] = defaultdict(Counter)
    for case in cases:
        for hit in case["hits"]:
            count[hit["effect"]]["hits"] += 1
        for name, _ in case["missed"]:
            count[name]["missed"] += 1
        for name in case["false"]:
            count[name]["false"] += 1
    return {name: _rates(c["hits"], c["false"], c["missed"]) for name, c in sorted(count.items())}


def confusion(cases: list[Entry]) -> list[tuple[str, str, int]]:
    """What was said beside what was missed, the most frequent first; "-" where nothing was."""
    count: Counter[tuple[str, str]] = Counter()
    for case in cases:
        missed, false = [name for name, _ in case["missed"]] or ["-"], case["false"] or ["-"]
        count.update((a, b) for a in missed for b in false if (a, b) != ("-", "-"))
    return [(a, b, n) for (a, b), n in count.most_common()]


def by_strength(cases: list[Entry]) -> list[Entry]:
    """Recall in classes of strength."""
    hits = np.array([h["strength"] or np.nan for c in cases for h in c["hits"]])
    missed = np.array([s or np.nan for c in cases for _, s in c["missed"]])
    out = []
    for low, high in pairwise(STRENGTHS):
        a, b = (int(((x >= low) & (x < high)).sum()) for x in (hits, missed))
        out.append({"from": low, "to": high, "n": a + b, "recall": _ratio(a, a + b)})
    return out


def calibration(cases: list[Entry]) -> list[Entry]:
    """Of the findings in a class of confidence, the share that was right."""
    return [
        {"from": low, "n": share.n, "right": share.value if share.n else None}
        for low, (_, share) in zip(CONFIDENCES, classes(said(cases)), strict=False)
    ]


def _removal(cases: list[Entry]) -> Entry:
    """Over cases with something to remove (more than a tenth of the noise); worse: over all cases."""
    some = [c for c in cases if c.get("before") is not None]
    shares = [1 - c["after"] / c["before"] for c in some if c["before"] > 0.2 * c["noise"]]
    worse = [c["name"] for c in some if c["after"] > 1.02 * c["before"] + 1e-6]
    return {
        "n": len(shares), "median": float(np.median(shares)) if shares else None,
        "worst": min(shares, default=None), "below_80": sum(s < 0.8 for s in shares), "made_worse": worse,
    }  # fmt: skip


def _details(hits: list[Entry]) -> Entry:
    z = np.array([v for h in hits for v in h["z"].values()])
    onset = [h["onset_error"] for h in hits if h["onset_error"] is not None]
    return {
        "joints_iou": float(np.mean([h["iou"] for h in hits])) if hits else None,
        "joints_iou_95": _ratio(sum(h["iou"] >= 0.95 for h in hits), len(hits)),
        "regime": _ratio(sum(h["regime"] for h in hits), len(hits)),
        "onset_within_half_a_second": _ratio(sum(e < 0.5 for e in onset), len(onset)),
        "parameters_within_3_std": _ratio(int((np.abs(z) < 3).sum()), z.size), "parameters": int(z.size),
    }  # fmt: skip


def _unknown(cases: list[Entry]) -> Entry:
    hits = [h for c in cases for h in c["hits"]]
    return {
        "n": len(cases), "found": len(hits), "depends_on": sum(bool(h["depends_on"]) for h in hits),
        "named_in_its_place": sum(any(f != "unknown" for f in c["false"]) for c in cases),
    }  # fmt: skip


def summed_up(cases: list[Entry]) -> Entry:
    """The whole table of the marks of many cases."""
    known = [c for c in cases if c["known"] and c["count"]]
    clean, strange = [c for c in cases if not c["count"]], [c for c in cases if not c["known"]]
    seconds = [c["seconds"] for c in cases]
    return {
        "cases": len(cases), "failed": [c["name"] for c in cases if c.get("failed")],
        "all": pooled_rates(known),
        "by_count": {str(n): pooled_rates([c for c in known if c["count"] == n]) for n in (1, 2, 3, 4)},
        "per_effect": per_effect(known), "confusion": confusion(known), "by_strength": by_strength(known),
        **_details([h for c in known for h in c["hits"]]), "removed": _removal(cases),
        "clean": {"n": len(clean), "alarms": [[c["name"], *c["false"]] for c in clean if c["false"]]},
        "unknown": _unknown(strange), "calibration": calibration(cases),
        "seconds": {"mean": float(np.mean(seconds)), "max": max(seconds)} if seconds else {},
    }  # fmt: skip


def _text(x: Any) -> str:
    return "-" if x is None else f"{x:.3f}" if isinstance(x, float) else str(x)


def as_text(s: Entry) -> str:
    """The table for a terminal."""
    rows = [f"{'effect':28}{'hits':>6}{'missed':>8}{'false':>7}{'precision':>11}{'recall':>8}{'F1':>7}"]
    listed = {"ALL": s["all"], **{f"{n} at once": r for n, r in s["by_count"].items()}, **s["per_effect"]}
    for name, r in listed.items():
        if r["hits"] + r["missed"] + r["false"]:
            shares = "".join(f"{_text(r[k]):>{w}}" for k, w in (("precision", 11), ("recall", 8), ("f1", 7)))
            rows.append(f"{name:28}{r['hits']:>6}{r['missed']:>8}{r['false']:>7}{shares}")
    keys = ("joints_iou", "joints_iou_95", "regime", "onset_within_half_a_second", "parameters_within_3_std",
            "removed", "clean", "unknown", "seconds", "failed")  # fmt: skip
    rows += [f"{key}: {_text(s[key])}" for key in keys]
    rows += [
        "strength: " + "  ".join(f"{b['from']:g}+ {_text(b['recall'])} ({b['n']})" for b in s["by_strength"])
    ]
    sure = (f"{b['from']:g}+ {_text(b['right'])} ({b['n']})" for b in s["calibration"])
    rows += ["confidence: " + "  ".join(sure), "missed / said instead:"]
    return "\n".join(rows + [f"  {n:3} {a} / {b}" for a, b, n in s["confusion"][:20]])
