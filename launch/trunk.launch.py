"""Runs the arm: servo_driver, wire_elasticity and compensator, and on request the recorder.

ros2 launch trunk_ros trunk.launch.py model:=found.yaml record:=/tmp/run
"""

import json
import shlex
import sys

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import Command, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "model": ("trunk", "what the compensator believes the arm to be: model file, or a name in config/"),
    "plant_model": ("trunk", "what the simulated arm is: model file, or a name in config/"),
    "simulate": ("true", "false where real motors and sensors speak the topics"),
    "rate": ("100.0", "rate of the nodes' loops [Hz]"),
    "namespace": ("", "pushed in front of all names"),
    "frame_prefix": ("auto", "pushed in front of all frames; auto: the namespace, so that two arms share tf"),
    "setpoints": ("trunk/setpoints", "topic of the motors' setpoints, where your driver has another name"),
    "gearbox_states": ("trunk/gearbox_states", "topic of the motors' angles, likewise"),
    "joint_states": ("joint_states", "topic of the joints' angles, likewise"),
    "use_sim_time": ("false", "take the time from /clock"),
    "composed": ("false", "true: all of these nodes in one process"),
    "record": ("", "folder of a bag to record the namespace into; empty: no recording"),
    "state_publisher": (
        "auto",
        "robot_state_publisher, for RViz and tf: true, false, auto where installed; elsewhere: one is there",
    ),
}
CHOICES = {
    "simulate": ["true", "false"],
    "composed": ["true", "false"],
    "state_publisher": ["true", "false", "auto", "elsewhere"],
}
NAMES = {name: ARGUMENTS[name][0] for name in ("setpoints", "gearbox_states", "joint_states")}
Parameters = dict[str, str | bool]  # of a node
PATIENCE = "30"  # s that a node may take to end in good order, on a busy machine, before it is made to


def generate_launch_description() -> LaunchDescription:
    """All nodes, each in a process of its own unless ``composed``."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description, choices=CHOICES.get(name))
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])


def nodes(context: LaunchContext) -> list[Node]:
    """The nodes that the arguments ask for. One source says what the arm looks like."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    publisher = given["state_publisher"]
    ours = publisher == "true" or (publisher == "auto" and installed("robot_state_publisher"))
    described = state_publisher(given) if ours else []
    parts = simulation(given, not ours and publisher != "elsewhere")
    parts |= {"compensator": {"model": given["model"]}} | recorder(given)
    if given["composed"] == "true":
        return [composed(given, parts), *described]
    return [*(node(given, name, parameters) for name, parameters in parts.items()), *described]


def text(value: str) -> ParameterValue:
    """An argument as it was typed: a bare one would be read as YAML, and 20260101 be a number."""
    return ParameterValue(value, value_type=str)


def composed(given: dict[str, str], parts: dict[str, Parameters]) -> Node:
    """All of them in one process. JSON is YAML that says what is text."""
    rules = [
        f"{name}:{key}:={json.dumps(value)}" for name, own in parts.items() for key, value in own.items()
    ]
    return node(
        given, "compose", {}, [*parts, "--ros-args", *(word for rule in rules for word in ("-p", rule))]
    )


def node(given: dict[str, str], name: str, own: Parameters, arguments: list[str] | None = None) -> Node:
    """One of our nodes. Without it the others are of no use: where it ends, all end."""
    common = {
        "rate": ParameterValue(LaunchConfiguration("rate"), value_type=float),
        "use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool),
    }
    return Node(
        package="trunk_ros",
        executable=name,
        namespace=given["namespace"],
        parameters=[
            common | {key: text(each) if isinstance(each, str) else each for key, each in own.items()}
        ],
        arguments=arguments or [],
        remappings=renamed(given),
        output="screen",
        on_exit=Shutdown(reason=f"{name} has ended: it says above why"),
        sigterm_timeout=PATIENCE,
        sigkill_timeout=PATIENCE,
    )


def renamed(given: dict[str, str]) -> list[tuple[str, str]]:
    """The topics that have other names here."""
    return [(ours, given[name]) for name, ours in NAMES.items() if given[name] != ours]


def simulation(given: dict[str, str], describes: bool) -> dict[str, Parameters]:
    """What stands in for motors, wires and sensors; ``describes``: it publishes robot_description."""
    if given["simulate"] == "false":
        return {}
    model: Parameters = {"model": given["plant_model"]}
    shown = model | {"publish_description": describes, "frame_prefix": frame_prefix(given)}
    return {"servo_driver": model, "wire_elasticity": shown}


def recorder(given: dict[str, str]) -> dict[str, Parameters]:
    """Only where a folder is given."""
    return {"recorder": {"output": given["record"]}} if given["record"] else {}


def frame_prefix(given: dict[str, str]) -> str:
    """Frames have no namespaces of their own."""
    space = given["namespace"].strip("/")
    asked = given["frame_prefix"]
    return asked if asked != "auto" else f"{space}/" if space else ""


def state_publisher(given: dict[str, str]) -> list[Node]:
    """robot_state_publisher: it takes joint_states, and publishes tf and robot_description.

    The arm is the simulated one; where none is, that of the compensator's model.
    """
    model = given["model" if given["simulate"] == "false" else "plant_model"]
    urdf = Command(shlex.join([sys.executable, "-m", "trunk_ros.arm.urdf", model]))
    parameters = {
        "robot_description": ParameterValue(urdf, value_type=str),
        "frame_prefix": text(frame_prefix(given)),
        "use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool),
    }
    return [
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            namespace=given["namespace"],
            parameters=[parameters],
            remappings=renamed(given),
        )
    ]


def installed(package: str) -> bool:
    """Whether the ament index knows a package."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        return False
    return True
