"""``replay --through NODE``: what the node says to the recorded messages, beside what was recorded of it."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.errors import RecordingError, TrunkError
from trunk_ros.model import Model, load_model
from trunk_ros.nodes.arm.wire import Shown, Wire
from trunk_ros.nodes.bags.source import BagSource
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.messages import nanoseconds
from trunk_ros.nodes.graph.reader import unpacked
from trunk_ros.nodes.graph.ros import JointState
from trunk_ros.recording.compare import Difference, differences, table
from trunk_ros.recording.namespace import choose
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, PoseSeries, Recording
from trunk_ros.recording.topics import TOPICS

SAME = 1e-9  # in the unit of a quantity: what rounding may do


INPUT = "gearbox_states"


def through(
    bag: str, name: str, model: str | None, tolerance: float | None, namespace: str | None = None
) -> int:
    """Recompute, compare and print; 0, or 1 where a tolerance is given and exceeded. Raises TrunkError."""
    recorded = read_recording(bag, namespace=namespace)
    asked, of = believed(recorded, name, model)
    said = answers(Wire(asked), bag, name, namespace)
    found = differences(recorded, as_recording(bag, asked, said.shown))
    if not found:
        raise RecordingError(f"{bag}: holds nothing that {name} publishes: there is nothing to compare")
    print(f"{bag}: {said.told} messages through {name} with {of}")
    if said.refused:
        print(f"{said.refused} of them were refused, as the live node does")
    print("\n".join(table(found)))
    limit = SAME if tolerance is None else tolerance
    worst = beyond(found, limit)
    print(f"differs by more than {limit:g}: {', '.join(worst)}" if worst else f"the same, within {limit:g}")
    return 1 if worst and tolerance is not None else 0


def believed(recorded: Recording, name: str, model: str | None) -> tuple[Model, str]:
    """Model of the node, and where it is from: --model, the bag's manifest, or the nominal arm."""
    if model is None:
        try:
            flat = json.loads(recorded.custom["trunk_ros.manifest"])["parameters"][name]
            return Model.from_parameters(dict(flat)), "the parameters that it had"
        except (KeyError, TypeError, ValueError):
            pass
    asked = load_model(model or "trunk")
    if asked.any_joints:
        asked = asked.for_joints(recorded.require("gearbox_states").joints)
    return asked, f"the model {model}" if model else "the model trunk, since the bag does not say which"


@dataclass
class Answers:
    """What the node shows at each stamp [ns], of how many messages, and how many it refuses."""

    shown: list[tuple[int, Shown]] = field(default_factory=list)
    told: int = 0
    refused: int = 0


def answers(wire: Wire, bag: str, name: str, namespace: str | None) -> Answers:
    """Tell the node's model what was recorded. Raises RecordingError where there is nothing for it."""
    found = Answers()
    with BagSource(bag) as source:
        chosen, _ = choose(bag, {topic.name: topic.kind for topic in source.topics}, namespace)
        if INPUT not in chosen:
            raise RecordingError(f"{bag}: no topic {TOPICS[INPUT]}: {name} needs it")
        for _, _, data in source.messages({chosen[INPUT]}):
            found.told += 1
            try:
                found.shown.append(answer(wire, unpacked(data, JointState)))
            except TrunkError:
                found.refused += 1
    return found


def answer(wire: Wire, message: Any) -> tuple[int, Shown]:
    """Stamp [ns] and what the node shows then. Raises TrunkError where it refuses the message."""
    stamp = nanoseconds(message.header.stamp)
    phi = wire.complete(message.name, message.position)
    wire.begins_anew(stamp)
    return stamp, wire.update(stamp, phi)


def as_recording(bag: str, model: Model, shown: list[tuple[int, Shown]]) -> Recording:
    """What the node shows, as a recording of its topics."""
    stamps = np.array([stamp for stamp, _ in shown], dtype=np.int64)
    start_ns = int(stamps.min()) if len(stamps) else 0
    time, joints = (stamps - start_ns) / SECOND, model.arm.joints
    columns = [
        np.array([getattr(each, name) for _, each in shown]) for name in ("joints", "velocity", "effort")
    ]
    series = {"joint_states": JointSeries(time, joints, *columns)} if shown else {}
    wires = [each.wires for _, each in shown if each.wires is not None]
    if wires:
        stretch, tension = (np.array([pair[part] for pair in wires]) for part in (0, 1))
        names = tuple(f"wire_{number}" for number in range(1, len(joints) + 1))
        series["wire_states"] = JointSeries(time, names, stretch, None, tension)
    tips = [each.tip for _, each in shown if each.tip is not None]
    tip = pose_series(time, np.array(tips)) if tips else None
    return Recording(str(Path(bag)), start_ns, float(np.ptp(time)) if shown else 0.0, series, tip)


def pose_series(time: Any, tip: Any) -> PoseSeries:
    """Tips (n, 7), x, y, z m and quaternion x, y, z, w, as the node publishes them."""
    return PoseSeries(time, tip[:, :3], tip[:, 3:], "")


def beyond(found: list[Difference], tolerance: float) -> list[str]:
    """Quantities that differ by more, in words."""
    return [
        f"{each.topic} {each.quantity}" for each in found if not each.compared or each.largest > tolerance
    ]
