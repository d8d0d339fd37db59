"""``python -m test.bench policy``: what the diagnosis hangs on. Every constant a third up and a third down.

They are changed in copies of the package, all at once: each up or down by chance, and in the next copy all
the other way. A few of the concealed cases are diagnosed with each pair of copies, and what goes wrong with
one of a pair and not with the other is put down to each constant by its sign, so that every diagnosis tells
of all of them (a factorial experiment, Fisher 1926). Those that seem to matter, by chance one in twenty, are
then changed alone, on the cases that some copy got wrong.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from test.concealed.generate import generate
from test.concealed.summary import pooled_rates

ROOT = Path(__file__).parents[2]
PACKAGE = "trunk_ros"
FACTORS = (2 / 3, 4 / 3)
MOST = 0.01  # of F1: what may hang on one constant
CASES, SEEDS = 150, 52000
FEW = 6  # cases that are diagnosed with a copy
SEEN = 2  # pairs of copies that see a case
SURE = 2.0  # standard errors from which a constant seems to matter
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
        """The text of its value times a factor; whole numbers stay whole, change by one at least, and 1
        is no number to change; of a share that would exceed 1 it is what is left to 1 that changes.
        """
        numbers = r"(?<![\w.])(\d+\*\*\d+|[\d_]*\.?\d+(e[+-]?\d+)?)"
        return re.sub(numbers, lambda n: _scaled(n[0], factor), self.value)


def _scaled(number: str, factor: float) -> str:
    base, power, exponent = number.partition("**")
    if power:
        return str(round(int(base) ** int(exponent) * factor))
    if not number.replace("_", "").isdigit():
        value = float(number)
        share = value < 1.0 <= value * max(FACTORS)
        return repr(1.0 - (1.0 - value) * (2.0 - factor) if share else value * factor)
    whole = int(number)
    if whole < 2:
        return number
    return str(min(round(whole * factor), whole - 1) if factor < 1 else max(round(whole * factor), whole + 1))


def constants(root: Path = ROOT) -> list[Constant]:
    """All numbers, and rows of numbers, that have a name in capitals in the diagnosis; not in its reports."""
    own = ("diagnosis", "data", "levels.py", "machine.py", "heap.py", "units.py")
    rooms = [root / PACKAGE / name for name in own]
    files = sorted(p for room in rooms for p in (room.rglob("*.py") if room.is_dir() else [room]))
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
Marks = dict[str, dict[str, Any]]


def changed(changes: Sequence[Change], folder: Path) -> None:
    """A copy of the package in a folder, with some constants times their factors."""
    for name in (PACKAGE, "config"):
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy(ROOT / "package.xml", folder)  # by which it knows that the two belong together
    for constant, factor in sorted(changes, key=lambda change: -change[0].start):
        path = folder / constant.path
        text, end = path.read_bytes(), constant.start + len(constant.value.encode())
        path.write_bytes(text[: constant.start] + constant.scaled(factor).encode() + text[end:])


def dealt(every: Sequence[Constant], pairs: int) -> NDArray[np.int64]:
    """(pairs, constants) of +1 and -1: whether the first of a pair of copies has a constant up or down.
    Always the same ones; each is up as often as down, or once less.
    """
    rng = np.random.default_rng(SEEDS)
    even = np.where(np.arange(pairs)[:, None] % 2, 1, -1).repeat(len(every), axis=1)
    return np.asarray(rng.permuted(even, axis=0))


def wrong(mark: dict[str, Any]) -> int:
    """Names that a case has missed or false."""
    return len(mark["missed"]) + len(mark["false"])


@dataclass
class Bench:
    """Cases in a folder, and where the answers of each package go: what is there is not made again."""

    cases: Path
    results: Path
    workers: int
    console: Console
    output: Path | None = None
    rows: list[dict[str, Any]] = field(default_factory=list)

    def marks(self, name: str, changes: Sequence[Change], some: Sequence[str]) -> Marks:
        """Marks of some cases, diagnosed by a package with changes. Raises RuntimeError where answers are
        those of another package.
        """
        folder = self.results / name
        (folder / "cases").mkdir(parents=True, exist_ok=True)
        for case in some:
            if not (folder / "cases" / case).exists():
                (folder / "cases" / case).symlink_to(self.cases / case)
        told = {"code": self.code, **{str(each): each.scaled(factor) for each, factor in changes}}
        about = folder / "changed_to.json"
        if about.exists() and json.loads(about.read_text()) != told:
            raise RuntimeError(
                f"{folder} has answers of other code, or of other --pairs: give another --results"
            )
        about.write_text(json.dumps(told, indent=1))
        if not all((folder / "policy" / case / "score.json").exists() for case in some):
            self._diagnosed(folder, changes)
        return {case: json.loads((folder / "policy" / case / "score.json").read_text()) for case in some}

    @cached_property
    def code(self) -> str:
        """Hash of the package."""
        every = sorted((ROOT / PACKAGE).rglob("*.py"))
        return hashlib.sha256(b"".join(path.read_bytes() for path in every)).hexdigest()

    def keep(self, **told: Any) -> None:
        """Figures so far."""
        if self.output:
            told = {"schema": "trunk_ros/policy/2", **told, "rows": self.rows}
            self.output.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")

    def _diagnosed(self, folder: Path, changes: Sequence[Change]) -> None:
        package = folder / "package"
        shutil.rmtree(package, ignore_errors=True)  # of a run that was stopped
        changed(changes, package)
        words = [str(folder / "cases"), "--workers", str(self.workers), "--results", str(folder)]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (package, ROOT)))}
        subprocess.run(
            [sys.executable, "-m", "test.concealed.score", *words, "--label", "policy", "--diagnose-only"],
            cwd=package, env=environment, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        shutil.rmtree(package)

    def all_at_once(
        self, every: Sequence[Constant], plain: Marks, pairs: int | None = None
    ) -> tuple[list[Marks], list[Constant]]:
        """Marks of each copy, and the constants that seem to matter, those that do most first. ``pairs``: so
        many of copies.
        """
        names = sorted(plain)
        parts = [names[first : first + FEW] for first in range(0, len(names), FEW)]
        signs = dealt(every, pairs or SEEN * len(parts))
        told, differences = [], []
        for pair, sign in enumerate(signs):
            part = parts[pair % len(parts)]
            both = [self.marks(f"pair_{pair}_{way:+d}", _moved(every, way * sign), part) for way in (1, -1)]
            told += both
            here = [sum(map(wrong, marks.values())) for marks in (*both, {c: plain[c] for c in part})]
            differences.append((here[0] - here[1]) / len(part))
            self.console.print(
                f"pair {pair + 1} of {len(signs)}: {here[0]} and {here[1]} wrong for {here[2]}"
            )
        found, scatter = effects(signs, np.array(differences))
        f1 = {str(each): _in_f1(plain, one) for each, one in zip(every, found, strict=True)}
        self.rows.append({"all_at_once": f1, "std": abs(_in_f1(plain, scatter))})
        order = np.argsort(-np.abs(found))
        return told, [every[k] for k in order if abs(found[k]) > SURE * scatter]

    def alone(self, some: Sequence[Constant], plain: Marks, cases: Sequence[str]) -> None:
        """Each up and down, with what that comes to in F1 over all cases, of which ``cases`` are tried."""
        table = Table("constant", "changed to", "F1", title=f"one at a time, on {len(cases)} cases")
        for each in some:
            for factor in FACTORS:
                marks = self.marks(f"{each}_{factor:.2f}", [(each, factor)], cases)
                f1 = f1_of({**plain, **marks}) - f1_of(plain)
                told = {"changed_to": {str(each): each.scaled(factor)}, "f1": f1}
                self.rows.append(told)
                mark = " *" if abs(f1) > MOST else ""
                table.add_row(f"{each} = {each.value}", each.scaled(factor), f"{f1:+.3f}{mark}")
        self.console.print(table if table.row_count else "no constant seems to matter")


def effects(signs: NDArray[np.int64], differences: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """(constants,) wrong names a case that each constant makes when it is up and not as it is, and their
    standard error; ``signs`` (pairs, constants), ``differences`` (pairs,) of wrong names a case between the
    two copies of a pair: its cases share the signs, so they are one draw.
    """
    found = signs.T @ differences / (2 * len(differences))
    return found, float(np.sqrt(np.mean(differences**2) / len(differences)) / 2)


def _moved(every: Sequence[Constant], signs: NDArray[np.int64]) -> list[Change]:
    return [(each, FACTORS[int(sign > 0)]) for each, sign in zip(every, signs, strict=True)]


def _in_f1(plain: Marks, wrong_a_case: float) -> float:
    """What wrong names a case come to in F1: 2 TP / (2 TP + wrong), where nearly all are right."""
    names = sum(len(one["hits"]) + len(one["missed"]) for one in plain.values())
    return -float(wrong_a_case) * len(plain) / max(2 * names, 1)


def f1_of(marks: Marks) -> float:
    """F1 over cases, clean ones and those of physics without a name among them."""
    return float(pooled_rates(list(marks.values()))["f1"])


def measured(
    bench: Bench, wanted: Sequence[Constant], every: Sequence[Constant], pairs: int | None = None
) -> dict[str, Any]:
    """The figures, of ``wanted`` constants alone where these are not ``every``."""
    cases = sorted(path.name for path in bench.cases.glob("case_*"))
    plain = bench.marks("plain", [], cases)
    bench.console.print(f"F1 {f1_of(plain):.3f} as it is, {len(cases)} cases")
    told: dict[str, Any] = {"f1": f1_of(plain), "cases": len(cases)}
    if len(wanted) < len(every):
        bench.alone(wanted, plain, cases)
        return told
    copies, some = bench.all_at_once(every, plain, pairs)
    runs = [mark for marks in copies for mark in marks.values()]
    f1 = float(pooled_rates(runs)["f1"])
    told |= {"f1_all_at_once": f1, "copies": len(copies), "diagnoses": len(runs)}
    bench.keep(**told)
    took = ([one["seconds"] for one in each if not one.get("failed")] for each in (runs, plain.values()))
    seconds = [float(np.median(each)) for each in took]
    bench.console.print(
        f"F1 {f1:.3f} with all {len(every)} changed, {len(runs)} diagnoses by {len(copies)} copies; "
        f"one constant is known to {bench.rows[0]['std']:.3f}; median {seconds[0]:.1f} s for {seconds[1]:.1f}"
    )
    doubtful = sorted({c for marks in copies for c, one in marks.items() if wrong(one) or wrong(plain[c])})
    bench.alone(some, plain, doubtful)
    return told


def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.bench policy", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="FILE.NAME", help="constants, all by default")
    parser.add_argument("--cases", type=int, default=CASES, help=f"cases to diagnose, default {CASES}")
    parser.add_argument(
        "--pairs", type=int, help="of copies, at least 2, by default as many as see each case twice"
    )
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--list", action="store_true", help="name all constants, and end")
    parser.add_argument("--output", type=Path, help="JSON file for the figures")
    parser.add_argument(
        "--results", type=Path, help="folder for cases and answers; run again, it goes on there"
    )
    asked = parser.parse_args(argv)
    every = constants()
    if asked.list:
        print("\n".join(f"{each} = {each.value}" for each in every))
        return 0
    unknown = set(asked.names) - {str(each) for each in every}
    if unknown:
        parser.error(f"no constant {', '.join(sorted(unknown))}: --list names them")
    if asked.pairs is not None and asked.pairs < 2:
        parser.error("--pairs: one pair tells no constant from another, give 2 at least")
    with tempfile.TemporaryDirectory() as folder:
        there = (asked.results or Path(folder)).absolute()
        for seed in range(SEEDS, SEEDS + asked.cases):
            case = there / "cases" / f"case_{seed:04d}"
            if not (case / "truth.json").exists():  # a run was stopped
                shutil.rmtree(case, ignore_errors=True)
            generate(range(seed, seed + 1), there / "cases", KINDS[seed % len(KINDS)])
        console = Console(width=None if sys.stdout.isatty() else 110)
        bench = Bench(there / "cases", there / "results", asked.workers, console, asked.output)
        wanted = [each for each in every if str(each) in asked.names]
        bench.keep(**measured(bench, wanted or every, every, asked.pairs))
    return 0


if __name__ == "__main__":
    sys.exit(main())
