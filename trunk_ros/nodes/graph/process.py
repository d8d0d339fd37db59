"""The life of a process: ROS arguments in, signals to a flag, nodes until their end."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.loop import steady_clock
from trunk_ros.nodes.graph.managed import end, retire, start
from trunk_ros.nodes.graph.ros import EventsExecutor, Future, SignalHandlerOptions, rclpy
from trunk_ros.nodes.stop import Stop
from trunk_ros.nodes.usage import usage

DELIVERY = 0.05  # s for the last messages to arrive; waiting for acknowledgements takes a heartbeat of 3 s
MOMENT = 0.05  # s after which it is noticed that somebody asks to end
LEAVING = 20.0  # s that the middleware has to end in
LONG = 1e5  # s; without a timeout the events executor does not see that the future is done, and while
# callbacks queue up it sees no timeout


def run_node(kind: type[TrunkNode], argv: list[str]) -> int:
    """The life of a process with one node: 0 when asked to end, 2 (a TrunkError) when it cannot start."""
    if "-h" in argv or "--help" in argv:
        print(usage(kind.NAME))
        return 0
    return run_nodes([kind], argv)


def run_nodes(kinds: Sequence[Callable[[], TrunkNode]], argv: list[str]) -> int:
    """The same of several on one executor: where one ends, all end."""
    stop, nodes = Stop(), list[TrunkNode]()
    start_ros(argv)
    try:
        executor = EventsExecutor()
        for kind in kinds:
            nodes.append(kind())
        for node in nodes:
            if node.value("autostart"):
                start(node)
            executor.add_node(node)
        serve(executor, nodes[0], lambda: stop.asked or any(node.fault for node in nodes))
        for node in nodes:
            retire(node)
        serve_for(DELIVERY, executor, nodes[0])
    finally:
        try:
            let_go(nodes)
        finally:
            leave_in_time()
            stop.ignore()
            rclpy.try_shutdown()
    return 0


def let_go(nodes: Sequence[TrunkNode]) -> None:
    """Let each node end, whatever becomes of the others. Raises TrunkError where one had to."""
    with ExitStack() as ends:
        for node in reversed(nodes):
            ends.callback(end, node, DELIVERY)
    faults = [f"{node.get_name()}: {node.fault}" for node in nodes if node.fault]
    if faults:
        raise TrunkError("; ".join(faults))


def leave_in_time() -> None:
    """End the process by SIGALRM where the middleware does not let go of it: it may wait for ever for a lock
    in shared memory that a partner held when it was killed. All that is ours has ended by then.
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, LEAVING)


def serve(executor: Any, node: Any, over: Callable[[], Any]) -> None:
    """Serve callbacks until it is over, as a timer of ``node`` finds: cheaper than to look after each."""
    ended = Future()

    def look() -> None:
        if over() and not ended.done():
            ended.set_result(None)

    timer = node.create_timer(MOMENT, look, clock=steady_clock())
    try:
        while not ended.done():
            executor.spin_until_future_complete(ended, timeout_sec=LONG)
    finally:
        node.destroy_timer(timer)


def serve_for(seconds: float, executor: Any, node: Any) -> None:
    """Serve callbacks for a while."""
    end = time.monotonic() + seconds
    serve(executor, node, lambda: time.monotonic() > end)


def look_for_files(argv: Sequence[str]) -> None:
    """Raise TrunkError for a ``--params-file`` that is not there: rcl says it in lines of its own."""
    for option, file in pairwise(argv):
        if option != "--params-file":
            continue
        if not Path(file).exists():  # a pipe, as of <(…), will do
            raise TrunkError(f"--params-file {file}: there is no such file")
        if Path(file).is_dir():
            raise TrunkError(f"--params-file {file}: it is a folder")


def start_ros(argv: list[str]) -> None:
    """Initialise ROS with a command's ``--ros-args``. Raises TrunkError for others."""
    look_for_files(argv)
    try:
        rclpy.init(args=["trunk_ros", *argv], signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:
        raise TrunkError(f"bad ROS arguments: {' '.join(str(error).split())}") from None
    rest = rclpy.utilities.remove_ros_args(["trunk_ros", *argv])[1:]
    if rest:
        rclpy.try_shutdown()
        raise TrunkError(
            f"unknown argument {rest[0]!r}: a node takes --ros-args (--help shows its parameters)"
        )
