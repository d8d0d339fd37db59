"""The compensator's own parameters."""

from __future__ import annotations

from typing import Any

from trunk_ros.model import Declaration
from trunk_ros.nodes.control import slow_feedback
from trunk_ros.nodes.control.controller import Settings

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
        "wait for gearbox_states before a trajectory is refused, or begins at 0 where nobody publishes them",
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
    Declaration("lead", True, "", None, "let setpoints of a trajectory run ahead by the servo's lag"),
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
OWN = (*STREAMS, *MOTION, *GOALS, *FEEDBACK)


def settings_of(node: Any) -> Settings:
    """What the parameters say of the control."""
    names = ("reversal", "max_acceleration", "patience", "lead")
    feedback = slow_feedback.Settings(*[node.value(each.name) for each in FEEDBACK])
    return Settings(**{name: node.value(name) for name in names}, feedback=feedback)
