"""The simulated arm under ros2_control: a controller_manager with a joint_trajectory_controller commands it.

ros2 launch trunk_ros ros2_control.launch.py
Needs topic_based_ros2_control, controller_manager, joint_trajectory_controller and robot_state_publisher.
"""

import shlex
import sys
from pathlib import Path

from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, Shutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue

from launch import LaunchDescription

HERE = Path(__file__).resolve().parent
CONFIG = HERE.parent / "config" / "ros2_control"
ARGUMENTS = {
    "model": ("trunk", "what the compensator believes the arm to be: model file, or a name in config/"),
    "plant_model": ("trunk", "what the simulated arm is: model file, or a name in config/"),
    "simulate": ("true", "false where real motors and sensors speak the topics"),
    "controllers": ("controllers.yaml", "the manager's parameters: file, or one in config/ros2_control"),
}


def generate_launch_description() -> LaunchDescription:
    """The arm, and the controller_manager that takes it for its hardware."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    passed = {name: LaunchConfiguration(name) for name in ("model", "plant_model", "simulate")}
    arm = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(HERE / "trunk.launch.py")),
        launch_arguments=(passed | {"state_publisher": "elsewhere"}).items(),
    )
    return LaunchDescription([*declared, arm, description(), manager(), spawner()])


def description() -> Node:
    """The one source of robot_description, which the controller_manager waits for."""
    program = f"{shlex.quote(sys.executable)} -m trunk_ros.ros2_control '"
    urdf = Command([program, LaunchConfiguration("plant_model"), "'"])
    return Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        parameters=[{"robot_description": ParameterValue(urdf, value_type=str)}],
    )


def manager() -> Node:
    """ros2_control's node; without it there is nobody to command."""
    file = PathJoinSubstitution([str(CONFIG), LaunchConfiguration("controllers")])
    return Node(
        package="controller_manager",
        executable="ros2_control_node",
        parameters=[ParameterFile(file)],
        output="screen",
        on_exit=Shutdown(reason="the controller_manager has ended"),
    )


def spawner() -> Node:
    """Loads and activates the controller."""
    return Node(package="controller_manager", executable="spawner", arguments=["trunk_controller"])
