"""RViz with the arm, two ghosts of it, and the tip's path coloured by its distance from the fitted one's.

ros2 launch trunk_ros rviz.launch.py fitted:=found.yaml
Beside trunk.launch.py or a replayed bag; needs rviz2, robot_state_publisher and tf2_ros. The ghosts take the
arm's gearbox angles: they are what the nominal and the fitted model make of them.
"""

import shlex
import sys
from pathlib import Path

from launch.actions import DeclareLaunchArgument
from launch.substitutions import Command, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription

CONFIG = Path(__file__).resolve().parent.parent / "config" / "trunk.rviz"
ARGUMENTS = {
    "nominal": ("trunk", "model of the first ghost: file, or a name in config/"),
    "fitted": ("trunk", "model of the second ghost, such as a diagnosis' model.yaml"),
    "use_sim_time": ("false", "take the time from /clock, as beside a replayed bag"),
}
GHOSTS = ("nominal", "fitted")


def generate_launch_description() -> LaunchDescription:
    """The ghosts, their frames, and RViz."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    ghosts = [part for name in GHOSTS for part in ghost(name)]
    error = node("trunk_ros", "tip_error", {})
    viewer = node("rviz2", "rviz2", {}, arguments=["-d", str(CONFIG)])
    return LaunchDescription([*declared, *ghosts, error, viewer])


def node(package: str, executable: str, parameters: dict[str, object], **options: object) -> Node:
    """A node on the time that was asked for."""
    time = {"use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)}
    return Node(package=package, executable=executable, parameters=[time | parameters], **options)


def ghost(name: str) -> list[Node]:
    """A model of the wire in a namespace of its own, its frames, and where they are."""
    model = {"model": ParameterValue(LaunchConfiguration(name), value_type=str)}
    frames = {"frame_prefix": ParameterValue(f"{name}/", value_type=str)}
    gearbox = [("trunk/gearbox_states", "/trunk/gearbox_states")]
    program = f"{shlex.quote(sys.executable)} -m trunk_ros.arm.urdf '"
    urdf = ParameterValue(Command([program, LaunchConfiguration(name), "'"]), value_type=str)
    quiet = {"publish_description": False}
    return [
        node("trunk_ros", "wire_elasticity", model | frames | quiet, namespace=name, remappings=gearbox),
        node(
            "robot_state_publisher",
            "robot_state_publisher",
            {"robot_description": urdf} | frames,
            namespace=name,
        ),
        Node(
            package="tf2_ros",
            executable="static_transform_publisher",
            name=f"{name}_base",
            arguments=["--frame-id", "base_link", "--child-frame-id", f"{name}/base_link"],
        ),
    ]
