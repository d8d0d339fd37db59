"""``replay --through NODE``: what the node says to the recorded messages, beside what was recorded of it."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.errors import RecordingError, TrunkError
from trunk_ros.model import Model, load_model
from trunk_ros.nodes.bags.source import BagSource
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.messages import nanoseconds
from trunk_ros.nodes.graph.ros import Parameter, deserialize_message
from trunk_ros.nodes.wire_elasticity import WireElasticity
from trunk_ros.recording.compare import Difference, differences, table
from trunk_ros.recording.namespace import choose
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, PoseSeries, Recording
from trunk_ros.recording.topics import JOINT_TOPICS, TIP_TOPIC, TOPICS

SAME = 1e-9  # in the unit of a quantity: what rounding may do
KEYS = {name: key for key, name in TOPICS.items()}


class OfflineWire(WireElasticity):
    """The node without streams: it is told what was recorded, and what it would publish is kept."""

    def __init__(self, **options: Any):
        super().__init__(**options)
        self.said: dict[str, list[Any]] = {}
        self.inputs: dict[str, tuple[Any, Any]] = {}
        self.at = 0
        self.left_out = 0
        self.configure()

    def publish_on(self, kind: Any, topic: str, qos: Any = None) -> Any:
        """Keep in the place of publishing: a copy, as publishing makes one."""
        kept = self.said.setdefault(topic, [])
        return lambda message: kept.append(deepcopy(message))

    def listen_to(self, kind: Any, topic: str, callback: Any, raw: bool = False) -> None:
        """Note what is to be told."""
        self.inputs[topic] = kind, callback

    def now(self) -> int:
        """Time of recording of the message under way."""
        return self.at

    def tell(self, topic: str, at: int, data: bytes) -> None:
        """Hand over a message [CDR] that was recorded at ``at`` ns; one that the node refuses is counted."""
        kind, callback = self.inputs[topic]
        self.at = at
        try:
            callback(deserialize_message(data, kind))
        except TrunkError:
            self.left_out += 1


NODES = {WireElasticity.NAME: OfflineWire}


def through(bag: str, name: str, model: str | None, tolerance: float | None) -> int:
    """Recompute, compare and print; 0, or 1 where a tolerance is given and exceeded. Raises TrunkError."""
    recorded = read_recording(bag)
    asked, of = believed(recorded, name, model)
    given = [Parameter(key, value=value) for key, value in asked.parameters().items()]
    node = NODES[name](parameter_overrides=given)
    try:
        told = feed(node, bag)
        computed = as_recording(bag, node.said)
    finally:
        node.destroy_node()
    found = differences(recorded, computed)
    if not found:
        raise RecordingError(f"{bag}: holds nothing that {name} publishes: there is nothing to compare")
    print(f"{bag}: {told} messages through {name} with {of}")
    if node.left_out:
        print(f"{node.left_out} of them were refused, as the live node does")
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


def feed(node: OfflineWire, bag: str) -> int:
    """Tell the node what was recorded; returns how many messages."""
    count = 0
    with BagSource(bag) as source:
        chosen, _ = choose(bag, {topic.name: topic.kind for topic in source.topics})
        given = {chosen[KEYS[topic]]: topic for topic in node.inputs if KEYS[topic] in chosen}
        if missing := set(node.inputs) - set(given.values()):
            raise RecordingError(f"{bag}: no topic {', '.join(sorted(missing))}: {node.NAME} needs it")
        for at, topic, data in source.messages(set(given)):
            node.tell(given[topic], at, data)
            count += 1
    return count


def as_recording(bag: str, said: dict[str, list[Any]]) -> Recording:
    """What a node has said, by topic, as a recording."""
    stamped = [said[topic] for topic in TOPICS.values() if topic in said]
    stamps = [nanoseconds(each.header.stamp) for kept in stamped for each in kept]
    start_ns = min(stamps, default=0)
    series = {
        key: joint_series(said[topic], start_ns) for key, topic in JOINT_TOPICS.items() if said.get(topic)
    }
    tip = pose_series(said[TIP_TOPIC], start_ns) if said.get(TIP_TOPIC) else None
    return Recording(str(Path(bag)), start_ns, (max(stamps, default=0) - start_ns) / SECOND, series, tip)


def seconds(messages: list[Any], start_ns: int) -> Any:
    """Stamps (n,) s since the start."""
    return np.array([nanoseconds(each.header.stamp) - start_ns for each in messages]) / SECOND


def joint_series(messages: list[Any], start_ns: int) -> JointSeries:
    """JointState messages of the same joints."""
    position, velocity, effort = (
        np.array([getattr(each, name) for each in messages], dtype=float)
        for name in ("position", "velocity", "effort")
    )
    given = [values if values.size else None for values in (velocity, effort)]
    return JointSeries(seconds(messages, start_ns), tuple(messages[0].name), position, *given)


def pose_series(messages: list[Any], start_ns: int) -> PoseSeries:
    """PoseStamped messages."""
    places = [(p.x, p.y, p.z) for p in (each.pose.position for each in messages)]
    turns = [(q.x, q.y, q.z, q.w) for q in (each.pose.orientation for each in messages)]
    frame = messages[0].header.frame_id
    return PoseSeries(seconds(messages, start_ns), np.array(places), np.array(turns), frame)


def beyond(found: list[Difference], tolerance: float) -> list[str]:
    """Quantities that differ by more, in words."""
    return [
        f"{each.topic} {each.quantity}" for each in found if not each.compared or each.largest > tolerance
    ]
