"""MoveIt and ros2_control: files that are for the arm, and the hardware interface as it speaks."""

from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from test.nodes.graph import JOINTS, ROOT, needs_ros, running
from trunk_ros import ros2_control
from trunk_ros.arm.urdf import main, urdf
from trunk_ros.model import load_model

ARM = load_model("trunk").arm
MOVEIT, CONTROL = ROOT / "config" / "moveit", ROOT / "config" / "ros2_control"


def read(path):
    return yaml.safe_load(path.read_text())


def test_moveit_has_the_description_of_the_nominal_arm():
    assert (MOVEIT / "trunk.urdf").read_text() == urdf(ARM)


def test_the_planning_group_its_poses_and_pairs_are_of_the_description():
    robot, semantic = (ElementTree.parse(MOVEIT / f"trunk.{kind}").getroot() for kind in ("urdf", "srdf"))
    links = [link.get("name") for link in robot.findall("link")]
    chain = semantic.find("group/chain")
    assert [chain.get("base_link"), chain.get("tip_link")] == [links[0], links[-1]]
    assert semantic.get("name") == robot.get("name")
    for pose in semantic.findall("group_state"):
        told = {joint.get("name"): float(joint.get("value")) for joint in pose}
        assert list(told) == JOINTS
        assert np.all(np.abs(list(told.values())) < ARM.upper)
    pairs = [{pair.get("link1"), pair.get("link2")} for pair in semantic.findall("disable_collisions")]
    bodies = [link.get("name") for link in robot.findall("link") if link.find("collision") is not None]
    for first, second in pairwise(bodies):
        assert {first, second} in pairs
    assert all(pair <= set(bodies) for pair in pairs)


def test_moveits_limits_are_within_what_the_compensator_takes():
    from trunk_ros.nodes.parameters import MOTION

    most = {each.name: each.default for each in MOTION}["max_acceleration"]
    limits = read(MOVEIT / "joint_limits.yaml")["joint_limits"]
    assert list(limits) == JOINTS
    for joint, top in zip(JOINTS, ARM.v_max * ARM.ratio, strict=True):
        assert limits[joint]["max_velocity"] <= top
        assert limits[joint]["max_acceleration"] <= most


def test_controllers_move_the_arms_joints_through_the_names_that_there_are():
    pytest.importorskip("rclpy")
    from trunk_ros.nodes.control.action import NAME

    moveit = read(MOVEIT / "controllers.yaml")["moveit_simple_controller_manager"]
    (controller,) = moveit["controller_names"]
    assert f"{controller}/{moveit[controller]['action_ns']}" == NAME
    assert moveit[controller]["joints"] == JOINTS
    control = read(CONTROL / "controllers.yaml")["/**"]
    assert control["trunk_controller"]["ros__parameters"]["joints"] == JOINTS
    assert "trunk_controller" in control["controller_manager"]["ros__parameters"]


@pytest.mark.parametrize(("namespace", "prefix"), [("", "/"), ("left", "/left/"), ("/left/", "/left/")])
def test_the_hardware_has_every_joint_and_the_arms_topics(namespace, prefix):
    robot = ElementTree.fromstring(ros2_control.urdf_with_hardware(ARM, namespace, 0.1))
    system = robot.find("ros2_control")
    given = {each.get("name"): each.text for each in system.find("hardware").findall("param")}
    assert given["joint_commands_topic"] == f"{prefix}trunk/reference"
    assert given["joint_states_topic"] == f"{prefix}joint_states"
    assert system.find("hardware/plugin").text == "topic_based_ros2_control/TopicBasedSystem"
    assert [joint.get("name") for joint in system.findall("joint")] == JOINTS
    for joint in system.findall("joint"):
        assert joint.find("state_interface/param").text == "0.1"
        interfaces = {each.tag: each.get("name") for each in joint if each.tag == "command_interface"}
        assert interfaces == {"command_interface": "position"}


@pytest.mark.parametrize("program", [main, ros2_control.main])
def test_a_model_for_any_joints_has_no_description(program, capsys):
    assert program(["direct"]) == 2
    assert "needs their names" in capsys.readouterr().err


@needs_ros
def test_what_the_hardware_interface_sends_moves_the_arm_and_comes_back(domain, peer):
    """As TopicBasedSystem speaks: depth 1, all joints, only while they differ from the states."""
    from trunk_ros.nodes.graph.ros import JointState, QoSProfile, ReliabilityPolicy

    commands = peer.node.create_publisher(JointState, "trunk/reference", QoSProfile(depth=1))
    sensor = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    states = []
    peer.node.create_subscription(JointState, "joint_states", states.append, sensor)
    goal = np.array([0.1, -0.1, 0.05, 0.0, 0.2])

    def write():
        if states and np.abs(np.asarray(states[-1].position) - goal).sum() > ros2_control.QUIET:
            message = JointState(name=JOINTS, position=goal.tolist())
            message.header.stamp = peer.now()
            commands.publish(message)

    with (
        running("servo_driver", domain=domain),
        running("wire_elasticity", domain=domain),
        running("compensator", domain=domain),
    ):
        peer.until(lambda: write() or (states and np.abs(np.array(states[-1].position) - goal).max() < 1e-3))
