"""What is heard by two subscriptions is taken once."""

from collections import deque
from types import SimpleNamespace

import pytest

from test.nodes.graph import needs_ros

pytestmark = needs_ros


def info(number, stamp=7):
    return {"source_timestamp": stamp, "publication_sequence_number": number}


@pytest.fixture
def ear():
    """Two subscriptions of one topic, and what each has in store."""
    from trunk_ros.nodes.graph.losses import Tally
    from trunk_ros.nodes.graph.ros import QoSProfile
    from trunk_ros.nodes.graph.topic_subscription import Ear

    def subscription(messages):
        taken = deque(messages)
        return SimpleNamespace(
            handle=SimpleNamespace(take_message=lambda *_: taken.popleft() if taken else None)
        )

    def make(first, second):
        made = Ear(None, subscription(second), QoSProfile(depth=1), None, Tally())
        made.beside(subscription(first))
        return [data for data, _ in made.take(100)]

    return make


def test_a_message_that_both_hear_is_taken_once(ear):
    assert ear([(b"one", info(1)), (b"two", info(2))], [(b"two", info(2)), (b"three", info(3))]) == [
        b"one",
        b"two",
        b"three",
    ]


def test_messages_of_two_publishers_with_the_same_stamp_and_number_are_both_taken(ear):
    assert ear([(b"mine", info(1)), (b"yours", info(1))], [(b"yours", info(1))]) == [b"mine", b"yours"]
