"""A domain per test, and nothing left in shared memory."""

from collections.abc import Iterator

import pytest

from test.nodes.graph import Peer, clean_shared_memory, new_domain, segments


@pytest.fixture
def domain() -> Iterator[int]:
    """A ROS_DOMAIN_ID; segments of nodes that were killed are removed afterwards."""
    before = {path.name for path in segments()}
    yield new_domain()
    clean_shared_memory(before)


@pytest.fixture
def peer(domain: int) -> Iterator[Peer]:
    """The test's own node on the domain."""
    there = Peer(domain)
    yield there
    there.close()
