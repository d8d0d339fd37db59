"""A diagnosis as rows, and as a table to be read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from trunk_ros.units import as_read

if TYPE_CHECKING:
    from trunk_ros.diagnosis.verdict.answer import Answer

ROW = ("stage", "effect", "joint", "parameter", "value", "std", "unit", "confidence", "equivalents")
NO_VALUE: dict[str, Any] = {"value": None, "std": None, "unit": ""}


def rows_of(result: Answer) -> list[dict[str, Any]]:
    """A row for each joint and parameter of a finding; shared parameters have the joint "arm"."""
    rows = []
    for finding in result.findings:
        common = {"stage": finding.stage, "effect": finding.effect, "confidence": finding.confidence}
        common["equivalents"] = ", ".join(name for name in finding.candidates if name != finding.effect)
        held = [(o, name, value) for o, named in finding.parameters.items() for name, value in named.items()]
        nothing = [(joint, "", NO_VALUE) for joint in finding.joints or ["arm"]]
        for owner, name, value in held or nothing:
            told = {key: value.get(key) for key in ("value", "std", "unit")}
            rows.append({**common, "joint": owner, "parameter": name, **told})
    return [{key: row[key] for key in ROW} for row in rows]


def table_of(result: Answer) -> str:
    """The verdict, what was found with its spread, and what is not explained."""
    lines = [f"verdict: {result.verdict.replace('_', ' ')}"]
    rows = [(*(r[key] for key in ROW[:4]), as_read(r), *_doubt(r)) for r in rows_of(result)]
    if rows:
        head = ("stage", "effect", "joint", "parameter", "value", "sure", "or")
        widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
        lines += ["  ".join(map(str.ljust, row, widths)).rstrip() for row in (head, *rows)]
    lines += [f"event: {event.statement}" for event in result.events]
    return "\n".join([*lines, *(f"unexplained: {rest.statement}" for rest in result.unexplained)])


def _doubt(row: dict[str, Any]) -> tuple[str, str]:
    return f"{row['confidence']:.0%}", row["equivalents"]
