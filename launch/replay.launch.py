"""Replays a bag, by itself or through the simulated wire.

ros2 launch trunk_ros replay.launch.py bag:=/tmp/run rate:=2.0
"""

from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription

ARGUMENTS = {
    "bag": (None, "rosbag2 folder or file"),
    "rate": ("1.0", "so many times as fast as recorded"),
    "clock": ("100.0", "rate of /clock [Hz]"),
    "from_time": ("0", "begin there: s since the start, or % of the bag"),
    "until": ("100%", "end there: s since the start, or % of the bag"),
    "wire": ("false", "start wire_elasticity: it answers to the replayed gearbox_states, under simulated/"),
    "model": ("trunk", "model of the wire: file, or a name in config/"),
}


def generate_launch_description() -> LaunchDescription:
    """replay, and on request wire_elasticity on the replayed time."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    options = {"--rate": "rate", "--clock": "clock", "--from-time": "from_time", "--until": "until"}
    arguments = [word for option, name in options.items() for word in (option, LaunchConfiguration(name))]
    player = Node(
        package="trunk_ros",
        executable="replay",
        arguments=[LaunchConfiguration("bag"), *arguments],
        output="screen",
    )
    wire = Node(
        package="trunk_ros",
        executable="wire_elasticity",
        namespace="simulated",  # apart from what the bag holds of the same topics
        remappings=[("trunk/gearbox_states", "/trunk/gearbox_states")],
        parameters=[
            {
                "model": ParameterValue(LaunchConfiguration("model"), value_type=str),
                "use_sim_time": True,
            }
        ],
        condition=IfCondition(LaunchConfiguration("wire")),
    )
    return LaunchDescription([*declared, player, wire])
