"""``info``: what a recording holds, what can be diagnosed from it, and what is missing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trunk_ros.console.arguments import Parser, add_namespace
from trunk_ros.console.console import columns, say
from trunk_ros.recording.namespace import foreign_states
from trunk_ros.recording.topics import JOINT_STATE

if TYPE_CHECKING:
    from trunk_ros.diagnosis.prospects import Prospect
    from trunk_ros.model import Model
    from trunk_ros.recording.recording import Recording

TABLES = (".csv", ".tsv", ".txt", ".dat", ".asc")


def parser() -> Parser:
    """Arguments of ``info``."""
    made = Parser(
        "info",
        "Say what a recording holds, what can be diagnosed from it, and what is missing.",
        ["run1", "run1 -m my-arm.yaml", "run1 --json", "run1.csv"],
    )
    made.add_argument("bag", metavar="BAG", type=Path, help="bag folder, .mcap, .db3, .bag, or a table (CSV)")
    made.add_argument(
        "--model",
        metavar="MODEL.yaml",
        help="a file, or trunk or direct; by default the one that fits",
    )
    add_namespace(made)
    made.add_argument("--json", action="store_true", help="the same for programs")
    return made


def main(argv: list[str]) -> int:
    """The command."""
    asked = parser().parse_args(argv)
    if asked.bag.suffix.lower() in TABLES:
        say(*([json.dumps(surveyed(asked.bag), indent=1)] if asked.json else table(asked.bag)))
        return 0
    from trunk_ros.errors import ForeignError
    from trunk_ros.recording.read import read_recording

    try:
        recording = read_recording(asked.bag, namespace=asked.namespace)
    except ForeignError:
        topics = foreign_topics(asked.bag)
        if not topics:
            raise
        told = {"recording": str(asked.bag), "foreign_topics": topics}
        say(*([json.dumps(told, indent=1)] if asked.json else foreign(asked.bag, topics)))
        return 0
    found = gathered(*model_for(recording, asked.model))
    renamed = {} if STATES & set(recording.series) else foreign_topics(asked.bag)
    begun = mapping(asked.bag, renamed) if foreign_states(renamed) else []
    told = {**found, "foreign_topics": renamed} if begun else found
    say(*([json.dumps(told, indent=1)] if asked.json else [*spoken(found), *begun]))
    return 0


STATES = {"gearbox_states", "joint_states"}
"""What says where an arm was: a bag without either may have both under other names."""


NUMBERS = {"sensor_msgs/msg/JointState": "position[0]", "std_msgs/msg/Float64": "data"}
"""Where messages that come from arms most have an angle."""


ASKED = ("setpoint", "command", "desired", "goal", "demand", "target")
"""Words in the names of topics that say where a servo is to go."""


MOTORS = ("motor", "gearbox", "actuator", "drive", "shaft")
"""Words in the names of topics of the motor side."""


def foreign(path: Path, topics: dict[str, str]) -> list[str]:
    """The topics of a bag that say by no name where an arm was, and the mapping to begin with."""
    head = f"{path}: no topic of an arm says where it was. It holds:"
    return [head, *columns(sorted(topics.items())), *mapping(path, topics)]


def mapping(path: Path, topics: dict[str, str]) -> list[str]:
    """The mapping to begin with for the topics of a bag."""
    named = set(foreign_states(topics)) | {topic for topic, kind in topics.items() if kind != JOINT_STATE}
    angles = [
        f"{topic}.{field}"
        for known, field in NUMBERS.items()
        for topic in sorted(topics)
        if topics[topic] == known and topic in named
    ]
    asked = [angle for angle in angles if any(word in angle.lower() for word in ASKED)]
    shown = [angle for angle in angles if angle not in asked]
    shown.sort(key=lambda angle: not any(word in angle.lower() for word in MOTORS))
    keys = ["gearbox_states", "joint_states"]
    if asked:
        keys = ["setpoints", *keys[: max(len(shown), 1)]]
    told = dict(zip(keys, [*asked[:1], *shown, "/TOPIC.FIELD", "/TOPIC.FIELD"], strict=False))
    return [
        "",
        "A mapping says which of their fields are which; put the right ones in and save it as MAP.yaml:",
        "  joints: [joint_1]",
        *(f'  {key}: {{position: {{columns: ["{angle}"], unit: rad}}}}' for key, angle in told.items()),
        f"then: trunk_ros import {path} --mapping MAP.yaml -o {path.with_name(path.stem + '_arm')}",
    ]


def foreign_topics(path: Path) -> dict[str, str]:
    """All topics of a bag with their types; empty where it cannot be read."""
    from trunk_ros.recording.allowance import Allowance
    from trunk_ros.recording.bag.bag import read_blocks
    from trunk_ros.recording.messages.block import Contents, DamageError

    contents = Contents(Allowance(path))
    try:
        for _ in read_blocks(path, lambda topic: False, contents, lambda _: None):
            pass
    except (DamageError, OSError):
        return {}
    return contents.topics


def model_for(recording: Recording, name: str | None) -> tuple[Recording, Model]:
    """The model asked for; else the nominal arm where the joints are its, or ``direct``, with the links of a
    recorded URDF as ``diagnose`` takes them, and the recording with its units.
    """
    from trunk_ros.diagnosis.nominal_model import described
    from trunk_ros.model import load_model
    from trunk_ros.transmission import by_joint

    trunk = load_model(name or "trunk")
    known = name or set(trunk.arm.joints) & set(recording.joints)
    model, (recording,) = described(trunk if known else load_model("direct"), [recording], "")
    return by_joint(recording, model.arm), model


def gathered(recording: Recording, model: Model) -> dict[str, Any]:
    """All that is said, as JSON has it."""
    from dataclasses import asdict

    from trunk_ros.data.mix_ups import doubtful, mix_ups
    from trunk_ros.data.names import misnamed
    from trunk_ros.data.quality import left_out
    from trunk_ros.diagnosis.prospects import motion_of, prospects
    from trunk_ros.recording.quality import quality
    from trunk_ros.recording.topics import TOPICS

    topics = {
        TOPICS[key]: {"rate_hz": q.rate, "samples": q.samples, "lost": q.lost, "longest_gap": q.longest_gap}
        for key, q in quality(recording).items()
    }
    mixed = mix_ups(recording, model)
    names = misnamed(recording, model)
    return {
        "recording": recording.name,
        "duration": recording.duration,
        "topics": topics,
        "joints": {j: {**m, "unit": recording.unit(j)} for j, m in motion_of(recording).items()},
        "stages": {one.stage: _as_json(one, asdict(one)) for one in prospects(recording, model)},
        "absent": [topic for key, topic in TOPICS.items() if topic not in topics and key != "reference"],
        "mixed_up": [*([names] if names else []), *(one.statement for one in mixed)],
        "note": [*recording.notes, *left_out(recording, model), *doubtful(recording, model, mixed)],
    }


def _as_json(one: Prospect, content: dict[str, Any]) -> dict[str, Any]:
    noise = {joint: value if value == value else None for joint, value in one.joints.items()}
    return {"possible": not one.missing, **content, "joints": noise}


def spoken(found: dict[str, Any]) -> list[str]:
    """The same in lines."""
    lines = [f"{found['recording']}: {found['duration']:.4g} s", ""]
    rows: list[tuple[str, ...]] = [("topic", "rate", "samples", "missing", "longest gap")]
    for topic, q in found["topics"].items():
        lost = "uneven" if q["lost"] is None else str(q["lost"])
        rows.append((topic, f"{q['rate_hz']:.4g} Hz", str(q["samples"]), lost, f"{q['longest_gap']:.3g} s"))
    lines += [*columns(rows), ""]
    rows = [("joint", "range", "top speed", "reversals")]
    for joint, m in found["joints"].items():
        span = f"{m['low']:+.3f} … {m['high']:+.3f} {m['unit']}"
        rows.append((joint, span, f"{m['speed']:.2g} {m['unit']}/s", str(m["turns"])))
    lines += [*columns(rows), "", "what can be diagnosed"]
    units = {joint: m["unit"] for joint, m in found["joints"].items()}
    for stage, told in found["stages"].items():
        lines += _stage(stage, told, units)
    odd = [f"{name}: {one}" for name in ("mixed up", "note") for one in found[name.replace(" ", "_")]]
    return [*lines, "", *odd] if odd else lines


def _stage(stage: str, told: dict[str, Any], units: dict[str, str]) -> list[str]:
    from trunk_ros.units import sized

    if not told["possible"]:
        return [f"  {stage:6}no: {told['missing']}"]
    noise: dict[str, list[float]] = {}
    for joint, value in told["joints"].items():
        if value:
            noise.setdefault(units.get(joint, "rad"), []).append(value)
    ends = [[sized(end(some), unit, 2) for end in (min, max)] for unit, some in noise.items()]
    sensed = [" … ".join(dict.fromkeys(pair)) for pair in ends]
    said = f"; noise {', '.join(sensed)}" if sensed else ""
    lines = [f"  {stage:6}yes: {', '.join(told['joints'])}{said}"]
    if told["silent"]:
        lines.append(f"        hardly moves: {', '.join(told['silent'])}")
    lines.append(f"        tried: {', '.join(told['effects'])}")
    return lines + [f"        not {', '.join(names)}: {reason}" for reason, names in told["unseen"].items()]


def surveyed(path: Path) -> dict[str, Any]:
    """The columns of a table, as JSON has them."""
    from trunk_ros.recording.importing.survey import survey

    found = survey(path)
    return {
        "table": str(path),
        "rows": found.count,
        "columns": dict(zip(found.names, found.first, strict=True)),
        "delimiter": found.delimiter,
        "decimal": found.decimal,
        "time": {"column": found.time, "unit": found.unit} if found.time else None,
    }


def table(path: Path) -> list[str]:
    """The columns of a table with what they hold, and the mapping to begin with."""
    from trunk_ros.recording.importing.survey import survey
    from trunk_ros.recording.plain_yaml import plain

    found = survey(path)
    time = f"time: {{column: {plain(found.time)}, unit: {found.unit}}}"
    rate = "rate_hz: RATE  # rows per s: no column increases throughout, as a time does"
    return [
        f"{path}: a table of {found.count} rows",
        *columns([("column", "first value"), *zip(map(plain, found.names), found.first, strict=True)]),
        "",
        "A mapping says which columns are which; put the right ones in and save it as MAP.yaml:",
        f"  {time if found.time else rate}",
        "  joints: [joint_1]",
        "  gearbox_states: {position: {columns: [MOTOR_SIDE_ANGLE], unit: rad}}",
        "  joint_states: {position: {columns: [JOINT_ANGLE], unit: rad}}",
        *([f"  delimiter: {json.dumps(found.delimiter)}"] if found.delimiter != "," else []),
        *([f'  decimal: "{found.decimal}"'] if found.decimal != "." else []),
        f"then: trunk_ros import {path} --mapping MAP.yaml -o {path.with_suffix('')}",
    ]
