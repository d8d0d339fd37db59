"""``python -m test.bench policy``: what the diagnosis hangs on. Every constant a third up and a third down.

Each is changed in a copy of the package, and the same concealed cases are diagnosed with it.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from test.concealed.generate import generate
from test.concealed.summary import summed_up

ROOT = Path(__file__).parents[2]
PACKAGE = "trunk_ros"
FACTORS = (2 / 3, 4 / 3)
MOST = 0.01  # of F1: what may hang on one constant
CASES, SEEDS = 150, 52000
KINDS = (None, None, "masses", "everyday", "awkward", "events")  # None: the proof's own mixture


@dataclass(frozen=True)
class Constant:
    """A number of the policy: the file that has it, its name, and the text of its value there."""

    path: str
    name: str
    line: int
    value: str

    def __str__(self) -> str:
        """By file and name."""
        return f"{Path(self.path).stem}.{self.name}"

    def scaled(self, factor: float) -> str:
        """The text of its value times a factor; whole numbers stay whole, and change by one at least."""
        return re.sub(r"(?<![\w.])[\d_]*\.?\d+(e[+-]?\d+)?", lambda n: _scaled(n[0], factor), self.value)


def _scaled(number: str, factor: float) -> str:
    if not number.replace("_", "").isdigit():
        return repr(float(number) * factor)
    whole = int(number)
    return str(min(round(whole * factor), whole - 1) if factor < 1 else max(round(whole * factor), whole + 1))


def constants(root: Path = ROOT) -> list[Constant]:
    """All numbers, and rows of numbers, that have a name in capitals in the diagnosis; not in its reports."""
    files = sorted((root / PACKAGE / "diagnosis").rglob("*.py"))
    return [each for path in files if "report" not in path.parts for each in _of(path, root)]


def _of(path: Path, root: Path) -> Iterator[Constant]:
    text = path.read_text(encoding="utf-8")
    for node in ast.parse(text).body:
        if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name | ast.Tuple):
            continue
        target, value = node.targets[0], node.value
        pairs = [(target, value)]
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            pairs = list(zip(target.elts, value.elts, strict=True))
        for name, given in pairs:
            if isinstance(name, ast.Name) and name.id.isupper() and _is_numbers(given):
                said = ast.get_source_segment(text, given) or ""
                yield Constant(str(path.relative_to(root)), name.id, given.lineno, said)


def _is_numbers(value: ast.expr) -> bool:
    if isinstance(value, ast.Tuple):
        return bool(value.elts) and all(map(_is_numbers, value.elts))
    if isinstance(value, ast.BinOp):
        return _is_numbers(value.left) and _is_numbers(value.right)
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)


def changed(constant: Constant, factor: float, folder: Path) -> None:
    """A copy of the package in a folder, with another value in one place."""
    for name in (PACKAGE, "config"):
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy(ROOT / "package.xml", folder)  # by which it knows that the two belong together
    path = folder / constant.path
    lines = path.read_text(encoding="utf-8").split("\n")
    line = lines[constant.line - 1]
    at = line.index(constant.value, line.index(constant.name) if constant.name in line else 0)
    lines[constant.line - 1] = line[:at] + constant.scaled(factor) + line[at + len(constant.value) :]
    path.write_text("\n".join(lines), encoding="utf-8")


def f1_of(package: Path, cases: Path, results: Path, workers: int) -> float:
    """F1 over the cases, diagnosed by the package in a folder. Raises RuntimeError where it fails on all."""
    words = [str(cases), "--workers", str(workers), "--label", "policy", "--results", str(results)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (package, ROOT)))}
    subprocess.run(
        [sys.executable, "-m", "test.concealed.score", *words, "--diagnose-only"],
        cwd=package, env=environment, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    marks = [json.loads(path.read_text()) for path in sorted(results.rglob("score.json"))]
    if all(one.get("failed") for one in marks):
        raise RuntimeError(f"every case fails, {marks[0]['name']} with: {marks[0]['failed']}")
    return float(summed_up(marks)["all"]["f1"])


def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.bench policy", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="FILE.NAME", help="constants, all by default")
    parser.add_argument("--cases", type=int, default=CASES, help=f"cases to diagnose, default {CASES}")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--list", action="store_true", help="name all constants, and end")
    parser.add_argument("--output", type=Path, help="JSON file for the figures")
    asked = parser.parse_args(argv)
    every = constants()
    if asked.list:
        print("\n".join(f"{each} = {each.value}" for each in every))
        return 0
    unknown = set(asked.names) - {str(each) for each in every}
    if unknown:
        parser.error(f"no constant {', '.join(sorted(unknown))}: --list names them")
    console = Console(width=None if sys.stdout.isatty() else 110)
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as folder:
        there = Path(folder)
        for seed in range(SEEDS, SEEDS + asked.cases):
            generate(range(seed, seed + 1), there / "cases", KINDS[seed % len(KINDS)])
        plain = f1_of(ROOT, there / "cases", there / "plain", asked.workers)
        console.print(f"F1 {plain:.3f} as it is, {asked.cases} cases")
        for constant in (each for each in every if not asked.names or str(each) in asked.names):
            for factor in FACTORS:
                said = constant.scaled(factor)
                package = there / f"{constant}_{factor:.2f}"
                changed(constant, factor, package)
                f1 = f1_of(package, there / "cases", package / "results", asked.workers)
                rows.append(
                    {"constant": str(constant), "value": constant.value, "changed_to": said, "f1": f1}
                )
                console.print(f"{constant} {constant.value} -> {said}: {f1 - plain:+.3f}")
                shutil.rmtree(package)
    table = Table("constant", "value", "changed to", "F1", title=f"F1 hangs on these by more than {MOST}")
    for row in rows:
        if abs(row["f1"] - plain) > MOST:
            table.add_row(row["constant"], row["value"], row["changed_to"], f"{row['f1'] - plain:+.3f}")
    console.print(table if table.row_count else f"F1 hangs on none of them by more than {MOST}")
    if asked.output:
        told = {"schema": "trunk_ros/policy/1", "f1": plain, "cases": asked.cases, "rows": rows}
        asked.output.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
