"""What a node tells others of itself: diagnostics once a second, and how far it is to who started it."""

from __future__ import annotations

from typing import Any

from trunk_ros.nodes.graph.messages import time_message
from trunk_ros.nodes.graph.progress import Listener
from trunk_ros.nodes.graph.qos import DEPTH
from trunk_ros.nodes.graph.ros import DiagnosticArray, DiagnosticStatus, KeyValue, QoSProfile, String

PROGRESS_TOPIC = "trunk/_progress"  # hidden: only listened to by the bringup that started the node
BEAT = 0.05  # s


class Report:
    """``listener``: takes the node's progress; where a bringup is in another process, it is published."""

    def __init__(self, node: Any):
        self.node = node
        self.listener: Listener | None = None

    def open(self) -> None:
        """Create the publishers; they end with the node's streams."""
        self._publish = self.node.streams.publish(DiagnosticArray, "diagnostics")
        if not self.node.value("supervised"):
            return
        if self.listener is None:
            publisher = self.node.create_publisher(String, PROGRESS_TOPIC, QoSProfile(depth=DEPTH))
            self.listener = lambda progress: publisher.publish(String(data=progress.to_json()))
        self.node.every(BEAT, self._beat)

    def step(self, now: int) -> None:
        """After each step of the node's loop, at ``now`` ns."""
        if self.node.health.due(now):
            self.node.streams.look_after_qos()
            self.node.diagnosing()
            self.diagnose(now)
        self.node.streams.progress.stamp = now
        self.node.tell()

    def diagnose(self, now: int) -> None:
        """Publish the node's health."""
        level, words, values = self.node.health.report(now)
        name = self.node.get_fully_qualified_name()
        status = DiagnosticStatus(level=bytes([level]), name=name, message=words, hardware_id="trunk")
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp = time_message(now)
        self._publish(message)

    def _beat(self) -> None:
        self.node.beat()
        self.tell(True)

    def tell(self, wanted: bool) -> None:
        """In real time nobody waits for each message: a beat now and then is enough."""
        if self.listener is not None and wanted:
            self.listener(self.node.streams.progress)
