"""The proof's numbers as Markdown."""

from __future__ import annotations

from typing import Any

from test.concealed.evidence import made_worse, shares_removed
from test.concealed.intervals import Estimate


def _rows(title: tuple[str, ...], rows: list[tuple[Any, ...]]) -> str:
    lines = [title, tuple("---" for _ in title), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def _named(title: tuple[str, str], some: dict[str, Estimate]) -> str:
    return _rows((*title, "n"), [(name, x.text(), x.n) for name, x in some.items()])


def _rates(title: str, some: dict[str, dict[str, Estimate]]) -> str:
    rows = [
        (name, r["recall"].text(), r["precision"].text(), r["f1"].text(), r["recall"].n)
        for name, r in some.items()
    ]
    return _rows((title, "recall", "precision", "F1", "hidden"), rows)


def _strength(bands: list[tuple[float, float, Estimate]]) -> str:
    rows = [(f"{low:g} … {high:g}".replace("inf", "∞"), x.text(), x.n) for low, high, x in bands if x.n]
    return _rows(("strength [noise]", "recall", "n"), rows)


def _calibration(bands: list[tuple[float, Estimate]]) -> str:
    rows = [(f"{said:.2f}", x.text(), x.n) for said, x in bands if x.n]
    return _rows(("confidence said", "of these right", "findings"), rows)


def _confusion(found: dict[str, Any]) -> str:
    pairs = [(a, b, n) for (a, b), n in found["confusion"].most_common() if a != b][:25]
    return _rows(("hidden", "said", "n"), pairs) if pairs else "None."


def _lists(cases: list[dict[str, Any]]) -> str:
    failed = [c["name"] for c in cases if c.get("failed")]
    absent = [c["name"] for c in cases if "not_drawn" in c]
    done = [c for c in cases if "not_drawn" not in c]
    lines = [
        ("ended in an error of the tool (counted as nothing found)", failed),
        ("not drawn: the effect does not come out at the asked strength", absent),
        ("made worse by more than a tenth of the noise", made_worse(done)),
    ]
    return "\n".join(f"- {what}: {len(some)}{': ' + ', '.join(some) if some else ''}" for what, some in lines)


def as_markdown(found: dict[str, Any], cases: list[dict[str, Any]], about: str) -> str:
    """All tables. found: what `evidence` gives; about: what was run, a sentence."""
    worst, n = found["removed_worst"], len(shares_removed([c for c in cases if "not_drawn" not in c]))
    parts = [
        about,
        "### Effects named",
        _rates("cases", {"all": found["all"], **found["kinds"]}),
        "### Joints, regime, parameters (of hits)",
        _named(("what", "share"), found["details"]),
        "### Error removed on another motion",
        _named(("what", "share"), found["removed"]),
        f"Worst case: {'–' if worst is None else f'{worst:.2f}'} (of {n}).",
        _named(("kind", "removed, median"), found["removed_from"]),
        "### Against a refit of nominal parameters (ratio, dead band; physics of the wire alone)",
        _named(("what", "share"), found["refit"]),
        "### False alarms on clean arms",
        _named(("arms", "with any finding"), found["false_alarms"]),
        "### Physics outside the table",
        _named(("what", "share"), found["unknown"]),
        "### Recall over strength",
        _strength(found["strength"]),
        "### Calibration of the confidence",
        _calibration(found["calibration"]),
        "### Per effect, strengths pooled",
        _rates("effect", found["effects"]),
        "### Confusion (most frequent; - is nothing)",
        _confusion(found),
        "### Cases to look at",
        _lists(cases),
    ]
    return "\n\n".join(parts) + "\n"
