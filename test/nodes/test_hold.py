"""When something goes wrong on the way, the arm holds, and the nodes go on."""

import os
import signal
import time
from contextlib import ExitStack

import numpy as np
import pytest

from test.nodes.graph import JOINTS, hears, needs_ros, rests, running, said_by, seconds, words
from trunk_ros.model import load_model

pytestmark = needs_ros
PATIENT = ("--ros-args", "-p", "timeout:=5.0")  # streams that a busy machine delays are not stale


@pytest.fixture
def ends(peer):
    """The test's ends of all topics of the compensator."""
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState, JointTrajectory

    class Ends:
        gearbox = peer.publisher(JointState, "trunk/gearbox_states")
        joints = peer.publisher(JointState, "joint_states")
        asked = peer.publisher(JointState, "trunk/setpoints")
        trajectory = peer.publisher(JointTrajectory, "trunk/joint_trajectory")
        references = peer.listen(JointState, "trunk/reference")
        setpoints = peer.listen(JointState, "trunk/setpoints")
        states = peer.listen(JointState, "trunk/gearbox_states")
        said = peer.listen(DiagnosticArray, "diagnostics")

        @staticmethod
        def go(angle, seconds):
            from trunk_ros.nodes.graph.messages import trajectory_message
            from trunk_ros.trajectory import Trajectory

            path = Trajectory(tuple(JOINTS), np.array([seconds]), np.full((1, 5), angle))
            Ends.trajectory.publish(trajectory_message(path))

        @staticmethod
        def state(publisher, names, values):
            from trunk_ros.nodes.graph.ros import JointState

            message = JointState(name=list(names), position=[float(value) for value in values])
            message.header.stamp = peer.now()
            publisher.publish(message)

    return Ends


def odd_messages():
    """Names and values of messages that make no sense, or too little."""
    nan, inf = float("nan"), float("inf")
    return [
        (["elbow"], [0.1]),
        ([], []),
        ([], [0.1, 0.2]),
        (JOINTS, []),
        (JOINTS, [0.1]),
        (["joint_1", "joint_1"], [0.1, 0.2]),
        (JOINTS, [nan] * 5),
        (JOINTS, [inf, -inf, 0.0, 1e300, -1e300]),
        ([""] * 3, [0.0] * 3),
        (["joint_1" * 1000], [0.0]),
    ]


def test_no_message_brings_a_node_down(domain, peer, ends):
    from trunk_ros.nodes.graph.ros import JointTrajectory, JointTrajectoryPoint

    with ExitStack() as stack:
        names = ("servo_driver", "wire_elasticity", "compensator")
        nodes = [stack.enter_context(running(name, *PATIENT, domain=domain)) for name in names]
        peer.meets(ends.trajectory, ends.gearbox, ends.joints, node="compensator")
        peer.meets(ends.asked, node="servo_driver")
        peer.meets(ends.gearbox, node="wire_elasticity")
        peer.until(lambda: hears(ends.said, "compensator", "trunk/gearbox_states", "joint_states"))
        for joints, values in odd_messages():
            for publisher in (ends.gearbox, ends.joints, ends.asked):
                ends.state(publisher, joints, values)
            point = JointTrajectoryPoint(positions=[float(value) for value in values])
            ends.trajectory.publish(JointTrajectory(joint_names=joints, points=[point]))
            ends.trajectory.publish(JointTrajectory(joint_names=joints, points=[JointTrajectoryPoint()] * 2))
        ends.go(0.1, 0.5)
        peer.until(lambda: ends.references and ends.references[-1].position[0] == pytest.approx(0.1))
        assert [node.poll() for node in nodes] == [None] * 3
        for name in names:  # states are heard with best effort: one alone may be lost
            peer.answered(
                lambda: [ends.state(out, ["elbow"], [0.1]) for out in (ends.gearbox, ends.asked)],
                lambda name=name: "elbow" in words(ends.said, name),
            )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_node_in_good_order(domain, peer, ends, number):
    with running("compensator", domain=domain) as process:
        peer.until(lambda: ends.said)
        process.send_signal(number)
        assert process.wait(timeout=60) == 0


