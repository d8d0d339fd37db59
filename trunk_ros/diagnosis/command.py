"""``diagnose``: the command."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from rich.console import Console

from trunk_ros import __version__
from trunk_ros.diagnosis.diagnose import diagnose
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.model import load_model
from trunk_ros.recording.arguments import Parser, add_settle
from trunk_ros.recording.output import new_folder, prepare_output

FILES = ("diagnosis.json", "model.yaml", "report.html", "*.yaml", "*.png")


def main(argv: list[str]) -> int:
    """Parse, diagnose, write, say."""
    arguments = parser().parse_args(argv)
    prepare_output(arguments.output, arguments.overwrite, FILES)
    model = load_model(arguments.model)
    console = Console(stderr=True)
    with console.status("reading") as status:
        result = diagnose(
            arguments.bag,
            model,
            arguments.against,
            arguments.from_time,
            arguments.until,
            lambda text: status.update(text),
            arguments.settle,
        )
    result.provenance = {
        "command": shlex.join(["trunk_ros", "diagnose", *argv]),
        "trunk_ros": __version__,
        "python": sys.version.split()[0],
        "model": str(arguments.model),
        "model_hash": model.hash(),
        "bags": [str(bag) for bag in arguments.bag],
    }
    with new_folder(arguments.output, arguments.overwrite, FILES) as folder:
        result.save(folder)
        write_report(result, folder)
    say(result, Path(arguments.output))
    return 0


def write_report(result: Diagnosis, folder: Path) -> None:
    """The page, where the report's libraries are there."""
    from trunk_ros.diagnosis.report import write

    write(result, folder / "report.html")


def say(result: Diagnosis, output: Path) -> None:
    """The verdict in a few lines."""
    print(f"verdict: {result.verdict.replace('_', ' ')}")
    for finding in result.findings:
        print(f"  {finding.effect} ({finding.confidence:.0%}): {finding.statement}")
        if finding.equivalents:
            print(f"    these data cannot tell it from {', '.join(finding.equivalents)}")
    for stage, compared in result.stages.items():
        if compared.get("silent"):
            print(f"  {stage}: nothing can be said of {', '.join(compared['silent'])}, which hardly moves")
    for name, told in result.quality.items():
        for note in told["notes"]:
            print(f"  {name}: {note}")
    for rest in result.unexplained:
        print(f"  unexplained: {rest.statement}")
    for proposed in result.experiments:
        print(f"  experiment: {proposed['statement']}")
    print(f"{output}: {', '.join(['diagnosis.json', 'model.yaml', 'report.html', *result.trajectories])}")


def parser() -> Parser:
    """The command's arguments."""
    out = Parser(
        "diagnose",
        description="Find what a simulation leaves out of a recording, model it, and show the fit.",
    )
    out.add_argument(
        "bag", nargs="+", metavar="BAG", help="recordings of one arm: bag folders, .mcap, .db3, .bag"
    )
    out.add_argument("--output", required=True, metavar="DIR")
    out.add_argument(
        "--model", default="trunk", metavar="MODEL.yaml", help="the nominal arm: a file, or trunk or direct"
    )
    out.add_argument("--against", metavar="SIM_BAG", help="another simulator's recording of the same motion")
    out.add_argument("--from-time", metavar="T", help="in s, or in %% of the recording")
    out.add_argument("--until", metavar="T", help="in s, or in %% of the recording")
    add_settle(out)
    out.add_argument("--overwrite", action="store_true")
    return out
