"""``import``: a table, or a bag with other topics, that others recorded becomes a bag of ours."""

from __future__ import annotations

from pathlib import Path

from trunk_ros.console.arguments import Parser
from trunk_ros.console.console import say
from trunk_ros.share import config_names


def parser() -> Parser:
    """Arguments of ``import``."""
    names = ", ".join(name.removeprefix("import/") for name in config_names("import"))
    made = Parser(
        "import",
        "Turn a table (CSV), or a bag of other topics, into a rosbag2 folder.",
        ["run1.csv --mapping my-map.yaml -o run1", "test0224.csv --mapping tendon-sheath -o test0224"],
    )
    made.add_argument("csv", metavar="CSV|BAG", type=Path, help="a table, or a bag whose topics are others")
    made.add_argument("--mapping", metavar="MAP", required=True, help=f"MAP.yaml, or one of {names}")
    made.add_argument("--output", metavar="BAG", required=True, type=Path, help="the folder to write")
    made.add_argument("--overwrite", action="store_true", help="replace BAG if it exists")
    return made


def main(argv: list[str]) -> int:
    """``import CSV|BAG --mapping MAP.yaml --output BAG``; says what was odd."""
    asked = parser().parse_args(argv)
    from trunk_ros.errors import RecordingError
    from trunk_ros.recording.bag.bag import is_recording
    from trunk_ros.recording.importing.bag import read_bag
    from trunk_ros.recording.importing.csv import read_csv
    from trunk_ros.recording.output import BAG_FILES, prepare_output
    from trunk_ros.recording.topics import TOPICS
    from trunk_ros.recording.write import write_recording

    prepare_output(asked.output, asked.overwrite, BAG_FILES)
    if not asked.csv.exists():
        raise RecordingError(f"{asked.csv}: does not exist")
    read = read_bag if is_recording(asked.csv) else read_csv
    recording = read(asked.csv, asked.mapping)
    write_recording(asked.output, recording, asked.overwrite)
    say(*(f"{asked.csv}: {note}" for note in recording.notes))
    topics = ", ".join(f"/{TOPICS[key]} ({len(each.stamp)})" for key, each in recording.series.items())
    say(f"{asked.output}: {recording.duration:.6g} s, {topics}")
    return 0
