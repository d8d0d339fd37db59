"""The parameters of the nodes, those of a model aside; quick to import, as ``--help`` prints them."""

from __future__ import annotations

from trunk_ros.parameter import Declaration
from trunk_ros.recording.mcap import COMPRESSION

SIMULATED = "simulated"

COMMON = (
    Declaration("rate", 100.0, "Hz", (1.0, 2000.0), "rate of the node's loop", True),
    Declaration("autostart", True, "", None, "configure and activate the node by itself", True),
    Declaration("supervised", False, "", None, "tell a bringup how far the node is", True),
)
MODEL = Declaration(
    "model", "trunk", "", None, "model file, or a name in config/, for what no parameter says"
)
STREAMS = (
    Declaration(
        "timeout",
        0.5,
        "s",
        (0.01, 60.0),
        "silence after which gearbox_states or a reference are stale",
    ),
    Declaration(
        "patience",
        2.0,
        "s",
        (0.0, 60.0),
        "wait for gearbox_states before what came is refused, or a trajectory begins in open loop",
    ),
    Declaration(
        "open_loop",
        False,
        "",
        None,
        "move the arm unseen, from 0, though joint states come under other names than gearbox_states",
    ),
    Declaration("state_rate", 50.0, "Hz", (0.1, 2000.0), "rate of controller_state at most"),
)
MOTION = (
    Declaration(
        "reversal", 5e-5, "rad", (0.0, 0.1), "a reference that turns back by less keeps its direction"
    ),
    Declaration(
        "max_acceleration", 100.0, "rad/s^2", (0.1, 1e6), "joint acceleration that a trajectory may ask for"
    ),
    Declaration(
        "lead", True, "", None, "let setpoints of a trajectory run ahead by the servo's lag and delay"
    ),
)
GOALS = (
    Declaration(
        "path_tolerance", 0.0, "rad", (0.0, 10.0), "error on the way at which a goal is given up; 0: any"
    ),
    Declaration("goal_tolerance", 0.0, "rad", (0.0, 10.0), "error with which a goal is reached; 0: any"),
    Declaration(
        "stopped_velocity", 0.01, "rad/s", (0.0, 10.0), "speed below which a goal is reached; 0: any"
    ),
    Declaration("goal_time", 0.0, "s", (0.0, 1e4), "time that a goal may take longer; 0: for ever"),
)
FEEDBACK = (
    Declaration("feedback", 0.0, "1/s", (0.0, 5.0), "gain of the slow feedback from joint_states; 0: none"),
    Declaration("feedback_rate", 0.005, "rad/s", (0.0, 0.1), "speed of its correction at most"),
    Declaration("feedback_limit", 0.05, "rad", (0.0, 0.5), "size of its correction at most"),
    Declaration("feedback_tolerance", 5e-4, "rad", (0.0, 0.1), "error that it leaves alone"),
)

PARAMETERS: dict[str, tuple[Declaration, ...]] = {
    "servo_driver": (
        Declaration(
            "timeout",
            0.5,
            "s",
            (0.01, 60.0),
            "silence after which the setpoints are called stale; the arm holds",
        ),
        Declaration(
            "bus", SIMULATED, "", None, "the motors: simulated, or MODULE:CLASS of another bus", True
        ),
        MODEL,
    ),
    "wire_elasticity": (
        Declaration("timeout", 0.5, "s", (0.01, 60.0), "silence after which gearbox_states are called stale"),
        Declaration("base_frame", "", "", None, "frame of tip_pose; by default the arm's base link"),
        Declaration(
            "tf", False, "", None, "publish /tf, where tf2_msgs is installed and nobody else does", True
        ),
        Declaration(
            "frame_prefix", "", "", None, "put in front of base_frame, as robot_state_publisher does"
        ),
        Declaration(
            "publish_description",
            True,
            "",
            None,
            "publish robot_description; false where robot_state_publisher does",
            True,
        ),
        MODEL,
    ),
    "compensator": (*STREAMS, *MOTION, *GOALS, *FEEDBACK, MODEL),
    "recorder": (
        Declaration("output", "", "", None, "folder of the bag; must not exist", True),
        Declaration("topics", [""], "", None, "topics to record; empty: all of the node's namespace", True),
        Declaration("all_namespaces", False, "", None, "record the topics of other namespaces too", True),
        Declaration("exclude", [""], "", None, "topics to leave out", True),
        Declaration("compression", "zstd", "", None, f"of chunks: {', '.join(COMPRESSION)}", True),
        Declaration(
            "chunk_size",
            1.0,
            "MiB",
            (0.001, 64.0),
            "size at which a chunk is closed; every 0.4 s at the latest",
            True,
        ),
        Declaration(
            "buffer_size",
            64.0,
            "MiB",
            (0.1, 4096.0),
            "messages that may wait for the disk; more is counted as loss",
            True,
        ),
        Declaration("depth", 5000, "", (1, 1e6), "messages of a topic that may wait in the middleware", True),
        Declaration(
            "split_size", 0.0, "MiB", (0.0, 1e6), "size at which a new file is begun; 0: never", True
        ),
        Declaration(
            "split_duration", 0.0, "s", (0.0, 1e6), "time after which a new file is begun; 0: never", True
        ),
        Declaration("manifest", "{}", "", None, "JSON about the run, kept in the bag", True),
    ),
    "reality": (
        Declaration("timeout", 0.5, "s", (0.01, 60.0), "silence after which either side is called stale"),
        Declaration("simulation", "", "", None, "model of what the simulator does itself; empty: its ratios"),
        Declaration("lag", 0.0, "s", (0.0, 10.0), "by which the simulator's joints follow a steady command"),
        MODEL,
    ),
    "tip_error": (
        Declaration("predicted", "fitted/trunk/tip_pose", "", None, "topic of the model's tip", True),
    ),
    "watch": (
        Declaration("false_alarms", 0.1, "1/week", (1e-6, 1e3), "false alarms a week of motion, at most"),
        Declaration("before", 120.0, "s", (1.0, 3600.0), "what the bag of a change holds from before it"),
        Declaration("after", 60.0, "s", (1.0, 3600.0), "what it holds from after it"),
        Declaration("output", "changes", "", None, "folder for bags and diagnoses; empty: none are made"),
        Declaration("timeout", 2.0, "s", (0.01, 60.0), "silence after which a topic is called stale"),
        MODEL,
    ),
}
"""What each node has of its own; ``MODEL`` is in it where the node acts by a model."""
