"""What a reader has to say about a recording, in sentences."""

import json

from trunk_ros.recording.messages.block import Contents
from trunk_ros.recording.messages.decode import Decoder
from trunk_ros.recording.quality import quality_of_series
from trunk_ros.recording.recording import Counts, JointSeries
from trunk_ros.recording.topics import TOPICS
from trunk_ros.words import many


def loss_remarks(contents: Contents, decoders: dict[str, Decoder]) -> list[str]:
    """Damage of the files, and messages that the metadata promises but the files do not hold."""
    remarks = list(contents.damage)
    for key, decoder in decoders.items():
        if decoder.unreadable:
            remarks.append(f"{TOPICS[key]}: {many(decoder.unreadable, 'message')} unreadable, left out")
        if not decoder.messages:
            remarks.append(f"{TOPICS[key]}: no messages")
    return remarks + _missing(contents, decoders)


def _missing(contents: Contents, decoders: dict[str, Decoder]) -> list[str]:
    if not contents.damage:
        return []
    read = sum(decoder.messages for decoder in decoders.values())
    ours = tuple(TOPICS[key] for key in decoders)
    expected = sum(count for topic, count in contents.expected.items() if topic.endswith(ours))
    return [f"{read} of {expected} messages could be read"] if expected > read else []


def recorder_remarks(custom: dict[str, str]) -> list[str]:
    """What the recorder of this package noted about its own losses."""
    try:
        noted = json.loads(custom.get("trunk_ros.loss", "{}"))
        missed = {topic: int(each["lost"] + each["dropped"]) for topic, each in noted.items()}
        return [
            f"{topic}: the recorder missed {count} of {int(noted[topic]['expected'])} messages"
            for topic, count in missed.items()
            if count
        ]
    except (AttributeError, KeyError, RecursionError, TypeError, ValueError, OverflowError):
        return ["what the recorder noted about its losses cannot be read"]


def series_remarks(series: dict[str, JointSeries], counts: dict[str, Counts]) -> list[str]:
    """Duplicates, disorder, masked values, gaps and topics that do not overlap in time."""
    said: dict[str, list[str]] = {}
    for key, each in series.items():
        for text in _counted(counts[key]) + _gaps(each, counts[key]):
            said.setdefault(text, []).append(TOPICS[key])
    remarks = [f"{', '.join(topics)}: {text}" for text, topics in said.items()]
    first = max(series, key=lambda key: float(series[key].stamp[0]))
    last = min(series, key=lambda key: float(series[key].stamp[-1]))
    if series[first].stamp[0] > series[last].stamp[-1]:
        remarks.append(f"{TOPICS[first]} begins after {TOPICS[last]} has ended: are they of one clock?")
    return remarks


def _counted(counts: Counts) -> list[str]:
    texts = []
    if counts.duplicates:
        texts.append(f"{many(counts.duplicates, 'message')} repeated a stamp: the first of each counts")
    if counts.out_of_order:
        texts.append(f"{many(counts.out_of_order, 'message')} out of order, sorted by stamp")
    if counts.not_finite:
        texts.append(f"{many(counts.not_finite, 'value')} not finite, masked")
    if counts.blank:
        texts.append(f"{many(counts.blank, 'message')} without any position, left out")
    return texts


def _gaps(series: JointSeries, counts: Counts) -> list[str]:
    seen = quality_of_series(series, counts)
    if not seen.gaps:
        return []
    longest = f"the longest of {seen.longest_gap:.3g} s at {seen.gap_at:.4g} s"
    return [f"{many(seen.gaps, 'gap')}, {longest}; about {seen.lost} messages missing"]
