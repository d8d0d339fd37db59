"""What was hidden beside what was said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rich.table import Table

from test.concealed.marks import Entry, joints_iou, matched


@dataclass(frozen=True)
class Answer:
    """One hidden effect (an entry as of truth.json), and the finding that names it, where there is one."""

    truth: Entry
    finding: Entry | None
    exact: bool

    @property
    def words(self) -> str:
        """How it was named."""
        if self.finding is None:
            return "[red]missed[/]"
        if self.exact:
            return "[green]named[/]"
        return f"[green]as an equivalent of {self.finding['effect']}[/]"


def answers(truth: list[Entry], findings: list[Entry]) -> tuple[list[Answer], list[Entry]]:
    """An answer for each hidden effect, and the findings that name none."""
    pairs = {id(t): (f, exact) for t, f, exact in matched(truth, findings) if joints_iou(t, f) > 0}
    given = [Answer(one, *pairs.get(id(one), (None, False))) for one in truth]
    right = [id(one.finding) for one in given]
    return given, [f for f in findings if id(f) not in right]


def table(given: list[Answer]) -> Table:
    """A row for each hidden parameter."""
    out = Table("hidden", "on", "", "true", "found", "", box=None, padding=(0, 2, 0, 0), header_style="dim")
    for answer in given:
        for n, (joint, name, value) in enumerate(_parameters(answer.truth)):
            first = (answer.truth["effect"], answer.words) if n == 0 else ("", "")
            where = "all" if joint == "arm" else joint
            # of another form than the contract's, the true value has no counterpart in what was found
            true = _number(value) + ("" if answer.truth["same"] else f" ({answer.truth['form']})")
            out.add_row(first[0], where, name, true, _found(answer.finding, joint, name), first[1])
    return out


def _parameters(truth: Entry) -> list[tuple[str, str, Any]]:
    same = truth["same"] or [name for values in truth["parameters"].values() for name in values]
    return [
        (joint, name, value)
        for joint, values in truth["parameters"].items()
        for name, value in values.items()
        if name in same
    ]


def _found(finding: Entry | None, joint: str, name: str) -> str:
    said = {} if finding is None else finding["parameters"]
    for where in (joint, "arm", *said):  # the source of a coupling stands with each joint
        if name in said.get(where, {}):
            one = said[where][name]
            spread = f" ± {one['std']:.1g}" if one.get("std") else ""
            unit = one.get("unit") or ""
            return f"{_number(one['value'])}{spread} {'' if unit == '1' else unit}".strip()
    return ""


def _number(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(_number, value))
    return value if isinstance(value, str) else f"{value:.4g}"
