"""Marks for one diagnosis against the truth: hits, misses, joints, regime, parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

Entry: TypeAlias = dict[str, Any]
PERIODIC = {"phase": 2 * np.pi}
STATED = 1e-9  # of a value: nothing that is fitted comes so near


def _is(finding: Entry, truth: Entry) -> bool:
    """The finding names the truth; of physics outside the table: ``unknown``, its stage, a joint of it."""
    if truth["known"]:
        return bool(finding["effect"] == truth["effect"])
    where = finding["stage"] == truth["stage"]
    touched = truth["stage"] == "arm" or bool(set(finding["joints"]) & set(truth["joints"]))
    return finding["effect"] == "unknown" and where and touched


def _might_be(finding: Entry, truth: Entry) -> bool:
    """One of the first two equivalents names the truth."""
    return any(_is({**finding, "effect": other}, truth) for other in finding.get("equivalents", [])[:2])


def matched(truth: list[Entry], findings: list[Entry]) -> list[tuple[Entry, Entry, bool]]:
    """Pairs of truth and finding, and whether by its own name; every finding serves once."""
    pairs: list[tuple[Entry, Entry, bool]] = []
    free, wanted = list(findings), list(truth)
    for test, exact in ((_is, True), (_might_be, False)):
        for one in list(wanted):
            found = next((f for f in free if test(f, one)), None)
            if found is not None:
                pairs.append((one, found, exact))
                wanted.remove(one)
                free.remove(found)
    return pairs


def joints_iou(truth: Entry, finding: Entry) -> float:
    """Intersection over union of the joints; two empty lists agree."""
    a, b = set(truth["joints"]), set(finding["joints"])
    return len(a & b) / len(a | b) if a | b else 1.0


def _apart(name: str, value: float, true: float) -> float:
    turn = PERIODIC.get(name)
    gap = value - true
    return gap if turn is None else float((gap + turn / 2) % turn - turn / 2)


def z_scores(truth: Entry, finding: Entry) -> dict[str, float]:
    """(value - truth)/std of every comparable parameter, as "joint_2.gain".

    Infinite for a wrong value without a std; a right one (1 %) that was not fitted has no spread to be held
    to, and one that is true to the last digits is the description's.
    """
    out: dict[str, float] = {}
    for where, true in truth["parameters"].items():
        said = finding.get("parameters", {}).get(where, {})
        for name in truth["same"]:
            if name in true and name in said and not isinstance(true[name], str):
                std = said[name].get("std") or 0.0
                gap = _apart(name, said[name]["value"], true[name])
                stated = std > 0 and abs(gap) < STATED * abs(true[name])
                if not stated and (std > 0 or abs(gap) > 0.01 * abs(true[name])):
                    out[f"{where}.{name}"] = gap / std if std > 0 else float("inf")
    return out


def _onset_error(truth: Entry, finding: Entry) -> float | None:
    if truth["effect"] != "wire_slip" or finding["effect"] != "wire_slip":
        return None
    errors = [
        abs(finding["parameters"][joint]["onset"]["value"] - true["onset"])
        for joint, true in truth["parameters"].items()
        if "onset" in finding["parameters"].get(joint, {})
    ]
    return max(errors, default=None)


def _event_error(truth: Entry, events: list[Entry]) -> float | None:
    """How far off (s) an event's beginning is said; None where none is owed, infinite where none is said."""
    begin = truth.get("extra", {}).get("from")
    if begin is None:
        return None
    said = [e["from"] for e in events if e["effect"] == truth["effect"] and e.get("from") is not None]
    return min((abs(one - begin) for one in said), default=float("inf"))


def _hit(truth: Entry, finding: Entry, exact: bool, events: list[Entry]) -> Entry:
    depends = truth["depends_on"]
    return {
        "effect": truth["effect"],
        "by": finding["effect"],
        "exact": exact,
        "strength": truth.get("strength"),
        "iou": joints_iou(truth, finding),
        "regime": finding["regime"] == truth["regime"],
        "z": z_scores(truth, finding) if exact and truth["known"] else {},
        "onset_error": _onset_error(truth, finding),
        "event_error": _event_error(truth, events),
        "depends_on": None
        if truth["known"]
        else any(depends in str(x) for x in finding.get("depends_on", [])),
    }


def marked(truth: list[Entry], diagnosis: Entry, allowed: Sequence[str] = ()) -> Entry:
    """Marks of one case: ``hits``, what was ``missed``, what was said falsely, the confidences.

    allowed: names that are no lie in this recording, though nobody owes them; they do not count.
    """
    findings = diagnosis["findings"]
    pairs = matched(truth, findings)
    right = [id(f) for _, f, _ in pairs]
    findings = [f for f in findings if id(f) in right or f["effect"] not in allowed]
    events = diagnosis.get("events", [])
    found = [id(t) for t, _, _ in pairs]
    return {
        "verdict": diagnosis["verdict"],
        "hits": [_hit(*pair, events) for pair in pairs],
        "missed": [[t["effect"], t.get("strength")] for t in truth if id(t) not in found],
        "false": [str(f["effect"]) for f in findings if id(f) not in right],
        "confidence": [[f.get("confidence"), id(f) in right] for f in findings],
    }
