"""What says where the arm stands, as it is heard: only a message with an angle counts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from trunk_ros.nodes.control.goal import State
from trunk_ros.nodes.graph.joints import JointMatcher, MessageError, StrangersError
from trunk_ros.nodes.graph.messages import state_of


class HeardStates:
    """A topic of states. ``put`` takes a stamp [ns] and a State of ``joints``; ``node``: a TrunkNode."""

    def __init__(
        self, node: Any, topic: str, joints: Sequence[str], timeout: float, put: Callable[[int, State], None]
    ):
        self.node, self.topic, self.put = node, topic, put
        self.matcher = JointMatcher(joints)
        self.stream = node.streams.watch(topic, timeout)
        self._shared = False
        node.streams.sense(topic, self._take)

    def _take(self, message: Any) -> None:
        try:
            state = state_of(message, self.matcher)
        except StrangersError:
            self._shared = True
            if self.stream.last is None or self.stream.stale(self.node.now()):
                raise
            return  # of a gripper, say, beside messages of the arm
        unknown = [
            j for j, at in zip(self.matcher.joints, state.position, strict=True) if not np.isfinite(at)
        ]
        if len(unknown) == len(self.matcher.joints):
            raise MessageError("no angle of any joint")
        if unknown:
            self._shared = True
            self.node.health.note(f"{self.topic}: no angle of {', '.join(unknown)}")
        self.put(self.node.streams.arrived(self.stream, message), state)

    def look_for_rivals(self) -> None:
        """Say so where several nodes seem to tell of the same joints: nothing says which of them is right."""
        shared, self._shared = self._shared, False
        if shared or self.node.publishers(self.topic) < 2:
            return
        rivals = self.node.get_publishers_info_by_topic(self.topic)
        names = ", ".join(sorted(each.node_name for each in rivals))
        self.node.health.note(f"{self.topic}: {names} publish the same joints: leave one of them")
