"""The proof's numbers as Markdown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from test.concealed.calibration import LeftOut
from test.concealed.evidence import made_worse, shares_removed
from test.concealed.evidence_others import WAYS, live
from test.concealed.intervals import Estimate
from test.concealed.paper_case import Row


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
    return _rows(("stated confidence", "share right", "findings"), rows)


def _left_out(plants: list[LeftOut]) -> str:
    rows = [
        (one.plant, one.right.n, f"{one.said:.2f}", one.right.text(), one.off.text(), f"{one.error:.2f}",
         f"{one.brier[0]:.3f}", f"{one.brier[1]:.3f}")
        for one in plants
    ]  # fmt: skip
    title = ("plant", "findings", "said", "right", "said less right", "calibration error", "squared error",
             "as the others would have it")  # fmt: skip
    return _rows(title, rows)


def _confusion(found: dict[str, Any]) -> str:
    pairs = [(a, b, n) for (a, b), n in found["confusion"].most_common() if a != b][:25]
    return _rows(("hidden", "found", "n"), pairs) if pairs else "None."


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


def _others(found: dict[str, Any]) -> str:
    rows = [
        (WAYS[way], e["fitted"].text(), e["other"].text(), e["mostly"].text(), e["worse"].text(),
         found["beaten"][way].text() if way in found["beaten"] else "")
        for way, e in found["others"].items()
    ]  # fmt: skip
    title = ("way", "fitted run, median removed", "another run, median removed", "another run, at least 80 %",
             "another run, made worse", "diagnosis leaves less")  # fmt: skip
    return f"{found['others']['diagnosis']['other'].n} cases.\n\n" + _rows(title, rows)


def _over_error(found: dict[str, Any]) -> str:
    keys = ("removed, median", "removed, tenth percentile", "at least 80 % removed")
    rows = [
        (f"{low:g} … {high:g}, {what}", *(shares[k].text() for k in keys), shares[keys[0]].n)
        for what, key in (("all", "removed_over_error"), ("with a name", "removed_over_error_known"))
        for low, high, shares in found[key]
    ]
    return _rows(("error of the nominal arm / noise", *keys, "n"), rows)


def _live(arms: list[dict[str, Any]]) -> str:
    if not arms:
        return "Not run."
    rows = []
    for one in arms:
        if "failed" in one:
            rows.append((one["seed"], ", ".join(one["effects"]), one["failed"], "", "", ""))
            continue
        joints, tip = (
            f"{1e3 * one['before'][k]:.2f} → {1e3 * one['after'][k]:.3f}" for k in ("joints", "tip")
        )
        gone = 1 - one["after"]["joints"] / one["before"]["joints"]
        rows.append(
            (one["seed"], ", ".join(one["effects"]), f"{one['named']} of 3", joints, tip, f"{gone:.2f}")
        )
    title = ("arm", "hidden", "named", "joints [mrad rms]", "tip [mm rms]", "of the joint error removed")
    return _rows(title, rows) + "\n\n" + _named(("over the arms", "share"), live(arms))


def _paper(rows: list[Row]) -> str:
    lines = [
        (row.quantity, f"{100 * row.formulas_off:.1f} %", f"{100 * row.corrected_off:.3f} %", row.said)
        for row in rows
    ]
    return _rows(
        ("table 2", "formulas off by up to", "corrected, off by", "what was swapped or left out"), lines
    )


@dataclass(frozen=True)
class Beside:
    """What the proof holds beside the cases: arms of the live graph, rows of the paper, killed recorders, an
    arm in chaos.
    """

    live: list[dict[str, Any]]
    paper: list[Row]
    kill: dict[str, Any] | None = None
    chaos: dict[str, Any] | None = None


def _kill(kill: dict[str, Any] | None) -> str:
    if kill is None:
        return "Not run."
    return (
        f"{kill['times']} recorders were killed at random moments. Every bag could be repaired and read; at "
        f"most {kill['worst_lost_s']:.3f} s before the kill were lost."
    )


def _chaos(chaos: dict[str, Any] | None) -> str:
    if chaos is None:
        return "Not run."
    done = ", ".join(f"{count} times {what}" for what, count in sorted(chaos["done"].items()))
    odd = [*chaos["not_finite"], *chaos["ended_by_themselves"], *chaos["broken_bags"]]
    odd += [f"{node} is not back: {said or 'no reason given'}" for node, said in chaos["reasons"].items()]
    came = "; ".join(odd) or "only finite numbers were published, and all nodes came back."
    among, fastest = chaos["hostile_messages"], chaos["fastest_over_limit"]
    return (
        f"{chaos['seconds']:.0f} s of four nodes ({done}) among {among} hostile messages: the gearbox "
        f"went at most {fastest:.4f} times as fast as the servo's limit; {came}"
    )


def as_markdown(found: dict[str, Any], cases: list[dict[str, Any]], about: str, beside: Beside) -> str:
    """All tables. found: what `evidence` gives; about: what was run, a sentence."""
    worst, n = found["removed_worst"], len(shares_removed([c for c in cases if "not_drawn" not in c]))
    parts = [
        about + f" A diagnosis took {found['seconds'].text(1)} s in the median.",
        "### Effects named",
        _rates("cases", {"all": found["all"], **found["kinds"]}),
        "### Joints, regime, parameters (of hits)",
        _named(("what", "share"), found["details"]),
        "### Error removed on another motion",
        _named(("what", "share"), found["removed"]),
        f"Worst case: {'–' if worst is None else f'{worst:.2f}'} (of {n}).",
        _named(("kind", "removed, median"), found["removed_from"]),
        _over_error(found),
        "![Share of the removable error removed, over the cases](figures/proof-removed.png)",
        "### Against what people would use instead",
        _others(found),
        "![Share removed on the fitted and on another run](figures/proof-trap.png)",
        "### On the live graph",
        _live(beside.live),
        *(["![True error before and after](figures/proof-live.png)"] if beside.live else []),
        "### False alarms on clean arms",
        _named(("arms", "with any finding"), found["false_alarms"]),
        "### Effects that are not in the library",
        _named(("what", "share"), found["unknown"]),
        "### Recall over strength",
        _strength(found["strength"]),
        "![Recall over strength](figures/proof-strength.png)",
        "### Calibration of the confidence",
        _calibration(found["calibration"]),
        f"Mean confidence less share right: {found['over_confident'].text()}. Calibration error: "
        f"{found['calibration_error']:.3f}, the mean distance of a class from the share right in it.",
        "Each plant with the others alone: a map of confidence (slope and offset of its logit) fitted to the "
        "other plants, and what the squared error of the confidence is with it.",
        _left_out(found["left_out"]),
        "![Calibration](figures/proof-calibration.png)",
        "### Per effect, strengths pooled",
        _rates("effect", found["effects"]),
        "![Recall and precision per effect](figures/proof-effects.png)",
        "### Confusion (most frequent; - is nothing)",
        _confusion(found),
        "![Hidden and said](figures/proof-confusion.png)",
        "### The paper's own table",
        "Computed by `trunk_ros paper`; [The paper, checked](paper.md) has all of it.",
        _paper(beside.paper),
        "### Killed recorders",
        _kill(beside.kill),
        "### An arm in chaos",
        _chaos(beside.chaos),
        "### Cases to look at",
        _lists(cases),
    ]
    return "\n\n".join(parts) + "\n"
