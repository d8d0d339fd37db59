"""The life of a process: ROS arguments in, signals to a flag, one node until its end."""

from __future__ import annotations

import signal
from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.base import TrunkNode
from trunk_ros.nodes.ros import EventsExecutor, SignalHandlerOptions, rclpy


class Stop:
    """Turns SIGINT and SIGTERM into a flag, so that a process ends in good order."""

    def __init__(self) -> None:
        self.asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._ask)

    def _ask(self, *_: Any) -> None:
        self.asked = True


def run_node(kind: type[TrunkNode], argv: list[str]) -> int:
    """The life of a process with one node: 0 when asked to end, 2 (a TrunkError) when it cannot start."""
    stop = Stop()
    start_ros(argv)
    try:
        node = kind()
        if node.value("autostart"):
            node.start()
        executor = EventsExecutor()
        executor.add_node(node)
        while not stop.asked and not node.fault:
            executor.spin_once(timeout_sec=0.1)
        node.end()
        if node.fault:
            raise TrunkError(f"{node.get_name()}: {node.fault}")
    finally:
        rclpy.try_shutdown()
    return 0


def start_ros(argv: list[str]) -> None:
    """Initialise ROS with a command's ``--ros-args``. Raises TrunkError for others."""
    try:
        rclpy.init(args=["trunk_ros", *argv], signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:
        raise TrunkError(f"bad ROS arguments: {' '.join(str(error).split())}") from None
    rest = rclpy.utilities.remove_ros_args(["trunk_ros", *argv])[1:]
    if rest:
        rclpy.try_shutdown()
        raise TrunkError(f"unknown argument {rest[0]!r}: a node takes --ros-args (see ros2 run --help)")
