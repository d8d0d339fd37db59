"""A topic that is listened to by subscriptions that all of its publishers match; nothing is heard twice."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from trunk_ros.nodes.bags.writer import Channel
from trunk_ros.nodes.graph.interfaces import message_class
from trunk_ros.nodes.graph.losses import Tally
from trunk_ros.nodes.graph.ros import DurabilityPolicy, SubscriptionEventCallbacks

OVERLAP = 1.0  # s that a subscription is kept beside the one that takes its place
REMEMBERED = 20_000  # messages


@dataclass
class Ear:
    """A subscription with all that is known of its topic.

    ``former``: one that it takes the place of, or that hears what some publishers latched.
    """

    kind: Any
    subscription: Any
    profile: Any
    channel: Channel
    tally: Tally
    former: Any = None
    _until: float = 0.0
    _seen: dict[tuple[int, int, int], None] = field(default_factory=dict)

    def beside(self, former: Any) -> None:
        """Listen to another subscription too, for a while."""
        self.former, self._until = former, time.monotonic() + OVERLAP

    def unchanged(self, publishers: int) -> bool:
        """Whether a topic still has so many publishers, and nothing is to be settled."""
        return self.former is None and publishers == self.tally.publishers

    def settle(self, destroy: Callable[[Any], Any], at_once: bool = False) -> None:
        """Give up the former subscription once its time is over."""
        if self.former is not None and (at_once or time.monotonic() > self._until):
            destroy(self.former)
            self.former = None
            if not self._latched:
                self._seen.clear()

    def take(self, most: int) -> Iterator[tuple[bytes, dict[str, Any]]]:
        """Messages that have arrived, at most so many of each subscription, and what is known of them."""
        for subscription in (self.former, self.subscription):
            for _ in range(most if subscription is not None else 0):
                taken = subscription.handle.take_message(self.kind, True)
                if taken is None:
                    break
                if self._is_new(*taken):
                    yield taken

    @property
    def _latched(self) -> bool:
        return bool(self.profile.durability == DurabilityPolicy.TRANSIENT_LOCAL)

    def _is_new(self, data: bytes, info: dict[str, Any]) -> bool:
        """Whether it was not heard before. Messages do not say whose they are: their bytes count too."""
        if self.former is None and not self._latched:
            return True
        mark = info["source_timestamp"], info["publication_sequence_number"] or 0, hash(data)
        if mark in self._seen:
            return False
        self._seen[mark] = None
        if len(self._seen) > REMEMBERED:
            del self._seen[next(iter(self._seen))]
        return True


def by_hand(_: Any) -> None:
    """In the place of a callback: messages are taken, never called back, and no executor serves them."""


def subscribe(node: Any, topic: str, kind: str, profile: Any) -> Any:
    """A subscription whose messages are taken by hand."""
    quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
    return node.create_subscription(
        message_class(kind), topic, by_hand, profile, raw=True, event_callbacks=quiet
    )
