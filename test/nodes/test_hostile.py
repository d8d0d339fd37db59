"""Bytes that are no message, and numbers that no arm shows: nodes say so and go on."""

import random
from argparse import Namespace
from pathlib import Path

import pytest

from test.nodes import hostile
from test.nodes.graph import JOINTS, needs_ros, running, words

pytestmark = needs_ros


def test_bytes_that_are_no_message_are_refused_in_one_line():
    from trunk_ros.nodes.graph.joint_state_reader import JointStateReader
    from trunk_ros.nodes.graph.joints import MessageError
    from trunk_ros.nodes.graph.reader import unpacked
    from trunk_ros.nodes.graph.ros import JointState, JointTrajectory

    chance, reader = random.Random(1), JointStateReader()
    for _ in range(300):
        data = hostile.rubbish(chance)
        for read in (reader.read, lambda raw: unpacked(raw, JointTrajectory)):
            said = ""
            try:
                read(data)
            except MessageError as error:
                said = str(error)
            assert not said or "left out" in said
            assert len(said) < 400
    with pytest.raises(MessageError, match="3 bytes that are no JointState were left out"):
        unpacked(b"abc", JointState)


@pytest.mark.parametrize("node", ["servo_driver", "wire_elasticity", "compensator"])
def test_a_node_goes_on_after_bytes_that_are_no_message(node, domain, peer):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    topics = {
        "servo_driver": "trunk/setpoints",
        "wire_elasticity": "trunk/gearbox_states",
        "compensator": "trunk/reference",
    }
    answers = {
        "servo_driver": "trunk/gearbox_states",
        "wire_elasticity": "joint_states",
        "compensator": "trunk/setpoints",
    }
    out, answered = peer.publisher(JointState, topics[node]), peer.listen(JointState, answers[node])
    outs = [out]
    if node == "compensator":  # which moves no arm that somebody knows to stand elsewhere
        outs.append(peer.publisher(JointState, "trunk/gearbox_states"))
    said = peer.listen(DiagnosticArray, "diagnostics")

    def good() -> None:
        message = JointState(name=JOINTS, position=[0.01] * 5)
        message.header.stamp = peer.now()
        for each in reversed(outs):
            each.publish(message)

    with running(node, domain=domain) as process:
        peer.meets(*outs, node=node)
        peer.answered(good, lambda: answered)
        peer.answered(
            lambda: out.publish(b"\x00\x01\x00\x00rubbish"),
            lambda: "are no JointState were left out" in words(said, node),
        )
        answered.clear()
        peer.answered(good, lambda: answered)
        assert process.poll() is None


def test_a_gearbox_angle_that_no_arm_reaches_moves_no_joint(domain, peer):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    out, joints = peer.publisher(JointState, "trunk/gearbox_states"), peer.listen(JointState, "joint_states")
    said = peer.listen(DiagnosticArray, "diagnostics")

    def say(angle: float) -> None:
        message = JointState(name=JOINTS, position=[angle] * 5)
        message.header.stamp = peer.now()
        out.publish(message)

    with running("wire_elasticity", domain=domain):
        peer.meets(out, node="wire_elasticity")
        peer.answered(lambda: say(0.1), lambda: joints)
        peer.answered(lambda: say(1e308), lambda: "is no angle" in words(said, "wire_elasticity"))
        assert all(abs(angle) < 0.1 for state in joints for angle in state.position)


@pytest.mark.parametrize("kind", ["file", "link", "folder", "nothing"])
def test_what_is_overwritten_may_be_anything_and_a_links_target_stays(kind, tmp_path: Path):
    from trunk_ros.nodes.bringup import make_room

    target, output = tmp_path / "target", tmp_path / "output"
    target.mkdir()
    {
        "file": output.touch,
        "folder": output.mkdir,
        "link": lambda: output.symlink_to(target),
        "nothing": lambda: None,
    }[kind]()
    make_room(Namespace(output=output, overwrite=True))
    assert not output.is_symlink()
    assert not output.exists()
    assert target.is_dir()


def test_the_arm_comes_through_a_little_chaos(tmp_path):
    from test.nodes.chaos import run

    result = run(8.0, 3, tmp_path, quiet=5.0)
    assert result["passed"], result
    assert result["fastest_over_limit"] > 0.1
