"""A domain per test, nothing left in shared memory, and commands that end by themselves."""

import signal
import subprocess
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from test.nodes.domains import own_domain
from test.nodes.graph import Peer
from trunk_ros.__main__ import main

Done = subprocess.CompletedProcess[str]


@pytest.fixture
def domain() -> Iterator[int]:
    """A ROS_DOMAIN_ID; segments of nodes that were killed are removed afterwards."""
    with own_domain() as domain:
        yield domain


@pytest.fixture
def peer(domain: int) -> Iterator[Peer]:
    """The test's own node on the domain."""
    with Peer(domain) as there:
        yield there


@pytest.fixture
def command(
    domain: int, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Callable[..., Done]:
    """command(*words) -> how a command ends that needs no process of its own: code, output, error."""

    def run(*words: Any) -> Done:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        capfd.readouterr()
        try:
            code = main([str(word) for word in words])
        except SystemExit as ended:
            code = int(ended.code or 0)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)  # by which a process of its own would leave in time
        return subprocess.CompletedProcess(words, code, *capfd.readouterr())

    return run
