"""How far a node is: what lets simulated time run as fast as the machine goes without losing a message."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, field


@dataclass
class Progress:
    """Last stamp that a node acted on, and messages sent and received so far per topic (full names).

    ``matched`` counts the partners of each of its publishers (``>topic``) and subscriptions (``<topic``).
    """

    node: str
    stamp: int = -1
    sent: dict[str, int] = field(default_factory=dict)
    received: dict[str, int] = field(default_factory=dict)
    matched: dict[str, int] = field(default_factory=dict)

    def to_json(self) -> str:
        """One line, for a run of several processes."""
        return json.dumps(asdict(self))

    @staticmethod
    def from_json(text: str) -> Progress:
        """The inverse of ``to_json``."""
        return Progress(**json.loads(text))


Listener = Callable[[Progress], None]


class Ledger:
    """All nodes' progress. A step is complete when every node has acted on it and no message is under way."""

    def __init__(self, nodes: list[str], lagging: dict[str, int] | None = None):
        """``lagging``: nodes that may be so many messages behind on each topic, as a recorder has a queue."""
        self.nodes = nodes
        self.lagging = lagging or {}
        self.progress: dict[str, Progress] = {}
        self.excused: dict[str, int] = {}

    def note(self, progress: Progress) -> None:
        """Take a node's word."""
        self.progress[progress.node] = progress

    def missing(self) -> list[str]:
        """Nodes that have not been heard of."""
        return [node for node in self.nodes if node not in self.progress]

    def complete(self, stamp: int) -> bool:
        """Whether every node has acted on ``stamp`` and all that was sent has arrived."""
        if self.missing() or any(self.progress[node].stamp < stamp for node in self.nodes):
            return False
        return not self.in_flight()

    def in_flight(self, strict: bool = False) -> dict[str, int]:
        """Messages sent but not received, by ``topic -> node``; ``strict`` grants no lag."""
        sent: dict[str, int] = {}
        for progress in self.progress.values():
            for topic, count in progress.sent.items():
                sent[topic] = sent.get(topic, 0) + count
        away: dict[str, int] = {}
        for name, progress in self.progress.items():
            for topic in progress.received.keys() & sent.keys():
                key = f"{topic} -> {name}"
                count = max(sent[topic] - progress.received[topic], 0)  # the sender may speak later
                self.excused[key] = min(self.excused.get(key, 0), count)  # it came after all
                count -= self.excused[key]
                if count > (0 if strict else self.lagging.get(name, 0)):
                    away[key] = count
        return away

    def excuse(self) -> dict[str, int]:
        """Wait no longer for what is under way; returns it, by ``topic -> node``."""
        lost = self.in_flight()
        for key, count in lost.items():
            self.excused[key] = self.excused.get(key, 0) + count
        return lost