def test_when_the_driver_is_killed_the_reference_holds_and_goes_on_when_it_is_back(domain, peer, ends):
    with running("compensator", *PATIENT, domain=domain):
        with running("servo_driver", domain=domain) as driver:
            peer.meets(ends.trajectory, node="compensator")
            peer.until(lambda: hears(ends.said, "compensator", "trunk/gearbox_states"))
            ends.go(0.3, 20.0)
            peer.until(lambda: ends.references and ends.references[-1].position[0] > 0.03)
            os.kill(driver.pid, signal.SIGKILL)
            driver.wait()
        peer.until(lambda: "no trunk/gearbox_states" in words(ends.said, "compensator"))
        ends.go(0.0, 1.0)
        peer.until(lambda: "trajectory refused: no trunk/gearbox_states" in words(ends.said, "compensator"))
        held = ends.references[-1].position[0]
        peer.more(ends.references)
        assert ends.references[-1].position[0] == held < 0.3
        with running("servo_driver", domain=domain):
            peer.until(lambda: said_by(ends.said, "compensator")[-1].message == "ok")
            ends.go(0.0, 1.0)
            peer.until(lambda: ends.references[-1].position[0] == pytest.approx(0.0))


def test_when_the_compensator_is_killed_the_motors_hold(domain, peer, ends):
    with (
        running("servo_driver", domain=domain),
        running("compensator", *PATIENT, domain=domain) as compensator,
    ):
        peer.meets(ends.trajectory, node="compensator")
        peer.until(lambda: hears(ends.said, "compensator", "trunk/gearbox_states"))
        ends.go(0.3, 20.0)
        peer.until(lambda: ends.states[-1].position[0] > 0.1)
        os.kill(compensator.pid, signal.SIGKILL)
        compensator.wait()
        ends.said.clear()
        peer.until(lambda: "no trunk/setpoints" in words(ends.said, "servo_driver"))
        peer.until(lambda: rests(ends.states))
        held = np.array(ends.states[-1].position)
        np.testing.assert_allclose(held, ends.setpoints[-1].position, atol=1e-3)
        peer.more(ends.states, 50)
        np.testing.assert_allclose(ends.states[-1].position, held, atol=1e-4)


def test_permuted_joints_mean_the_same_and_missing_ones_stay(domain, peer, ends):
    with running("servo_driver", domain=domain):
        peer.meets(ends.asked, node="servo_driver")
        peer.until(lambda: ends.states)
        ends.state(ends.asked, JOINTS[::-1], [0.5, 0.4, 0.3, 0.2, 0.1])
        peer.until(lambda: np.allclose(ends.states[-1].position, [0.1, 0.2, 0.3, 0.4, 0.5], atol=1e-3))
        ends.state(ends.asked, ["joint_4", "joint_2"], [0.0, -0.2])
        peer.until(lambda: np.allclose(ends.states[-1].position, [0.1, -0.2, 0.3, 0.0, 0.5], atol=1e-3))


def test_lost_messages_are_bridged_by_holding(domain, peer, ends):
    rng = np.random.default_rng(5)
    with running("servo_driver", domain=domain):
        peer.meets(ends.asked, node="servo_driver")
        for step in range(100):
            if rng.uniform() > 0.4:
                ends.state(ends.asked, JOINTS, [0.003 * step] * 5)
            peer.more(ends.states, 1)
        ends.state(ends.asked, JOINTS, [0.3] * 5)
        peer.until(lambda: np.allclose(ends.states[-1].position, 0.3, atol=1e-3))
    path = np.array([state.position for state in ends.states])
    assert np.diff(path, axis=0).min() > -1e-3


@pytest.mark.parametrize(
    ("other", "words_of_it"),
    [
        ("q", "robot_description has no joint_1, but q_1"),
        ("narrow", "joint_1 goes from -0.4014 to 0.4014 rad"),
    ],
)
def test_a_compensator_whose_model_is_of_another_arm_refuses_to_move_it(
    domain, peer, ends, other, words_of_it
):
    from dataclasses import replace

    from trunk_ros.arm.urdf import urdf
    from trunk_ros.nodes.graph.qos import LATCHED
    from trunk_ros.nodes.graph.ros import String

    arm = load_model("trunk").arm
    there = {
        "q": replace(arm, joints=tuple(f"q_{number}" for number in range(1, 6))),
        "narrow": replace(arm, lower=arm.lower / 2),
    }[other]
    description = peer.node.create_publisher(String, "robot_description", LATCHED)
    description.publish(String(data=urdf(there)))
    with running("compensator", "--ros-args", "-p", "timeout:=60.0", domain=domain):
        peer.meets(ends.trajectory, ends.gearbox, node="compensator")
        peer.until(lambda: words_of_it in words(ends.said, "compensator"))
        ends.go(0.1, 0.5)
        peer.until(lambda: "trajectory refused: " in words(ends.said, "compensator"))
        description.publish(String(data=urdf(arm)))
        peer.until(lambda: ends.said[-1].status[0].level < b"\2")
        peer.answered(
            lambda: ends.state(ends.gearbox, JOINTS, [0.0] * 5),
            lambda: hears(ends.said, "compensator", "trunk/gearbox_states"),
        )
        assert not ends.setpoints
        ends.go(0.1, 0.5)
        peer.until(lambda: ends.references and ends.references[-1].position[0] == pytest.approx(0.1))


