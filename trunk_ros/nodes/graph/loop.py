"""The loop of a node: steps by the wall's clock or by /clock, late ones and jumps of time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from trunk_ros.nodes.graph.elapsed import LONGEST_PAUSE, SECOND
from trunk_ros.nodes.graph.messages import nanoseconds
from trunk_ros.nodes.graph.qos import DEPTH
from trunk_ros.nodes.graph.reader import if_readable
from trunk_ros.nodes.graph.ros import Clock, ClockType, SteadyClock

WATCH = SECOND // 20  # ns between two steps of a loop that only looks after health


def steady_clock() -> Any:
    """A clock that nothing sets; one for each timer, as rclpy wants it."""
    return SteadyClock(clock_type=ClockType.STEADY_TIME)


class Loop:
    """Calls ``step(now)`` [ns] each period, and the node's ``rewound`` before it where time was set.

    ``idle``: there is nothing to do in real time but to look after health.
    """

    def __init__(self, node: Any, rate: float, idle: bool, step: Callable[[int], None]):
        self.node, self.step = node, step
        period = round(SECOND / rate)
        self.period = max(period, WATCH) if idle and not node.simulated else period
        self._last = -1
        self._woken: float | None = None

    def now(self) -> int:
        """ns of the node's clock: in simulated time the stamp of the step under way."""
        return self._last if self.node.simulated else time.time_ns()

    def start(self) -> None:
        """Begin; ends with the node's streams."""
        if self.node.simulated:
            heard = if_readable(Clock, self._on_clock)
            clock = self.node.create_subscription(Clock, "/clock", heard, DEPTH, raw=True)
            self.node.streams.own(self.node.destroy_subscription, clock)
        else:
            self._woken = None
            self.node.every(self.period / SECOND, self._on_timer)

    def _on_clock(self, message: Any) -> None:
        now = nanoseconds(message.clock)
        if self._last < 0 or not 0 <= now - self._last < self.period:
            self._pass(now, 0)

    def _on_timer(self) -> None:
        awake, before = time.monotonic(), self._woken
        self._woken = awake
        late = 0.0 if before is None else max(awake - before - self.period / SECOND, 0.0)
        self._pass(self.now(), round(late * SECOND))

    def _pass(self, now: int, late: int) -> None:
        before, self._last = self._last, now
        if before >= 0 and not 0 <= now - before <= LONGEST_PAUSE:
            self.node.health.note("time jumped back" if now < before else "time jumped ahead")
            self.node.rewound(now)
        self.node.health.ticked(late)
        self.step(now)
