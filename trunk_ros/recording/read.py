"""Reads a recording of any kind into arrays; `bag` knows the kinds, `namespace` how topics are found."""

import json
from dataclasses import replace
from pathlib import Path

from trunk_ros.errors import RecordingError, one_line
from trunk_ros.recording.allowance import Allowance
from trunk_ros.recording.bag.bag import read_blocks
from trunk_ros.recording.messages import holes
from trunk_ros.recording.messages.assemble import (
    all_times,
    first_stamp,
    joint_series,
    positioned,
    several_runs,
    table_bytes,
    within,
)
from trunk_ros.recording.messages.block import Contents, DamageError, Progress, Whole
from trunk_ros.recording.messages.decode import Decoder
from trunk_ros.recording.messages.layout import joint_layout, pose_layout
from trunk_ros.recording.messages.text import last_text
from trunk_ros.recording.namespace import choose
from trunk_ros.recording.recording import Counts, JointSeries, PoseSeries, Recording
from trunk_ros.recording.remarks import loss_remarks, recorder_remarks, series_remarks
from trunk_ros.recording.staggered import HELD, brought_together
from trunk_ros.recording.time_range import part_of
from trunk_ros.recording.topics import (
    DESCRIPTION_TOPIC,
    STRING,
    TIP,
    TOPICS,
    expected_type,
    is_description,
    split_topic,
)


def read_recording(
    path: str | Path,
    from_time: str | None = None,
    until: str | None = None,
    namespace: str | None = None,
    progress: Progress | None = None,
) -> Recording:
    """The recording at `path`, as far as it is whole: a rosbag2 folder, a bare .mcap or .db3, a ROS 1 .bag.

    from_time, until: "12.5" (s) or "70%"; stamps stay those of the whole. namespace: of the arm, where the
    recording holds several. progress: called with the fraction that is done.
    Of one with a hole of years, as where the clock was set, this is the part with the most samples.
    RecordingError, ArgumentError: one line on what is wrong.
    """
    whole = max(_read(Path(path), namespace, progress), key=_samples)
    return part_of(whole, from_time, until).checked()


def read_parts(
    path: str | Path, from_time: str | None = None, until: str | None = None, namespace: str | None = None
) -> list[Recording]:
    """The same as all the recordings that it is, mostly one; times are those of each part."""
    wholes = _read(Path(path), namespace, None)
    return [part_of(each, from_time, until).checked() for each in wholes]


def _samples(recording: Recording) -> int:
    return sum(len(each.stamp) for each in recording.series.values())


def _read(path: Path, namespace: str | None, progress: Progress | None) -> list[Recording]:
    try:
        return _read_parts(path, namespace, progress or (lambda _: None))
    except DamageError as error:
        raise RecordingError(f"{path}: {error}") from None
    except (OSError, MemoryError) as error:
        raise RecordingError(f"{path}: cannot be read ({str(error) or 'not enough memory'})") from None


def _read_parts(path: Path, namespace: str | None, progress: Progress) -> list[Recording]:
    contents = Contents(Allowance(path))
    decoders, texts = _decode(path, contents, progress)
    chosen, remarks = choose(str(path), contents.topics, namespace)
    text = _nearest(texts, set(chosen.values()))
    decoders = {key: _positioned(key, decoders[topic]) for key, topic in chosen.items()}
    times = [all_times(decoder.pieces) for decoder in decoders.values() if decoder.pieces]
    found = holes.parts(times) if times else []
    if len(found) < 2:
        return [replace(_assemble(path, contents, decoders, remarks), description=text)]
    largest = max(found, key=lambda part: holes.samples(times, part))
    read = [part for part in found if part == largest or _is_worth(decoders, times, part, largest)]
    out = []
    for part in read:
        others = [holes.remark(times, part, other, other in read) for other in found if other != part]
        cut = _assemble(path, contents, _cut(decoders, part), remarks + others)
        out.append(replace(cut, description=text))
    return out


def _positioned(key: str, decoder: Decoder) -> Decoder:
    """Without messages that say nothing of where joints are; of a wire the tension is enough."""
    if key == "wire_states":
        return decoder
    pieces, blank = positioned(decoder.pieces)
    return replace(decoder, pieces=pieces, blank=blank)


def _is_worth(
    decoders: dict[str, Decoder], times: list[Whole], part: tuple[int, int], largest: tuple[int, int]
) -> bool:
    """Whether a part has as many topics as the largest, and enough of them."""
    topics = [{key for key, each in _cut(decoders, one).items() if each.pieces} for one in (part, largest)]
    return topics[0] == topics[1] and holes.samples(times, part) >= holes.FEWEST


def _cut(decoders: dict[str, Decoder], part: tuple[int, int]) -> dict[str, Decoder]:
    return {
        key: replace(each, pieces=within(each.pieces, *part) if each.pieces else [])
        for key, each in decoders.items()
    }