def test_an_arm_that_does_not_say_where_it_stands_is_not_moved(domain, peer, ends):
    with running("compensator", "--ros-args", "-p", "patience:=0.5", domain=domain):
        peer.meets(ends.trajectory, ends.gearbox, node="compensator")

        def heard():
            ends.state(ends.gearbox, JOINTS[:4], [0.2] * 4)
            return hears(ends.said, "compensator", "trunk/gearbox_states")

        peer.until(heard)
        ends.go(0.1, 0.5)
        peer.until(lambda: "do not say where all joints stand" in words(ends.said, "compensator"))
        assert not ends.setpoints

        def stand_and_go():
            ends.state(ends.gearbox, JOINTS, [0.2] * 5)
            ends.go(0.1, 0.5)

        peer.answered(stand_and_go, lambda: ends.setpoints)
    np.testing.assert_allclose(ends.setpoints[0].position, 0.2, atol=1e-3)


def test_an_arm_that_shows_late_where_it_stands_is_led_from_there(domain, peer):
    from trunk_ros.nodes.graph.messages import joint_state
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    reference, setpoints = (
        peer.publisher(JointState, "trunk/reference"),
        peer.listen(JointState, "trunk/setpoints"),
    )
    said = peer.listen(DiagnosticArray, "diagnostics")
    unseen = ("--ros-args", "-p", "open_loop:=true", "-p", "patience:=60.0")
    with running("compensator", *unseen, domain=domain):
        peer.meets(reference, node="compensator")
        reference.publish(joint_state(0, JOINTS, np.full(5, 0.1)))
        peer.until(lambda: len(setpoints) > 5)  # nobody says where the arm stands: it is taken to stand at 0
        gearbox = peer.publisher(JointState, "trunk/gearbox_states")
        peer.meets(gearbox, node="compensator")
        peer.answered(
            lambda: gearbox.publish(joint_state(time.time_ns(), JOINTS, np.full(5, -0.5))),
            lambda: setpoints[-1].position[0] < 0,
        )

        def follow():
            gearbox.publish(joint_state(time.time_ns(), JOINTS, np.array(setpoints[-1].position)))
            return "starting anew from there" in words(said, "compensator")

        peer.until(follow)
    path = np.array([message.position for message in setpoints])
    at = np.array([seconds(message.header.stamp) for message in setpoints])
    anew = int(np.argmax(path[:, 0] < 0))
    np.testing.assert_allclose(path[anew], -0.5, atol=0.02)
    top_speed = load_model("trunk").arm.v_max
    moved = np.abs(np.diff(path[anew:], axis=0)).max(axis=1)
    assert (moved <= top_speed * np.diff(at[anew:]) + 1e-6).all()


def test_a_compensator_that_was_deactivated_starts_anew_from_where_the_arm_stands(domain, peer, ends):
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState

    change = peer.node.create_client(ChangeState, "compensator/change_state")

    def ask(transition):
        assert peer.call(change, ChangeState.Request(transition=Transition(id=transition))).success

    def start(angle):
        ends.state(ends.gearbox, JOINTS, [angle] * 5)
        ends.go(0.0, 1.0)

    def since(moment):
        return [each for each in ends.setpoints if seconds(each.header.stamp) > moment]

    with running("compensator", domain=domain):
        peer.meets(ends.trajectory, ends.gearbox, node="compensator")
        peer.answered(lambda: start(0.3), lambda: ends.setpoints)
        ask(Transition.TRANSITION_DEACTIVATE)
        silent = seconds(peer.now())
        ask(Transition.TRANSITION_ACTIVATE)
        peer.more(ends.said, 2)  # its own seconds
        assert not since(silent)
        peer.answered(lambda: start(-0.3), lambda: since(silent))
    np.testing.assert_allclose(since(silent)[0].position, -0.3, atol=1e-3)
