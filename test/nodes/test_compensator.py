"""compensator over DDS: trajectories, foreign references, models that change while it runs."""

import time
from dataclasses import replace

import numpy as np
import pytest

from test.nodes.graph import (
    JOINTS,
    hears,
    needs_ros,
    rests,
    running,
    seconds,
    values,
    words,
)
from trunk_ros.model import load_model, save_model
from trunk_ros.nodes.control.compensation import FADE

pytestmark = needs_ros
UNSEEN = ("--ros-args", "-p", "open_loop:=true")  # nobody plays the motors


@pytest.fixture
def graph(peer):
    """The test's ends of the compensator's topics."""
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState, JointTrajectory

    class Ends:
        reference = peer.publisher(JointState, "trunk/reference")
        trajectory = peer.publisher(JointTrajectory, "trunk/joint_trajectory")
        references = peer.listen(JointState, "trunk/reference")
        setpoints = peer.listen(JointState, "trunk/setpoints")
        said = peer.listen(DiagnosticArray, "diagnostics")

        @staticmethod
        def ask(positions, joints=JOINTS):
            message = JointState(name=list(joints), position=[float(angle) for angle in positions])
            message.header.stamp = peer.now()
            Ends.reference.publish(message)

        @staticmethod
        def meet():
            peer.meets(Ends.reference, Ends.trajectory, node="compensator")

    return Ends


def test_a_foreign_reference_comes_out_as_the_model_run_backward(domain, peer, graph):
    with running("compensator", *UNSEEN, domain=domain):
        graph.meet()
        graph.ask([0.0] * 5)
        peer.until(lambda: graph.setpoints)
        graph.ask([0.03] * 5)
        arm = load_model("trunk").arm
        wanted = (0.03 + arm.dead_band) / arm.ratio
        peer.until(lambda: np.allclose(graph.setpoints[-1].position, wanted, rtol=0, atol=1e-9))
        graph.ask([0.02], joints=["joint_4"])
        wanted[3] = (0.02 - arm.dead_band[3]) / arm.ratio[3]
        peer.until(lambda: np.allclose(graph.setpoints[-1].position, wanted, rtol=0, atol=1e-9))
        graph.ask([0.5], joints=["joint_2"])
        told = "reference refused: joint_2 at 0.5000 rad is outside -0.4014 ... 0.4014"
        peer.until(lambda: told in words(graph.said, "compensator"))
        peer.more(graph.setpoints)
        np.testing.assert_allclose(graph.setpoints[-1].position, wanted, atol=1e-9)


def test_trajectories_are_followed_stopped_and_refused_as_joint_trajectory_controller_does(
    domain, peer, graph
):
    from trunk_ros.nodes.graph.messages import trajectory_message
    from trunk_ros.nodes.graph.ros import JointTrajectory
    from trunk_ros.trajectory import Trajectory

    def send(angle, time, joints=("joint_2",)):
        points = np.full((1, len(joints)), angle)
        graph.trajectory.publish(trajectory_message(Trajectory(joints, np.array([time]), points)))

    patient = ("--ros-args", "-p", "timeout:=10.0", "-p", "patience:=60.0")
    with running("compensator", *patient, domain=domain):
        graph.meet()
        send(0.2, 0.5)  # before there is a driver: it waits for one
        with running("servo_driver", domain=domain):
            peer.until(lambda: graph.references and graph.references[-1].position[1] == 0.2)
            assert graph.references[-1].position[0] == 0.0
            peer.until(lambda: hears(graph.said, "compensator", "trunk/gearbox_states"))
            told = "trajectory refused: joint_2 would reach"
            peer.until(lambda: told in words(graph.said, "compensator") or send(0.9, 0.5))
            peer.more(graph.references)
            assert graph.references[-1].position[1] == 0.2
            send(-0.2, 20.0)
            peer.until(lambda: graph.references[-1].position[1] < 0.18)
            graph.trajectory.publish(JointTrajectory())
            peer.until(lambda: rests(graph.references))
            assert -0.2 < graph.references[-1].position[1] < 0.18
    at = [seconds(message.header.stamp) for message in graph.setpoints]
    way = np.abs(np.diff([message.position[1] for message in graph.setpoints]))
    assert (way <= 1.5 * np.diff(at) + 1e-6).all()


def test_in_open_loop_a_trajectory_begins_at_0_where_after_patience_nobody_is(domain, peer, graph):
    from trunk_ros.nodes.graph.messages import trajectory_message
    from trunk_ros.trajectory import Trajectory

    path = Trajectory(tuple(JOINTS), np.array([0.5]), np.full((1, 5), 0.1))
    with running("compensator", *UNSEEN, "-p", "patience:=1.0", domain=domain):
        graph.meet()
        sent = peer.now()
        graph.trajectory.publish(trajectory_message(path))
        peer.until(lambda: graph.references and graph.references[-1].position[0] == 0.1)
    assert list(graph.setpoints[0].position) == [0.0] * 5
    assert seconds(graph.references[0].header.stamp) > seconds(sent) + 1.0


