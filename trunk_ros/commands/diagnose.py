"""``diagnose``: find what a simulation leaves out of recordings, model it, and show the fit."""

from __future__ import annotations

import shlex
import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trunk_ros import __version__
from trunk_ros.console.arguments import SETTLE, Parser, add_namespace, add_settle, count
from trunk_ros.console.console import say, warn
from trunk_ros.console.progress import progress
from trunk_ros.errors import ArgumentError

if TYPE_CHECKING:
    from trunk_ros.diagnosis.verdict.finding import Finding
    from trunk_ros.diagnosis.verdict.result import Diagnosis

FILES = ("diagnosis.json", "model.yaml", "report.html", "simulation.yaml", "*.yaml", "*.png")
TABLES = (".csv", ".tsv", ".txt", ".xlsx", ".npy", ".npz")
# Shares of the time that had passed at the beginning of each stage, median over the bench's recordings.
SHARES = {"reading": 0.0, "wire": 0.05, "wire: evidence": 0.5, "wire: experiment": 0.7, "servo": 0.85,
          "arm": 0.9, "report": 0.93}  # fmt: skip


def parser() -> Parser:
    """Arguments of ``diagnose``."""
    out = Parser(
        "diagnose",
        "Name the physical effects that a simulation is missing, from recordings of one arm.",
        ["run1 -o verdict", "run1 run2 -m my-arm.yaml -o verdict", "run1 -m direct --until 70% -o verdict"],
    )
    out.add_argument(
        "bag", nargs="+", metavar="BAG", help="recordings of one arm: bag folders, .mcap, .db3, .bag"
    )
    out.add_argument(
        "--output", required=True, metavar="DIR", help="folder for diagnosis.json, model.yaml and report.html"
    )
    out.add_argument(
        "--model",
        metavar="MODEL.yaml",
        help="the nominal arm: a file, or trunk (default) or direct; with --against what is known of both",
    )
    out.add_argument(
        "--urdf", metavar="FILE", help="the arm's URDF: load and tip of any arm; direct is the default then"
    )
    out.add_argument("--against", metavar="SIM_BAG", help="another simulator's recording of the same motion")
    out.add_argument("--from-time", metavar="T", help="begin there: in s, or in %% of the recording")
    out.add_argument("--until", metavar="T", help="end there: in s, or in %% of the recording")
    add_namespace(out)
    add_settle(out)
    out.add_argument(
        "--cores", type=count, default=1, metavar="N", help="cores to use (1); the answer is the same"
    )
    out.add_argument("--overwrite", action="store_true", help="replace DIR if it holds an earlier diagnosis")
    return out


def main(argv: list[str]) -> int:
    """Parse, diagnose, write, say."""
    try:
        asked = parser().parse_args(argv)
    except ArgumentError:
        refuse_tables([word for word in argv if Path(word).is_file()])
        raise
    refuse_tables([*asked.bag, *([asked.against] if asked.against else [])])
    from trunk_ros.arm.files import urdf_text
    from trunk_ros.diagnosis.diagnose import diagnose
    from trunk_ros.diagnosis.resources.cores import on_cores
    from trunk_ros.model import load_model
    from trunk_ros.recording.output import new_folder, prepare_output

    prepare_output(asked.output, asked.overwrite, FILES)
    model = None if asked.model is None else load_model(asked.model)
    urdf = urdf_text(asked.urdf) if asked.urdf else ""
    with progress(SHARES) as step, on_cores(asked.cores):
        step("reading")
        result = diagnose(
            asked.bag,
            model,
            asked.against,
            asked.from_time,
            asked.until,
            step,
            asked.namespace,
            urdf,
            asked.settle,
            doubts=warn,
        )
        result.provenance = {
            "command": shlex.join(["trunk_ros", "diagnose", *argv]),
            "trunk_ros": __version__,
            "python": sys.version.split()[0],
            "model": str(asked.model or asked.urdf or _default(result)),
            **result.provenance,
            "bags": [str(bag) for bag in asked.bag],
            **{key: at for key in ("from_time", "until") if (at := getattr(asked, key))},
            "arguments": given(asked),
        }
        step("report")
        with new_folder(asked.output, asked.overwrite, FILES) as folder:
            result.save(folder)
            write_report(result, folder)
    say(*spoken(result), f"{asked.output}: {', '.join([*FILES[:3], *result.files])}")
    return 0


def given(asked: Namespace) -> dict[str, Any]:
    """The arguments that are not as usual, for commands that go on with them."""
    keys = ("model", "urdf", "against", "from_time", "until", "namespace", "output")
    told = {key: value for key in keys if (value := getattr(asked, key)) is not None}
    return told | ({"settle": asked.settle} if asked.settle != SETTLE else {})


def _default(result: Diagnosis) -> str:
    """What stood for a model that was not given."""
    from trunk_ros.diagnosis.simulators.against import nominal_for

    if result.model.arm.description is not None:
        return "robot_description"
    return "direct" if nominal_for(result.model.arm.joints).any_joints else "trunk"


def refuse_tables(paths: Sequence[str]) -> None:
    """Raise ArgumentError for a table, saying how it becomes a bag."""
    for path in map(Path, paths):
        if path.suffix.lower() in TABLES:
            bag = path.with_suffix("")
            raise ArgumentError(
                f"{path} is a table, not a bag: `trunk_ros import {path} --mapping MAP.yaml -o {bag}` "
                f"makes one (docs/own-arm.md shows a MAP.yaml)"
            )


def write_report(result: Diagnosis, folder: Path) -> None:
    """The page."""
    from trunk_ros.diagnosis.report import write
    from trunk_ros.heap import give_back

    give_back()
    write(result, folder / "report.html")


def spoken(result: Diagnosis) -> list[str]:
    """The verdict in a few lines, what is wrong with the data first."""
    lines = []
    if result.simulator is not None:
        has = "; ".join(one.rstrip(".") for one in result.simulation["has"])
        lines.append(f"your simulation has: {has or 'what the model says, no more'}")
    lines.append(f"verdict: {result.verdict.replace('_', ' ')}")
    lines += [f"  {named(finding)}: {finding.statement}" for finding in result.findings]
    for stage, compared in result.stages.items():
        if compared.get("silent"):
            silent = ", ".join(compared["silent"])
            lines.append(f"  {stage}: no verdict on {silent}: hardly moves")
    for name, told in result.quality.items():
        lines += [f"  {name}: {note}" for note in told["notes"]]
    lines += [f"  unexplained: {rest.statement}" for rest in result.unexplained]
    return [*lines, *_motions(result.experiments)]


def _motions(experiments: Sequence[dict[str, Any]]) -> list[str]:
    """What to play; and, in one line, of what no motion decides."""
    lines = [f"  experiment: {one['statement']}" for one in experiments if one["trajectory"]]
    pairs = [" and ".join(map(_words, one["separates"])) for one in experiments if not one["trajectory"]]
    if pairs:
        lines.append(f"  no motion that was tried decides between {', or '.join(pairs)}")
    return lines


def _words(effects: str | list[str]) -> str:
    return effects if isinstance(effects, str) else " + ".join(effects)


def named(finding: Finding) -> str:
    """An effect with what it cannot be told from, and how sure that is."""
    sure = f"{finding.confidence:.0%}"
    if len(finding.candidates) == 1:
        return f"{finding.effect} ({sure})"
    return f"{' or '.join(finding.candidates)} ({sure} that it is one of these, the data do not tell which)"
