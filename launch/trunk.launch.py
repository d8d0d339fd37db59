"""Runs the arm: servo_driver, wire_elasticity and compensator, and on request the recorder.

ros2 launch trunk_ros trunk.launch.py model:=found.yaml record:=/tmp/run
"""

import shlex
import sys

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import Command, LaunchConfiguration, NotEqualsSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "model": ("trunk", "what the compensator believes the arm to be: model file, or a name in config/"),
    "plant_model": ("trunk", "what the simulated arm is: model file, or a name in config/"),
    "simulate": ("true", "false where real motors and sensors speak the topics"),
    "rate": ("100.0", "rate of the nodes' loops [Hz]"),
    "namespace": ("", "pushed in front of all names"),
    "use_sim_time": ("false", "take the time from /clock"),
    "record": ("", "folder of a bag to record everything into; empty: no recording"),
    "state_publisher": ("auto", "robot_state_publisher, for RViz and tf: true, false, auto where installed"),
}


def generate_launch_description() -> LaunchDescription:
    """All nodes, each in a process of its own."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    publisher = OpaqueFunction(function=state_publisher)
    return LaunchDescription([*declared, *simulation(), compensator(), recorder(), publisher])


def common() -> dict[str, object]:
    """Parameters of every node."""
    return {
        "rate": ParameterValue(LaunchConfiguration("rate"), value_type=float),
        "use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool),
    }


def text(name: str) -> ParameterValue:
    """An argument as it was typed: a bare one would be read as YAML, and 20260101 be a number."""
    return ParameterValue(LaunchConfiguration(name), value_type=str)


def node(name: str, parameters: dict[str, object], **options: object) -> Node:
    """One of our nodes."""
    return Node(
        package="trunk_ros",
        executable=name,
        namespace=LaunchConfiguration("namespace"),
        parameters=[common() | parameters],
        output="screen",
        **options,
    )


def simulation() -> list[Node]:
    """What stands in for motors, wires and sensors."""
    wanted = IfCondition(LaunchConfiguration("simulate"))
    model = {"model": text("plant_model")}
    return [node(name, model, condition=wanted) for name in ("servo_driver", "wire_elasticity")]


def compensator() -> Node:
    """The model run backward."""
    return node("compensator", {"model": text("model")})


def recorder() -> Node:
    """Only where a folder is given."""
    wanted = IfCondition(NotEqualsSubstitution(LaunchConfiguration("record"), ""))
    return node("recorder", {"output": text("record")}, condition=wanted)


def state_publisher(context: LaunchContext) -> list[Node]:
    """robot_state_publisher, where it is wanted: it takes joint_states and robot_description's text.

    The arm is that of the compensator's model: without a simulation nobody gives ``plant_model``.
    """
    wanted = LaunchConfiguration("state_publisher").perform(context)
    if wanted == "false" or (wanted == "auto" and not installed("robot_state_publisher")):
        return []
    model = LaunchConfiguration("model").perform(context)
    urdf = Command(shlex.join([sys.executable, "-m", "trunk_ros.arm.urdf", model]))
    publisher = Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            {
                "robot_description": ParameterValue(urdf, value_type=str),
                "use_sim_time": common()["use_sim_time"],
            }
        ],
    )
    return [publisher]


def installed(package: str) -> bool:
    """Whether the ament index knows a package."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        return False
    return True
