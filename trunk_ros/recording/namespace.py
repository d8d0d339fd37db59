"""Which topics of a recording are those of the arm, where names carry a namespace, or of several arms."""

from trunk_ros.errors import ForeignError, RecordingError
from trunk_ros.recording.topics import JOINT_STATE, OURS, SHOWN, SOURCES, TOPICS, expected_type, split_topic


def choose(
    name: str, topics: dict[str, str], namespace: str | None = None
) -> tuple[dict[str, str], list[str]]:
    """(topic by key, remarks) for the topics {name: type} of the recording `name`.

    Where several topics fit one key, the namespace decides that alone has topics below `trunk/`.
    RecordingError if that leaves a choice, if no topic fits, or if one that fits is of another type;
    ForeignError if none says where the arm was or was to go, and others of joints may.
    """
    found: dict[str, dict[str, str]] = {}
    for topic in topics:
        if split := split_topic(topic):
            found.setdefault(split[1], {})[split[0]] = topic
    renamed = foreign_states(topics)
    if namespace is not None:
        wanted = "/" + namespace.strip("/") if namespace.strip("/") else ""
        found = {key: {wanted: there[wanted]} for key, there in found.items() if wanted in there}
        renamed = [topic for topic in renamed if topic.startswith(wanted + "/")]
    if not found or (renamed and not found.keys() & {*SHOWN, *SOURCES}):
        there = ", ".join(sorted(topics)[:12]) or "none"
        if namespace is not None and not renamed:
            wanted = ", ".join(TOPICS.values())
            raise RecordingError(
                f"{name}: no topic of an arm in {namespace} ({wanted}); topics there: {there}"
            )
        if not topics:
            raise RecordingError(f"{name}: holds no topics: nothing was recorded, or none of it is left")
        raise ForeignError(
            f"{name}: no topic of an arm says where it was ({', '.join(TOPICS[key] for key in SHOWN)}); "
            f"topics there: {there}. `trunk_ros info {name}` gives the mapping by which `trunk_ros import` "
            "takes them in"
        )
    chosen, remarks = _decide(name, found)
    absent = [TOPICS[key] for key in ("gearbox_states", "joint_states") if key not in found]
    if absent and renamed:
        remarks.append(
            f"no {' and no '.join(absent)}, but {', '.join(renamed)}: `trunk_ros import` takes topics of "
            "other names in by a mapping"
        )
    for key, topic in chosen.items():
        if topics[topic] != expected_type(key):
            raise RecordingError(f"{name}: {topic} is {topics[topic][:80]}, not {expected_type(key)}")
    return chosen, remarks


def foreign_states(topics: dict[str, str]) -> list[str]:
    """Topics of joints among {name: type} whose names are not ours: what ours may have been renamed to."""
    return [
        topic
        for topic, kind in sorted(topics.items())
        if kind == JOINT_STATE and split_topic(topic) is None and OURS not in topic.split("/")
    ]


def _decide(name: str, found: dict[str, dict[str, str]]) -> tuple[dict[str, str], list[str]]:
    spaces = sorted({space for there in found.values() for space in there})
    arms = sorted({space for key, there in found.items() if "/" in TOPICS[key] for space in there})
    chosen = {}
    for key, there in found.items():
        if len(there) == 1:
            chosen[key] = next(iter(there.values()))
        elif len(arms) == 1 and arms[0] in there:
            chosen[key] = there[arms[0]]
        else:
            said = ", ".join(space or "/" for space in sorted(there))
            raise RecordingError(
                f"{name}: holds {TOPICS[key]} of several arms ({said}): give --namespace, or a bag with one"
            )
    fitting = {topic for there in found.values() for topic in there.values()}
    left_out = sorted(fitting - set(chosen.values()))
    remarks = [f"topics of the namespaces {', '.join(s or '/' for s in spaces)}"] if len(spaces) > 1 else []
    return chosen, remarks + [f"{topic} is left out: it belongs to something else" for topic in left_out]
