"""Real nodes over DDS for tests: processes on a domain of their own, and a peer that speaks to them."""

from __future__ import annotations

import inspect
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from test.nodes.domains import own_domain

ROOT = Path(__file__).resolve().parents[2]
JOINTS = [f"joint_{number}" for number in range(1, 6)]
PATIENCE = 120.0  # s; how fast a machine is decides nothing, this only ends what hangs


def environment(domain: int) -> dict[str, str]:
    """The environment of a node; the ament index has to be found without help."""
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    kept = {key: value for key, value in os.environ.items() if key != "AMENT_PREFIX_PATH"}
    return kept | {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def trunk(
    *arguments: Any, domain: int | None = None, timeout: float = 4 * PATIENCE
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end."""
    command = [sys.executable, "-m", "trunk_ros", *map(str, arguments)]
    with ExitStack() as stack:
        env = environment(stack.enter_context(own_domain()) if domain is None else domain)
        return subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, timeout=timeout)


@contextmanager
def running(*arguments: Any, domain: int) -> Iterator[subprocess.Popen[str]]:
    """A command that goes on beside the test, and is ended with it."""
    command = [sys.executable, "-m", "trunk_ros", *map(str, arguments)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "stdin": subprocess.PIPE}
    process = subprocess.Popen(command, cwd=ROOT, env=environment(domain), text=True, **pipes)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            try:
                process.communicate(timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()


def ended(process: subprocess.Popen[str], number: signal.Signals) -> tuple[int, str, str]:
    """Exit code, standard output and error of a process after a signal."""
    process.send_signal(number)
    out, error = process.communicate(timeout=PATIENCE)
    return process.returncode, out, error


class Peer:
    """A node of the test's own: publishes, listens, and waits."""

    def __init__(self, domain: int):
        from trunk_ros.nodes.graph.ros import EventsExecutor, rclpy

        environment(domain)
        self.context = rclpy.Context()
        self.context.init(domain_id=domain)
        self.node = rclpy.create_node("test_peer", context=self.context)
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.met: set[Any] = set()

    def publisher(self, kind: Any, topic: str) -> Any:
        """A reliable publisher."""
        return self.node.create_publisher(kind, topic, 100)

    def listen(self, kind: Any, topic: str) -> list[Any]:
        """A list that grows with the messages of a topic."""
        heard: list[Any] = []
        self.node.create_subscription(kind, topic, heard.append, 100)
        return heard

    def until(self, condition: Callable[[], Any], timeout: float = PATIENCE) -> None:
        """Spin until a condition holds; fails the test where it does not in time."""
        end = time.monotonic() + timeout
        while not holds(condition):
            assert time.monotonic() < end, f"waited in vain: {inspect.getsource(condition).strip()}"
            self.spin_once()

    def answered(self, say: Callable[[], Any], answer: Callable[[], Any], timeout: float = PATIENCE) -> None:
        """Say something, again each second, until it is answered: a message on /clock may be lost."""
        end = time.monotonic() + timeout
        while not holds(answer):
            assert time.monotonic() < end, f"no answer: {inspect.getsource(answer).strip()}"
            say()
            again = time.monotonic() + 1.0
            while not holds(answer) and time.monotonic() < again:
                self.spin_once()

    def spin_once(self) -> None:
        """Serve what has come, or wait a moment for it."""
        self.executor.spin_once(timeout_sec=0.02)

    def more(self, heard: list[Any], count: int = 20) -> None:
        """Spin until so many more messages have come: what was to happen at once has happened by then."""
        most = len(heard) + count
        self.until(lambda: len(heard) >= most)

    def meets(self, *publishers: Any, node: str) -> None:
        """Spin until a node hears all of these publishers, beside other subscribers that there may be."""

        def matched(publisher: Any) -> bool:
            ears = self.node.get_subscriptions_info_by_topic(publisher.topic_name)
            there = any(each.node_name == node for each in ears)
            return there and publisher.get_subscription_count() >= len(ears)

        try:
            self.until(lambda: all(matched(each) for each in publishers))
        except AssertionError as vain:
            ears = {p.topic_name: self.node.get_subscriptions_info_by_topic(p.topic_name) for p in publishers}
            told = {topic: [each.node_name for each in heard] for topic, heard in ears.items()}
            count = [each.get_subscription_count() for each in publishers]
            raise AssertionError(f"{node} hears not all: {told}, {count} matched") from vain

    def call(self, client: Any, request: Any) -> Any:
        """The answer of a service."""
        self.until(client.service_is_ready)
        if client not in self.met:
            self._is_met(client.srv_name.rpartition("/")[0])
            self.met.add(client)
        done = client.call_async(request)
        self.until(lambda: done.done())
        return done.result()

    def _is_met(self, node: str) -> None:
        """Ask what may be asked again until a node answers.

        A node that has not met the ear of a client yet loses its answer for good (rmw_fastrtps: "client will
        not receive response"); ears are met in the order in which they were made.
        """
        from rcl_interfaces.srv import ListParameters

        client = self.node.create_client(ListParameters, f"{node}/list_parameters")
        self.until(client.service_is_ready)
        asked: list[Any] = []
        self.answered(
            lambda: asked.append(client.call_async(ListParameters.Request())),
            lambda: any(each.done() for each in asked),
        )

    def now(self) -> Any:
        """The stamp of this moment."""
        return self.node.get_clock().now().to_msg()

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the graph: what the executor still holds would stay in it, for who gets the domain next."""
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()


def holds(condition: Callable[[], Any]) -> Any:
    """Whether a condition holds; one on the last message does not before there is any."""
    try:
        return condition()
    except IndexError:
        return False


class Received:
    """How many messages of a topic a supervised recorder has received, as it says itself."""

    def __init__(self, peer: Peer):
        from trunk_ros.nodes.graph.report import PROGRESS_TOPIC
        from trunk_ros.nodes.graph.ros import String

        self.said = peer.listen(String, PROGRESS_TOPIC)

    def __call__(self, topic: str) -> int:
        from trunk_ros.nodes.graph.progress import Progress

        return Progress.from_json(self.said[-1].data).received.get(topic, 0) if self.said else 0


def words(statuses: list[Any], node: str) -> str:
    """All that a node has said on diagnostics."""
    return " | ".join(status.message for status in said_by(statuses, node))


def said_by(statuses: list[Any], node: str) -> list[Any]:
    """What a node has said on diagnostics."""
    return [status for array in statuses for status in array.status if status.name.lstrip("/") == node]


def values(statuses: list[Any], node: str) -> dict[str, str]:
    """The values that a node has shown last on diagnostics, none where it has not."""
    return {item.key: item.value for status in said_by(statuses, node)[-1:] for item in status.values}


def hears(statuses: list[Any], node: str, *topics: str) -> bool:
    """Whether a node has said on diagnostics that each of these topics comes in."""
    shown = [(item.key, item.value) for status in said_by(statuses, node) for item in status.values]
    heard = {key for key, value in shown if key.endswith(" [Hz]") and float(value) > 0}
    return all(f"{topic} [Hz]" in heard for topic in topics)


def rests(states: list[Any], count: int = 10) -> bool:
    """Whether the last messages all say the same position."""
    last = [list(state.position) for state in states[-count:]]
    return len(last) == count and all(position == last[0] for position in last)


def seconds(stamp: Any) -> float:
    """A message's stamp [s]."""
    return stamp.sec + stamp.nanosec * 1e-9


def bag_messages(path: Path) -> dict[str, list[bytes]]:
    """Messages of a bag per topic, as rosbags reads them."""
    from rosbags.rosbag2 import Reader

    found: dict[str, list[bytes]] = {}
    with Reader(path) as reader:
        for connection in reader.connections:
            found.setdefault(connection.topic, [])
        for connection, _, data in reader.messages():
            found[connection.topic].append(bytes(data))
    return found


needs_ros = pytest.mark.skipif(
    __import__("importlib.util").util.find_spec("rclpy") is None, reason="ROS 2 is not installed here"
)


def size_of(file: Path) -> int:
    """Bytes of a file; none of one that was renamed since it was listed, as the recorder's drafts are."""
    with suppress(FileNotFoundError):
        return file.stat().st_size
    return 0
