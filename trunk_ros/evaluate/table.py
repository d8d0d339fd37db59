"""Rows for people, and as CSV."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from trunk_ros.data.noise import is_none
from trunk_ros.evaluate.score import Row
from trunk_ros.units import SMALL
from trunk_ros.words import significant

ROUNDING = "≈ 0"  # what is no more than rounding
NONE = "–"  # where there is no noise to compare with


def show(rows: Sequence[Row], console: Console) -> None:
    """A row for each signal; where there are several recordings or models, the models beside each other."""
    table = Table("recording", "model", "stage", "joint", box=None, pad_edge=False)
    for head in ("rms before", "rms", "worst before", "worst", "noise", "rms/noise"):
        table.add_column(head, justify="right")
    for row in rows:
        factor, unit = SMALL.get(row.unit, (1.0, row.unit))
        sizes = (row.rms_before, row.rms_after, row.worst_before, row.worst_after, row.noise)
        said = [ROUNDING if is_none(size) else f"{significant(size * factor)} {unit}" for size in sizes]
        said.append(significant(row.in_noise) if row.has_noise else NONE)
        table.add_row(row.recording, row.model, row.stage, row.joint, *said)
    console.print(table)
    if len({(row.recording, row.model) for row in rows}) > 1:
        console.print(summary(rows))


def summary(rows: Sequence[Row]) -> Table:
    """A line for each model: rms over noise of all its signals, in the median and at the worst."""
    table = Table("model", box=None, pad_edge=False, title="rms/noise", title_justify="left")
    for head in ("signals", "median", "worst", "where"):
        table.add_column(head, justify="left" if head == "where" else "right")
    for model in dict.fromkeys(row.model for row in rows):
        every = [row for row in rows if row.model == model]
        mine = [row for row in every if row.has_noise]
        if not mine:
            table.add_row(model, str(len(every)), NONE, NONE, "no signal has noise")
            continue
        worst = max(mine, key=lambda row: row.in_noise)
        median = float(np.median([row.in_noise for row in mine]))
        where = f"{worst.recording}, {worst.stage} {worst.joint}"
        table.add_row(model, str(len(every)), significant(median), significant(worst.in_noise), where)
    return table


def save_csv(rows: Sequence[Row], path: Path) -> None:
    """The columns of ``--json``, a line for each row."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, [field.name for field in fields(Row)])
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)
