"""A domain per test, and nothing left in shared memory."""

from collections.abc import Iterator

import pytest

from test.nodes.domains import own_domain
from test.nodes.graph import Peer


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
