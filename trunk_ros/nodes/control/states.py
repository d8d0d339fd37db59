"""What says where the arm stands, as it is heard: only a message with an angle counts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from trunk_ros.nodes.control.goal import State
from trunk_ros.nodes.graph.health import OK
from trunk_ros.nodes.graph.joints import JointMatcher, MessageError, StrangersError
from trunk_ros.nodes.graph.messages import state_of

APART = 0.02  # rad to and fro in three messages: an arm does not do so twice in a second, two nodes do


class HeardStates:
    """A topic of states. ``put`` takes a stamp [ns] and a State of ``joints``; ``node``: a TrunkNode."""

    def __init__(
        self, node: Any, topic: str, joints: Sequence[str], timeout: float, put: Callable[[int, State], None]
    ):
        self.node, self.topic, self.put = node, topic, put
        self.matcher = JointMatcher(joints)
        self.stream = node.streams.watch(topic, timeout)
        self._last = self._step = np.zeros(len(self.matcher.joints))
        self._swings = 0
        node.streams.sense(topic, self._take)

    def _take(self, message: Any) -> None:
        try:
            state = state_of(message, self.matcher)
        except StrangersError as error:
            if self.stream.last is None or self.stream.stale(self.node.now()):
                raise
            self.node.health.note(f"{self.topic}: {error}", OK)  # a gripper, say, beside the arm
            return
        unknown = [
            j for j, at in zip(self.matcher.joints, state.position, strict=True) if not np.isfinite(at)
        ]
        if len(unknown) == len(self.matcher.joints):
            raise MessageError("no angle of any joint")
        if unknown:
            self.node.health.note(f"{self.topic}: no angle of {', '.join(unknown)}")
        before, self._step = self._step, state.position - self._last
        self._last = state.position
        self._swings += bool(
            (np.minimum(np.abs(before), np.abs(self._step)) > APART)[before * self._step < 0].any()
        )
        self.put(self.node.streams.arrived(self.stream, message), state)

    def look_for_rivals(self) -> None:
        """Say so where several nodes tell of the same joints: nothing says which of them is right.

        A node that could publish and does not is no harm.
        """
        swings, self._swings = self._swings, 0
        if swings < 2 or self.node.publishers(self.topic) < 2:
            return
        there = self.node.get_publishers_info_by_topic(self.topic)
        names = ", ".join(sorted(each.node_name for each in there))
        self.node.health.note(f"{self.topic} jump to and fro between {names}: leave one of them")
