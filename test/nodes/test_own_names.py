"""An arm with topics of its own names, and what is said of sensors that cannot be used."""

import time

import numpy as np
import pytest

from test.nodes.graph import JOINTS, hears, needs_ros, running, values, words

pytestmark = needs_ros

NAMES = ("trunk/setpoints:=motor/command", "trunk/gearbox_states:=motor/state", "joint_states:=encoders")
RENAMED = ["--ros-args", *(word for name in NAMES for word in ("-r", name))]


def state(position, names=JOINTS):
    from trunk_ros.nodes.graph.messages import joint_state

    return joint_state(time.time_ns(), names, np.array(position, dtype=float))


@pytest.fixture
def arm(peer):
    """The ends of an arm whose topics have names of its own."""
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    class Arm:
        motors = peer.publisher(JointState, "motor/state")
        reference = peer.publisher(JointState, "trunk/reference")
        setpoints = peer.listen(JointState, "motor/command")
        said = peer.listen(DiagnosticArray, "diagnostics")

    return Arm()


def test_renamed_motors_that_do_not_say_where_they_stand_are_not_taken_to_stand_at_0(domain, peer, arm):
    with running("compensator", *RENAMED, "-p", "patience:=0.5", domain=domain):
        peer.meets(arm.motors, arm.reference, node="compensator")
        peer.answered(
            lambda: arm.reference.publish(state([0.1] * 5)),
            lambda: "do not say where all joints stand" in words(arm.said, "compensator"),
        )
        assert not arm.setpoints
        peer.answered(lambda: arm.motors.publish(state([0.2] * 5)), lambda: arm.setpoints)
    np.testing.assert_allclose(arm.setpoints[0].position, 0.2, atol=0.02)


def test_while_another_node_sends_renamed_setpoints_the_compensator_is_silent_and_then_says_so(
    domain, peer, arm
):
    from trunk_ros.nodes.graph.ros import JointState

    other = peer.publisher(JointState, "motor/command")
    with running("compensator", *RENAMED, domain=domain):
        peer.meets(arm.motors, arm.reference, node="compensator")
        peer.answered(
            lambda: arm.motors.publish(state([0.2] * 5)),
            lambda: hears(arm.said, "compensator", "trunk/gearbox_states"),
        )
        peer.more(arm.said, 2)  # its own seconds
        assert other.get_subscription_count()
        assert not arm.setpoints

        def move():
            arm.motors.publish(state([0.2] * 5))
            arm.reference.publish(state([0.1] * 5))

        peer.answered(
            move, lambda: values(arm.said, "compensator").get("others on trunk/setpoints") == "test_peer"
        )


@pytest.mark.parametrize("unseen", [False, True])
def test_an_arm_that_nobody_reads_is_not_moved_but_in_open_loop(domain, peer, arm, unseen):
    names = ["--ros-args", "-r", NAMES[0], "-p", f"open_loop:={str(unseen).lower()}"]  # one was forgotten
    told = ("do not say where all joints stand: ", "")[unseen] + "nobody publishes /trunk/gearbox_states"
    with running("compensator", *names, "-p", "patience:=0.5", domain=domain):
        peer.meets(arm.reference, node="compensator")
        peer.answered(
            lambda: arm.reference.publish(state([0.1] * 5)),
            lambda: told in words(arm.said, "compensator"),
        )
        if unseen:
            peer.until(lambda: arm.setpoints)
    assert bool(arm.setpoints) is unseen


def test_messages_without_an_angle_are_not_heard_and_the_topic_is_named(domain, peer, arm):
    bad = state([0.2] * 4, JOINTS[:3])
    with running("compensator", *RENAMED, domain=domain):
        peer.meets(arm.motors, node="compensator")
        for message, said in (
            (bad, "trunk/gearbox_states: 3 names but 4 values"),
            (state([], []), "trunk/gearbox_states: no joint of an empty list"),
            (state([np.nan] * 5), "trunk/gearbox_states: no angle of any joint"),
        ):
            peer.answered(
                lambda message=message: arm.motors.publish(message),
                lambda said=said: said in words(arm.said, "compensator"),
            )
        assert not hears(arm.said, "compensator", "trunk/gearbox_states")
        part = state([0.2, np.nan, 0.2, 0.2], JOINTS[:4])
        peer.answered(
            lambda: arm.motors.publish(part),
            lambda: f"no angle of {JOINTS[1]}, {JOINTS[4]}" in words(arm.said, "compensator"),
        )


def test_two_nodes_that_publish_other_angles_of_the_same_joints_are_named(domain, peer, arm):
    from trunk_ros.nodes.graph.ros import JointState

    second = peer.publisher(JointState, "motor/state")
    with running("compensator", *RENAMED, domain=domain):
        peer.meets(arm.motors, second, node="compensator")

        def both():
            for _ in range(3):
                arm.motors.publish(state([0.2] * 5))
                second.publish(state([0.3] * 5))
            return "jump to and fro between test_peer, test_peer" in words(arm.said, "compensator")

        peer.until(both)


def test_a_gripper_beside_the_arm_and_a_node_that_could_publish_and_does_not_are_no_warning(
    domain, peer, arm
):
    from trunk_ros.nodes.graph.ros import JointState

    second = peer.publisher(JointState, "motor/state")
    idle = peer.publisher(JointState, "motor/state")
    with running("compensator", *RENAMED, domain=domain):
        peer.meets(arm.motors, second, idle, node="compensator")
        peer.answered(
            lambda: arm.motors.publish(state([0.2] * 5)),
            lambda: hears(arm.said, "compensator", "trunk/gearbox_states"),
        )

        def with_gripper():
            arm.motors.publish(state([0.2 + 0.01 * len(arm.said)] * 5))
            second.publish(state([0.3], ["finger"]))
            return "no joint of finger belongs to the arm" in words(arm.said[-1:], "compensator")

        peer.until(with_gripper)
    assert arm.said[-1].status[0].level == b"\0"


def test_a_joint_that_turns_the_other_way_is_an_error(domain, peer, arm):
    from trunk_ros.nodes.graph.ros import JointState

    encoders = peer.publisher(JointState, "encoders")

    def stand():
        at = np.array(arm.setpoints[-1].position) if arm.setpoints else np.zeros(5)
        arm.motors.publish(state(at))
        encoders.publish(state(-at))

    with running("compensator", *RENAMED, "-p", "timeout:=60.0", domain=domain):
        peer.meets(arm.motors, encoders, arm.reference, node="compensator")
        peer.answered(stand, lambda: hears(arm.said, "compensator", "joint_states"))
        peer.until(lambda: stand() or arm.setpoints)
        peer.more(arm.said, 3)  # its own seconds: it has rested where the way begins

        def sent():
            stand()
            arm.reference.publish(state([0.3] * 5))
            return "was asked: does the model have" in words(arm.said[-1:], "compensator")

        peer.until(sent)
        assert arm.said[-1].status[0].level == b"\2"
