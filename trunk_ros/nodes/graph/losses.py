"""Counts what did not arrive: publishers number their messages, so that a gap is a loss."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from trunk_ros.nodes.graph.elapsed import SECOND


@dataclass
class Tally:
    """One topic: ``lost`` on the way, ``dropped`` here for want of room, sent ``before`` we listened.

    ``paused``: messages pass by uncounted, and a gap is none.
    """

    received: int = 0
    lost: int = 0
    dropped: int = 0
    before: int = 0
    longest_gap_ns: int = 0
    publishers: int = 1
    """How many the graph shows."""
    paused: bool = False
    unrecorded: list[str] = field(default_factory=list)
    """Types that others publish on the topic: a bag has one of each topic."""
    _streams: list[int] = field(default_factory=list)
    """Last number of each publisher, the one heard last at the end: messages do not say whose they are.

    One that ended is among them until others take its place: it is not known to have ended.
    """
    _last_ns: int | None = None

    @property
    def expected(self) -> int:
        """Messages that should have come."""
        return self.received + self.lost

    def goes_on(self, number: int | None) -> bool:
        """Whether a number is the next of a publisher that was heard."""
        return number is None or number - 1 in self._streams

    def pause(self) -> None:
        """Count nothing until ``resume``."""
        self.paused, self._last_ns = True, None

    def resume(self) -> None:
        """Count again."""
        self.paused = False

    def note(self, number: int | None, arrival_ns: int) -> int:
        """Count a message with its publisher's number; returns how many it shows to be lost."""
        missing = 0 if number is None else self._follow(number)
        if self.paused:
            return 0
        self.received += 1
        if self._last_ns is not None:
            self.longest_gap_ns = max(self.longest_gap_ns, arrival_ns - self._last_ns)
        self._last_ns = arrival_ns
        self.lost += missing
        return missing

    def _follow(self, number: int) -> int:
        """Whose a number may be. A publisher that begins anew does not end those that were heard before."""
        streams = self._streams
        if number - 1 in streams:
            streams.remove(number - 1)
            streams.append(number)
            return 0
        alive = streams[-self.publishers :]
        earlier = [last for last in alive if last < number]
        if not earlier or len(streams) < self.publishers or number == 1:
            self._join(number)
            return 0
        last = max(earlier)
        streams.remove(last)
        streams.append(number)
        return number - last - 1

    def _join(self, number: int) -> None:
        """A publisher that was not heard before, or that began anew."""
        self.before += 0 if self.paused else number - 1
        del self._streams[: max(len(self._streams) - 2 * self.publishers + 1, 0)]
        self._streams.append(number)

    def summary(self) -> dict[str, Any]:
        """What the bag says of the topic."""
        said = {
            "expected": self.expected,
            "received": self.received,
            "lost": self.lost,
            "dropped": self.dropped,
            "sent_before_recording": self.before,
            "longest_gap_s": self.longest_gap_ns / SECOND,
        }
        return said | ({"types_not_recorded": self.unrecorded} if self.unrecorded else {})


def in_words(bag: str, losses: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """What a run is summed up with: messages in the bag, and what each topic lacks."""
    kept = sum(int(each["received"] - each["dropped"]) for each in losses.values())
    missing = sum(int(each["lost"] + each["dropped"]) for each in losses.values())
    others = [f"  {topic}: {left_out(each)}" for topic, each in losses.items() if left_out(each)]
    told = str(missing) if missing else "none" if not others else "none of those"
    lines = [f"{bag}: {kept} messages on {len(losses)} topics, {told} lost", *others]
    for topic, each in losses.items():
        if each["lost"] or each["dropped"]:
            lines.append(
                f"  {topic}: of {each['expected']:.0f} messages {each['lost']:.0f} lost on the way, "
                f"{each['dropped']:.0f} not written; longest gap {each['longest_gap_s']:.3g} s"
            )
    return lines


def left_out(losses: Mapping[str, Any]) -> str:
    """Words about types of a topic that a bag does not have, "" where it has all."""
    types = losses.get("types_not_recorded", [])
    return f"also published as {', '.join(types)}, not recorded: a topic has one type" if types else ""
