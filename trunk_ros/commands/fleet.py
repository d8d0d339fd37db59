"""``fleet``: the command."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from trunk_ros.console.arguments import Parser, count
from trunk_ros.errors import ArgumentError, RecordingError

OURS = ("fleet.json", "fleet.html", "servos.json", "*.parquet", "parts", "arms", ".*")


def main(argv: list[str]) -> int:
    """Parse, diagnose what is not done yet, look at all of it together, write, say."""
    arguments = parser().parse_args(argv)
    from trunk_ros.fleet.run.cluster import connected, needs_extra

    needs_extra()
    from trunk_ros.fleet.inputs.listing import listed
    from trunk_ros.fleet.whole import Work
    from trunk_ros.model import load_model

    limits = dict(_limit(text) for text in arguments.limit)
    model = load_model(arguments.model)
    folder = _folder(Path(arguments.output))
    jobs = listed(arguments.bag)
    with connected(arguments.scheduler, arguments.workers) as client:
        fleet = Work(folder, jobs, model, client, arguments.retry_failed).run(limits)
    _say(fleet.to_json(), len(jobs), folder)
    if not any(fleet.arms.values()):
        raise RecordingError(
            f"none of {len(jobs)} recordings could be diagnosed: {folder}/fleet.json says why"
        )
    return 0


def _folder(path: Path) -> Path:
    """The output, new or of an earlier run; never a folder of other things."""
    if path.is_file():
        raise ArgumentError(f"{path} is a file: give a folder")
    foreign = (
        [p.name for p in path.iterdir() if not any(p.match(one) for one in OURS)] if path.exists() else []
    )
    if foreign:
        raise ArgumentError(f"{path} holds other things too ({sorted(foreign)[0]}): give another output")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArgumentError(f"{path} cannot be written: {error.strerror}") from None
    return path


def _limit(text: str) -> tuple[tuple[str, str], float]:
    """``backlash.half_width=0.002`` as effect, parameter and value. Raises ArgumentError."""
    from trunk_ros.effects import effect

    name, _, number = text.partition("=")
    kind, _, parameter = name.partition(".")
    try:
        effect(kind).parameter(parameter)
        return (kind, parameter), float(number)
    except ValueError:
        raise ArgumentError(
            f"--limit {text}: give EFFECT.PARAMETER=VALUE, such as backlash.half_width=0.002"
        ) from None


def _say(told: dict[str, Any], jobs: int, folder: Path) -> None:
    """The fleet in a few lines."""
    arms = told["arms"]
    from trunk_ros.fleet.report.page import number
    from trunk_ros.fleet.together.judged import LEAST

    print(
        f"{number(jobs, 'recording')} of {number(len(arms), 'arm')}, "
        f"{len(told['unread'])} of them could not be diagnosed"
    )
    if short := sum(not said["judged"] for said in arms.values()):
        print(f"  {number(short, 'arm')} with fewer than {LEAST} recordings: what grows there is not judged")
    for each in told["common"]:
        print(f"  all arms: {each['effect']} on {each['joint']}, {each['parameter']} {each['value']:.4g}")
    for arm, said in arms.items():
        for each in said["trends"]:
            if each["per"] == "day":
                low, high = each["interval"]
                print(
                    f"  {arm}: {each['effect']} on {each['joint']} grows by {each['slope']:.3g} "
                    f"({low:.3g} to {high:.3g}) {each['unit']} a day{_reached(each)}"
                )
        for each in said["changes"]:
            print(
                f"  {arm}: {each['effect']} on {each['joint']} changed on {each['date']} "
                f"by {each['step']:.3g} {each['unit']}"
            )
        for each in said["own"]:
            print(
                f"  {arm}: {each['effect']} on {each['joint']} stands out, {each['parameter']} "
                f"{each['value']:.4g} where the others have {each['others']:.4g} {each['unit']}"
            )
    for each in told["unread"]:
        print(f"  not read: {each['path']}: {each['reason'].removeprefix(each['path'] + ': ')}")
    print(f"{folder}: fleet.html, fleet.json, findings.parquet, errors.parquet, values.parquet")


def _reached(trend: dict[str, Any]) -> str:
    """When a trend reaches its limit, "" where none was given."""
    if "crosses" not in trend:
        return ""
    from trunk_ros.fleet.together.summary import date

    when, first, last = (
        (date(trend["crosses"][name]) or "never")[:10] for name in ("time", "earliest", "latest")
    )
    said = "never reaches" if when == "never" else "reaches"
    then = "" if when == "never" else f" on {when} ({first} to {last})"
    return f"; it {said} {trend['limit']:.3g} {trend['unit']}{then}"


def parser() -> Parser:
    """The command's arguments."""
    out = Parser(
        "fleet",
        "Diagnose many recordings of many arms, and say what changes, since when, on which arm. "
        "Goes on where it was stopped.",
        ["recordings/ -m my-arm.yaml -o fleet", "list.csv -o fleet --limit backlash.half_width=0.002"],
    )
    out.add_argument(
        "bag", nargs="+", metavar="BAG|FOLDER|GLOB|LIST.csv",
        help="bags, folders of bags, globs, or a list (CSV or Parquet) with arm,time,path; also URLs "
        "(s3://, gs://, https://) where their fsspec package is installed",
    )  # fmt: skip
    out.add_argument("--output", required=True, metavar="DIR", help="folder for page, JSON and Parquet")
    out.add_argument("--model", default="trunk", metavar="MODEL.yaml", help="the nominal arm of the type")
    out.add_argument(
        "--scheduler", metavar="tcp://…", help="a Dask scheduler; by default one is started here"
    )
    out.add_argument(
        "--workers", type=count, metavar="N", help="processes started here; by default one per core"
    )
    out.add_argument("--retry-failed", action="store_true", help="try once more what could not be diagnosed")
    out.add_argument(
        "--limit", action="append", default=[], metavar="EFFECT.PARAMETER=VALUE",
        help="a limit (SI units): the report says when a trend crosses it; may be given several times",
    )  # fmt: skip
    return out