def _nearest(texts: dict[str, str], chosen: set[str]) -> str:
    """The URDF in the namespace of the arm's topics, else the only one there is."""
    for topic, text in texts.items():
        space = topic.removesuffix(DESCRIPTION_TOPIC)
        if any(each.removeprefix(space) in TOPICS.values() for each in chosen):
            return text
    return next(iter(texts.values())) if len(texts) == 1 else ""


def _wanted(topic: str) -> bool:
    return split_topic(topic) is not None or is_description(topic)


def _decode(path: Path, contents: Contents, progress: Progress) -> tuple[dict[str, Decoder], dict[str, str]]:
    """Every topic that could describe an arm, decoded where it is of the right type, and URDFs by topic."""
    decoders: dict[str, Decoder] = {}
    texts: dict[str, str] = {}
    for block in read_blocks(path, _wanted, contents, progress):
        if is_description(block.topic):
            if block.type == STRING and (text := last_text(block)):
                texts[block.topic] = text
            continue
        found = split_topic(block.topic)
        if found is None or block.type != expected_type(found[1]):
            continue
        if block.encoding not in ("cdr", "ros1"):
            raise DamageError(f"holds {block.topic} encoded as {block.encoding[:20]!r}: only cdr can be read")
        layout_of = pose_layout if found[1] == TIP else joint_layout
        decoders.setdefault(block.topic, Decoder(layout_of)).add(block)
    for topic in contents.topics:
        decoders.setdefault(topic, Decoder(joint_layout))
    return decoders, texts


def _assemble(path: Path, contents: Contents, decoders: dict[str, Decoder], remarks: list[str]) -> Recording:
    """Series with common stamps; RecordingError if no topic has a message. What was decoded of
    a recording in one piece is given up topic by topic: of a long one both would not fit into memory.
    """
    full = {key: decoder for key, decoder in decoders.items() if decoder.pieces}
    remarks = loss_remarks(contents, decoders) + recorder_remarks(contents.custom) + remarks
    if not full:
        reason = f" ({'; '.join(remarks)})" if remarks else ""
        raise RecordingError(f"{path}: no readable message of an arm{reason}")
    start_ns = min(first_stamp(decoder.pieces) for decoder in full.values())
    series: dict[str, JointSeries] = {}
    counts: dict[str, Counts] = {}
    for key, decoder in full.items():
        contents.allowance.check(table_bytes(decoder.pieces))
        if anew := several_runs(decoder.pieces):
            raise RecordingError(f"{path}: {TOPICS[key]}: {anew}")
        series[key], count, remark = joint_series(decoder.pieces, start_ns)
        decoder.pieces.clear()
        counts[key] = replace(
            count,
            messages=count.messages + decoder.blank,
            unreadable=decoder.unreadable,
            blank=decoder.blank,
        )
        remarks += [f"{TOPICS[key]}: {remark}"] if remark else []
    duration = max(float(each.stamp[-1]) for each in series.values())
    remarks += [f"read up to {duration:.6g} s"] if contents.damage else []
    remarks += series_remarks(series, counts)
    tip = _tip(series.pop(TIP, None), full.get(TIP))
    met = {key: brought_together(each, key in HELD, key == "gearbox_states") for key, each in series.items()}
    remarks += [f"{TOPICS[key]}: {said}" for key, (_, said) in met.items() if said]
    noted, custom, units = _custom(contents.custom)
    series = {key: each for key, (each, _) in met.items()}
    series = _same_order(series)
    notes = tuple(dict.fromkeys(map(one_line, remarks + noted)))
    return Recording(str(path), start_ns, duration, series, tip, notes, units, custom, counts)


def _tip(series: JointSeries | None, decoder: Decoder | None) -> PoseSeries | None:
    if series is None or decoder is None:
        return None
    return PoseSeries(series.stamp, series.position[:, :3], series.position[:, 3:], decoder.layouts[0].frame)


def _same_order(series: dict[str, JointSeries]) -> dict[str, JointSeries]:
    """Topics with the same joints get the same order of joints."""
    joints = Recording("", 0, 0.0, series).joints
    return {
        key: each.select(joints) if set(each.joints) == set(joints) else each for key, each in series.items()
    }


def _custom(custom: dict[str, str]) -> tuple[list[str], dict[str, str], dict[str, str]]:
    """Notes, other entries and units that a writer of ours left in the bag."""
    rest = {key: value for key, value in custom.items() if key not in ("trunk_ros.units", "trunk_ros.notes")}
    try:
        units = json.loads(custom.get("trunk_ros.units", "{}"))
        notes = json.loads(custom.get("trunk_ros.notes", "[]"))
        return [str(each) for each in notes], rest, {str(joint): str(unit) for joint, unit in units.items()}
    except (ValueError, TypeError, AttributeError, RecursionError):
        return ["the units noted in the bag cannot be read: rad is assumed"], rest, {}
