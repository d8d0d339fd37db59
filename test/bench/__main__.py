"""Measure speed and memory: python -m test.bench [--output bench.json] [SECTION ...].

``python -m test.bench policy`` measures what the diagnosis hangs on.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import pkgutil
import platform
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from test import bench
from test.bench.compare import changes
from test.bench.releases import kept, last
from test.bench.row import Row
from trunk_ros import __version__

HELPERS = ("__main__", "bare", "compare", "policy", "releases", "row")
MARKS = {True: "[green]reached[/]", False: "[red]missed[/]", None: ""}


def sections() -> list[str]:
    """Names of all sections."""
    return [name for _, name, _ in pkgutil.iter_modules(bench.__path__) if name not in HELPERS]


def run_section(name: str, console: Console) -> dict[str, Any]:
    """Measure one section, print it, and return it for the file."""
    module = importlib.import_module(f"test.bench.{name}")
    table = Table("what", "value", "unit", "target", "", title=(module.__doc__ or name).splitlines()[0])
    begin = time.perf_counter()
    rows: list[Row] = []
    for row in module.measure():
        rows.append(row)
        table.add_row(row.name, f"{row.value:,.4g}", row.unit, row.target, MARKS[row.reached])
        if console.is_terminal:
            console.print(f"  {row.name}: {row.value:,.4g} {row.unit}", style="dim")
    console.print(table)
    return {"seconds": round(time.perf_counter() - begin, 1), "rows": [row.fields() for row in rows]}


def show_changes(console: Console, old: dict[str, Any], done: dict[str, Any]) -> None:
    """A table of what is slower or larger, or faster, by more than a machine does by itself."""
    found = changes(old["sections"], done)
    table = Table("what", "then", "now", "unit", "change", title="Changed since then")
    for each in found:
        colour = "red" if each.worse else "green"
        times = f"[{colour}]{each.factor:+.0%}[/]"
        table.add_row(each.name, f"{each.then:,.4g}", f"{each.now:,.4g}", each.unit, times)
    console.print(table if found else "nothing has changed by more than a tenth")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the sections asked for, all by default; a missed target is said, and no error."""
    argv = sys.argv[1:] if argv is None else list(argv)
    if argv[:1] == ["policy"]:
        return int(importlib.import_module("test.bench.policy").main(argv[1:]))
    parser = argparse.ArgumentParser(prog="python -m test.bench", description=__doc__)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=", ".join(sections()))
    parser.add_argument("--output", type=Path, help="JSON file for the figures")
    parser.add_argument(
        "--compare",
        metavar="OLD.json",
        help="say what has changed since then; `last`: since the last release",
    )
    parser.add_argument("--release", action="store_true", help="keep the figures as those of this version")
    arguments = parser.parse_args(argv)
    unknown = set(arguments.sections) - set(sections())
    if unknown:
        parser.error(f"no section {', '.join(sorted(unknown))}: choose from {', '.join(sections())}")
    if arguments.release and arguments.sections:
        parser.error("--release: give no sections, a release has all")
    console = Console(width=None if sys.stdout.isatty() else 110)
    machine = {"python": platform.python_version(), "machine": platform.machine(), "cores": os.cpu_count()}
    done = {name: run_section(name, console) for name in arguments.sections or sections()}
    report = {"schema": "trunk_ros/bench/1", "version": __version__, "machine": machine, "sections": done}
    for path in filter(None, (arguments.output, kept() if arguments.release else None)):
        path.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    old = last() if arguments.compare == "last" else arguments.compare and Path(arguments.compare)
    if old:
        show_changes(console, json.loads(old.read_text(encoding="utf-8")), done)
    missed = [row["name"] for section in done.values() for row in section["rows"] if row["reached"] is False]
    if missed:
        console.print(f"[red]missed:[/] {', '.join(missed)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