def test_a_model_is_swapped_without_a_jump_and_another_arms_is_refused(domain, peer, graph, tmp_path):
    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import ParameterType, ParameterValue
    from rcl_interfaces.srv import SetParameters

    loose, other = tmp_path / "loose.yaml", tmp_path / "other.yaml"
    model = load_model("trunk")
    save_model(replace(model, effects={"backlash": {"half_width": np.full(5, 5e-3)}}), loose)
    save_model(replace(model, arm=replace(model.arm, upper=np.full(5, 0.2))), other)
    service = peer.node.create_client(SetParameters, "compensator/set_parameters")

    def load(path):
        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=str(path))
        asked = SetParameters.Request(parameters=[ParameterMessage(name="model", value=value)])
        return peer.call(service, asked).results[0]

    def reached(wanted, off):
        return graph.setpoints and np.allclose(graph.setpoints[-1].position, wanted, rtol=0, atol=off)

    arm = model.arm
    with running("compensator", *UNSEEN, domain=domain):
        graph.meet()
        graph.ask([0.0] * 5)
        peer.until(lambda: graph.setpoints)
        graph.ask([0.1] * 5)
        peer.until(lambda: reached((0.1 + arm.dead_band) / arm.ratio, 1e-9))
        before = np.asarray(graph.setpoints[-1].position)
        refused = load(other)
        assert not refused.successful
        assert "upper is not that of the running arm" in refused.reason
        assert load(loose).successful
        graph.ask([0.101] * 5)
        peer.until(lambda: reached((0.101 + arm.dead_band + 5e-3) / arm.ratio, 1e-4))
    path = np.array([message.position for message in graph.setpoints])
    at = np.array([seconds(message.header.stamp) for message in graph.setpoints])
    since = np.argmax((path == before).all(axis=1))
    late = np.diff(at[since:]) + 0.05  # s: stamps are not when it was sent to the microsecond
    most = (1e-3 + 5e-3 * (1.0 - np.exp(-late / FADE))) / arm.ratio.min()
    assert (np.abs(np.diff(path[since:], axis=0)).max(axis=1) < most).all()


def test_a_state_stamped_by_another_clock_counts_from_its_arrival(domain, peer, graph):
    from trunk_ros.nodes.graph.messages import joint_state, nanoseconds
    from trunk_ros.nodes.graph.ros import JointState, JointTrajectoryControllerState

    hour = 3600 * 10**9
    shown = peer.listen(JointState, "trunk/controller_state/feedback")
    if JointTrajectoryControllerState:  # another test may have built it: the node itself need not have it
        whole = peer.listen(JointTrajectoryControllerState, "trunk/controller_state")
    else:
        whole = []
    joints = peer.publisher(JointState, "joint_states")
    with running("compensator", *UNSEEN, domain=domain):
        graph.meet()
        peer.meets(joints, node="compensator")
        graph.ask([0.0] * 5)
        peer.until(lambda: graph.setpoints)
        peer.until(
            lambda: (
                joints.publish(joint_state(time.time_ns() - hour, JOINTS, np.full(5, 0.25)))
                or "joint_states is stamped more than a second behind the clock: taken as now"
                in words(graph.said, "compensator")
            )
        )
        peer.until(lambda: shown or whole)
    seen = [nanoseconds(message.header.stamp) for message in shown + whole]
    assert min(seen) > time.time_ns() - hour // 2


def test_a_params_file_is_the_complete_model(domain, peer, graph, tmp_path):
    found = replace(load_model("trunk"), effects={"backlash": {"half_width": np.full(5, 5e-3)}})
    save_model(found, tmp_path / "model.yaml")
    arguments = ("--ros-args", "--params-file", tmp_path / "model.yaml")
    with running("compensator", *arguments, domain=domain):
        peer.until(lambda: graph.said)
    assert values(graph.said, "compensator")["model"] == found.hash()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--nonsense"], "unknown argument '--nonsense'"),
        (["--ros-args", "--nonsense"], "bad ROS arguments"),
        (["--ros-args", "-p", "model:=nowhere"], "nowhere"),
        (["--ros-args", "-p", "rate:=0.0"], "rate"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(command, arguments, told):
    done = command("compensator", *arguments)
    assert done.returncode == 2
    assert told in done.stderr
    assert len(done.stderr.splitlines()) == 1, done.stderr
