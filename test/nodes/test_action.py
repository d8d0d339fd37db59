"""follow_joint_trajectory over DDS, with control_msgs generated where it is not installed."""

import importlib.util
import os
import re
import signal
import sys
from contextlib import ExitStack

import numpy as np
import pytest

from test.nodes import generated
from test.nodes.domains import own_domain
from test.nodes.graph import (
    JOINTS,
    Peer,
    hears,
    needs_ros,
    rests,
    running,
    words,
)

PATIENT = ("--ros-args", "-p", "timeout:=10.0")  # streams that a busy machine delays are not stale
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6  # action_msgs/GoalStatus
INVALID_GOAL, PATH_TOLERANCE_VIOLATED, GOAL_TOLERANCE_VIOLATED = -1, -4, -5
installed = importlib.util.find_spec("control_msgs") is not None
missing = "" if installed else generated.lacking()
pytestmark = [
    needs_ros,
    pytest.mark.skipif(
        bool(missing), reason=f"neither control_msgs nor what it is generated with: {missing}"
    ),
]


@pytest.fixture(scope="module")
def control_msgs(tmp_path_factory):
    """Makes control_msgs importable here and in the nodes' processes."""
    patch = pytest.MonkeyPatch()
    if not installed:
        folder = tmp_path_factory.mktemp("interfaces")
        generated.generate(folder)
        patch.setattr(sys, "path", [str(folder), *sys.path])
        before = os.environ.get("PYTHONPATH")
        patch.setenv("PYTHONPATH", os.pathsep.join([str(folder), *([before] if before else [])]))
    yield
    patch.undo()


class Client:
    """The test's ends of the compensator's topics and of its action."""

    def __init__(self, peer):
        from control_msgs.action import FollowJointTrajectory
        from control_msgs.msg import JointTrajectoryControllerState
        from rclpy.action import ActionClient

        from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState, JointTrajectory

        self.kind = FollowJointTrajectory
        self.peer = peer
        self.client = ActionClient(self.peer.node, FollowJointTrajectory, "trunk/follow_joint_trajectory")
        self.trajectory = self.peer.publisher(JointTrajectory, "trunk/joint_trajectory")
        self.references = self.peer.listen(JointState, "trunk/reference")
        self.states = self.peer.listen(JointTrajectoryControllerState, "trunk/controller_state")
        self.said = self.peer.listen(DiagnosticArray, "diagnostics")
        self.feedback = []

    def goal(self, positions, seconds, joints=JOINTS, **tolerances):
        """A goal with one point."""
        from control_msgs.msg import JointTolerance

        from trunk_ros.nodes.graph.messages import trajectory_message
        from trunk_ros.trajectory import Trajectory

        path = Trajectory(tuple(joints), np.array([seconds]), np.array([positions], dtype=float))
        goal = self.kind.Goal(trajectory=trajectory_message(path))
        for name in ("path_tolerance", "goal_tolerance"):
            if name in tolerances:
                each = [JointTolerance(name=joint, position=tolerances[name]) for joint in joints]
                setattr(goal, name, each)
        goal.goal_time_tolerance.sec = tolerances.get("goal_time", 0)
        return goal

    def send(self, *arguments, **options):
        """Send a goal; returns its handle."""
        request = self.goal(*arguments, **options)
        sent = self.client.send_goal_async(request, feedback_callback=self.feedback.append)
        self.peer.until(lambda: sent.done())
        return sent.result()

    def result(self, handle):
        """Status and result of a goal that ends by itself."""
        waited = handle.get_result_async()
        self.peer.until(lambda: waited.done())
        return waited.result().status, waited.result().result

    def moving(self):
        """Wait until the reference has begun to move."""
        self.peer.until(lambda: self.references)
        start = self.references[-1].position[0]
        self.peer.until(lambda: abs(self.references[-1].position[0] - start) > 0.01)

    def rest(self):
        """Wait until the reference rests; returns where."""
        self.peer.until(lambda: rests(self.references))
        return list(self.references[-1].position)

    def ready(self):
        """Wait until the compensator hears the arm and the test."""
        self.peer.until(lambda: self.client.server_is_ready())
        self.peer.meets(self.trajectory, node="compensator")
        streams = ("trunk/gearbox_states", "joint_states")
        self.peer.until(lambda: hears(self.said, "compensator", *streams))


@pytest.fixture(scope="module")
def arm(control_msgs):
    """The simulated arm, and a client."""
    with ExitStack() as stack:
        domain = stack.enter_context(own_domain())
        for name in ("servo_driver", "wire_elasticity"):
            stack.enter_context(running(name, domain=domain))
        stack.enter_context(running("compensator", *PATIENT, domain=domain))
        client = Client(stack.enter_context(Peer(domain)))
        client.ready()
        client.result(client.send([0.05] * 5, 0.5))
        yield client


def test_a_goal_is_followed_with_feedback_and_reached(arm):
    arm.feedback.clear()
    handle = arm.send(
        [0.15, -0.1], 4.0, joints=["joint_2", "joint_5"], path_tolerance=0.1, goal_tolerance=0.01
    )
    assert handle.accepted
    status, result = arm.result(handle)
    assert (status, result.error_code, result.error_string) == (SUCCEEDED, 0, "goal reached")
    arm.peer.until(lambda: len(arm.feedback) > 5 and arm.feedback[-1].feedback.actual.positions[1] > 0.05)
    last = arm.feedback[-1].feedback
    assert list(last.joint_names) == JOINTS
    difference = np.subtract(last.desired.positions, last.actual.positions)
    np.testing.assert_allclose(last.error.positions, difference, atol=1e-12)
    assert last.actual.positions[1] < 0.16


