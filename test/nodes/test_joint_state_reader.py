"""Serialised JointStates, read without rclpy's unpacking."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from test.nodes.graph import needs_ros

pytestmark = needs_ros

NUMBERS = st.lists(st.floats(allow_nan=False), max_size=4)
TEXT = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=6)
SAMPLE = st.tuples(st.integers(0, 2**62), TEXT, st.lists(TEXT, max_size=4), NUMBERS, NUMBERS, NUMBERS)


@settings(deadline=None)
@given(st.lists(SAMPLE, min_size=1, max_size=4))
def test_any_sequence_of_joint_states_is_read_as_rclpy_reads_it(samples):
    from rclpy.serialization import serialize_message

    from trunk_ros.nodes.graph.joint_state_reader import JointStateReader

    reader = JointStateReader()
    for message in [made(*each) for sample in samples for each in (sample, (sample[0] + 7, *sample[1:]))]:
        assert reader.read(serialize_message(message)) == message


def test_values_of_a_known_layout_are_read_anew_each_time():
    from rclpy.serialization import serialize_message

    from trunk_ros.nodes.graph.joint_state_reader import JointStateReader

    reader = JointStateReader()
    for step in range(3):
        message = made(step, "base", ["a", "bc"], [0.1 * step, 2.0], [], [3.0, -step])
        assert reader.read(serialize_message(message)) == message


def made(ns, frame, names, position, velocity, effort):
    from trunk_ros.nodes.graph.messages import set_time
    from trunk_ros.nodes.graph.ros import JointState

    message = JointState(name=names, position=position, velocity=velocity, effort=effort)
    message.header.frame_id = frame
    set_time(message.header.stamp, ns % (2**31 * 10**9))
    return message
