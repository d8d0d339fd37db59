"""Counts what did not arrive: publishers number their messages, so that a gap is a loss."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from trunk_ros.nodes.graph.elapsed import SECOND


@dataclass
class Tally:
    """One topic: ``lost`` on the way, ``dropped`` here for want of room, sent ``before`` we listened."""

    received: int = 0
    lost: int = 0
    dropped: int = 0
    before: int = 0
    longest_gap_ns: int = 0
    publishers: int = 1
    """How many the graph shows."""
    _streams: list[int] = field(default_factory=list)
    """Last number of each publisher: messages do not say which one they are of."""
    _last_ns: int | None = None

    @property
    def expected(self) -> int:
        """Messages that should have come."""
        return self.received + self.lost

    def goes_on(self, number: int | None) -> bool:
        """Whether a number is the next of a publisher that was heard."""
        return number is None or number - 1 in self._streams

    def note(self, number: int | None, arrival_ns: int) -> int:
        """Count a message with its publisher's number; returns how many it shows to be lost."""
        self.received += 1
        if self._last_ns is not None:
            self.longest_gap_ns = max(self.longest_gap_ns, arrival_ns - self._last_ns)
        self._last_ns = arrival_ns
        missing = 0 if number is None else self._follow(number)
        self.lost += missing
        return missing

    def _follow(self, number: int) -> int:
        streams = self._streams
        if number - 1 in streams:
            streams[streams.index(number - 1)] = number
            return 0
        earlier = [last for last in streams if last < number]
        if not earlier or len(streams) < self.publishers:
            self._join(number)
            return 0
        last = max(earlier)
        streams[streams.index(last)] = number
        return number - last - 1

    def _join(self, number: int) -> None:
        """A publisher that was not heard before, or that began anew."""
        self.before += number - 1
        if len(self._streams) >= self.publishers:
            self._streams.remove(max(self._streams))
        self._streams.append(number)

    def summary(self) -> dict[str, float]:
        """What the bag says of the topic."""
        return {
            "expected": self.expected,
            "received": self.received,
            "lost": self.lost,
            "dropped": self.dropped,
            "sent_before_recording": self.before,
            "longest_gap_s": self.longest_gap_ns / SECOND,
        }


def in_words(bag: str, losses: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """What a run is summed up with: messages in the bag, and what each topic lacks."""
    kept = sum(int(each["received"] - each["dropped"]) for each in losses.values())
    missing = sum(int(each["lost"] + each["dropped"]) for each in losses.values())
    lines = [f"{bag}: {kept} messages on {len(losses)} topics, {missing or 'none'} lost"]
    for topic, each in losses.items():
        if each["lost"] or each["dropped"]:
            lines.append(
                f"  {topic}: of {each['expected']:.0f} messages {each['lost']:.0f} lost on the way, "
                f"{each['dropped']:.0f} not written; longest gap {each['longest_gap_s']:.3g} s"
            )
    return lines
