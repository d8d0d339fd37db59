"""``python -m test.bench policy``: what the diagnosis hangs on. Every constant a third up and a third down.

They are changed in a copy of the package, and the same concealed cases are diagnosed with it. Several at
once, each up or down by chance, and then all of them the other way: where F1 stays, it hangs on none of them;
where it does not, each half is tried on its own, down to single ones (group testing, Dorfman 1943).
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

import numpy as np
from rich.console import Console
from rich.table import Table

from test.concealed.generate import generate
from test.concealed.summary import summed_up

ROOT = Path(__file__).parents[2]
PACKAGE = "trunk_ros"
FACTORS = (2 / 3, 4 / 3)
MOST = 0.01  # of F1: what may hang on one constant
CASES, SEEDS, AT_ONCE = 150, 52000, 12
KINDS = (None, None, "masses", "everyday", "awkward", "events")  # None: the proof's own mixture


@dataclass(frozen=True)
class Constant:
    """A number of the policy: the file that has it, its name, and where the text of its value begins there,
    in bytes.
    """

    path: str
    name: str
    start: int
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
    lines = text.encode().splitlines(keepends=True)
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
                start = sum(map(len, lines[: given.lineno - 1])) + given.col_offset
                yield Constant(str(path.relative_to(root)), name.id, start, said)


def _is_numbers(value: ast.expr) -> bool:
    if isinstance(value, ast.Tuple):
        return bool(value.elts) and all(map(_is_numbers, value.elts))
    if isinstance(value, ast.BinOp):
        return _is_numbers(value.left) and _is_numbers(value.right)
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)


Change = tuple[Constant, float]


def changed(changes: Sequence[Change], folder: Path) -> None:
    """A copy of the package in a folder, with some constants times their factors."""
    for name in (PACKAGE, "config"):
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy(ROOT / "package.xml", folder)  # by which it knows that the two belong together
    for constant, factor in sorted(changes, key=lambda change: -change[0].start):
        path = folder / constant.path
        text, end = path.read_bytes(), constant.start + len(constant.value.encode())
        path.write_bytes(text[: constant.start] + constant.scaled(factor).encode() + text[end:])


def dealt(every: Sequence[Constant], at_once: int) -> Iterator[list[Change]]:
    """All constants in groups, each with a factor; always the same ones."""
    rng = np.random.default_rng(SEEDS)
    order = rng.permutation(len(every))
    signs = rng.integers(0, 2, len(every))
    for begin in range(0, len(every), at_once):
        yield [(every[k], FACTORS[signs[k]]) for k in order[begin : begin + at_once]]


def mirrored(changes: Sequence[Change]) -> list[Change]:
    """The same constants, each the other way."""
    return [(constant, FACTORS[1 - FACTORS.index(factor)]) for constant, factor in changes]


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
    parser.add_argument(
        "--at-once", type=int, default=AT_ONCE, help=f"constants that are changed together, default {AT_ONCE}"
    )
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

        def keep() -> None:
            """What is known so far."""
            if asked.output:
                told = {"schema": "trunk_ros/policy/1", "f1": plain, "cases": asked.cases, "rows": rows}
                asked.output.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")

        wanted = [each for each in every if not asked.names or str(each) in asked.names]
        waiting = list(dealt(wanted, asked.at_once))[::-1]
        while waiting:
            group = waiting.pop()
            tried = []
            for changes in (group, mirrored(group)):
                package = there / "package"
                changed(changes, package)
                tried.append(f1_of(package, there / "cases", package / "results", asked.workers) - plain)
                shutil.rmtree(package)
                told = {str(each): each.scaled(factor) for each, factor in changes}
                rows.append({"changed_to": told, "f1": plain + tried[-1]})
                words = ", ".join(f"{each} {each.value} -> {told[str(each)]}" for each, _ in changes)
                console.print(f"{tried[-1]:+.3f} {words}")
                keep()
            if max(map(abs, tried)) > MOST and len(group) > 1:
                half = len(group) // 2
                waiting += [group[half:], group[:half]]
    table = Table("constant", "changed to", "F1", title=f"F1 hangs on these by more than {MOST}")
    for row in rows:
        if abs(row["f1"] - plain) > MOST and len(row["changed_to"]) == 1:
            table.add_row(*row["changed_to"].popitem(), f"{row['f1'] - plain:+.3f}")
    console.print(table if table.row_count else f"F1 hangs on none of them by more than {MOST}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