def test_the_controllers_state_shows_reference_feedback_error_and_output(arm):
    arm.result(arm.send([0.0] * 5, 0.5))
    arm.result(arm.send([0.1] * 5, 0.5))

    arm.peer.until(lambda: np.allclose(arm.states[-1].reference.positions, 0.1, rtol=0, atol=1e-12))
    arm.peer.until(lambda: np.allclose(arm.states[-1].feedback.positions, 0.1, rtol=0, atol=2e-3))
    arm.peer.until(lambda: np.allclose(arm.states[-1].output.positions, 0.16, rtol=0, atol=5e-3))
    state = arm.states[-1]
    np.testing.assert_allclose(
        state.error.positions, np.subtract(state.reference.positions, state.feedback.positions), atol=1e-12
    )
    assert list(state.joint_names) == JOINTS


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ({"positions": [0.1], "seconds": 1.0, "joints": ["elbow"]}, "unknown joint 'elbow'"),
        ({"positions": [0.9], "seconds": 5.0, "joints": ["joint_3"]}, "joint_3 would reach"),
        ({"positions": [0.3], "seconds": 0.01, "joints": ["joint_4"]}, "joint_4 would move at"),
        ({"positions": [0.1] * 5, "seconds": 1.0, "goal_tolerance": -3.0}, "neither positive nor 0 nor -1"),
    ],
)
def test_a_goal_that_cannot_be_followed_is_refused_with_the_reason(arm, goal, reason):
    before = arm.rest()
    assert not arm.send(**goal).accepted
    arm.peer.until(lambda: reason in words(arm.said, "compensator"))
    assert "goal refused: " in words(arm.said, "compensator")
    arm.peer.more(arm.references)
    assert list(arm.references[-1].position) == before


def test_a_cancelled_goal_leaves_the_arm_where_it_is(arm):
    handle = arm.send([-0.3] * 5, 20.0)
    arm.moving()
    asked = handle.cancel_goal_async()
    arm.peer.until(lambda: asked.done())
    assert arm.result(handle)[0] == CANCELED
    assert arm.rest()[0] > -0.3


def test_a_new_goal_replaces_the_one_under_way(arm):
    first = arm.send([0.3] * 5, 20.0)
    arm.moving()
    second = arm.send([0.0] * 5, 0.8)
    status, result = arm.result(first)
    assert (status, result.error_code) == (ABORTED, INVALID_GOAL)
    assert "replaced by a new goal" in result.error_string
    assert arm.result(second)[0] == SUCCEEDED


def test_a_trajectory_on_the_topic_ends_the_goal_under_way(arm):
    from trunk_ros.nodes.graph.ros import JointTrajectory

    handle = arm.send([0.3] * 5, 20.0)
    arm.moving()
    arm.trajectory.publish(JointTrajectory())
    status, result = arm.result(handle)
    assert status == ABORTED
    assert "empty trajectory" in result.error_string
    assert arm.rest()[0] < 0.3


@pytest.fixture
def stuck(control_msgs, domain, peer):
    """A compensator whose arm does not move, and a client."""
    from trunk_ros.nodes.graph.messages import joint_state
    from trunk_ros.nodes.graph.ros import JointState

    with running("compensator", *PATIENT, domain=domain) as process:
        client = Client(peer)
        client.process = process
        outs = [peer.publisher(JointState, topic) for topic in ("trunk/gearbox_states", "joint_states")]

        def stay():
            now = peer.node.get_clock().now().nanoseconds
            for out in outs if client.alive else outs[1:]:
                out.publish(joint_state(now, JOINTS, np.zeros(5)))

        client.alive = True
        peer.node.create_timer(0.01, stay)
        client.ready()
        yield client


def test_leaving_the_path_or_missing_the_goal_gives_it_up_and_holds(stuck):
    status, result = stuck.result(stuck.send([0.3] * 5, 20.0, path_tolerance=0.05))
    assert (status, result.error_code) == (ABORTED, PATH_TOLERANCE_VIOLATED)
    off = re.search(r"joint_1 is off by ([0-9.]+) rad, more than 0.05 rad", result.error_string)
    assert 0.05 <= float(off.group(1)) < 0.3
    assert stuck.rest()[0] < 0.3

    status, result = stuck.result(stuck.send([0.3] * 5, 0.5, goal_tolerance=0.02, goal_time=1))
    assert (status, result.error_code) == (ABORTED, GOAL_TOLERANCE_VIOLATED)
    assert "1 s after the end joint_1 is off" in result.error_string


def test_without_gearbox_states_the_arm_holds_and_the_goal_is_given_up(stuck):
    handle = stuck.send([0.3] * 5, 60.0)
    stuck.moving()
    stuck.alive = False
    status, result = stuck.result(handle)
    assert status == ABORTED
    assert "no trunk/gearbox_states" in result.error_string
    assert stuck.rest()[0] < 0.3


def test_a_goal_under_way_is_told_that_the_compensator_ends(stuck):
    handle = stuck.send([0.3] * 5, 60.0)
    stuck.moving()
    waited = handle.get_result_async()
    assert not stuck.send([0.9] * 5, 60.0).accepted  # what was asked before has arrived as well
    stuck.process.send_signal(signal.SIGINT)
    stuck.peer.until(lambda: waited.done())
    assert waited.result().status == ABORTED
    assert "was deactivated" in waited.result().result.error_string
    stuck.peer.until(lambda: stuck.process.poll() == 0)
