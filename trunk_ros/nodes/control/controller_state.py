"""What the compensator does, for others to watch: reference, feedback, error, output.

One control_msgs/JointTrajectoryControllerState where control_msgs is installed, else one JointState for each
of the four, below the same name.
"""

from __future__ import annotations

from typing import Any

from trunk_ros.nodes.control.goal import State
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.messages import joint_state, point, time_message
from trunk_ros.nodes.graph.ros import JointState, JointTrajectoryControllerState

NAME = "trunk/controller_state"
PARTS = ("reference", "feedback", "error", "output")


class ControllerState:
    """Publishes at most ``rate`` times a second; ``output`` is the setpoint (joints,) rad at the gearbox."""

    def __init__(self, streams: Any, joints: tuple[str, ...], rate: float):
        self.joints = list(joints)
        self.rate = rate
        self.last: int | None = None
        self.whole: Any = None
        if JointTrajectoryControllerState is not None:
            self.whole = streams.publish(JointTrajectoryControllerState, NAME)
        else:
            self.parts = [streams.publish(JointState, f"{NAME}/{part}") for part in PARTS]

    def due(self, now: int) -> bool:
        """Whether it is time to publish."""
        return self.last is None or not 0 <= now - self.last < SECOND / self.rate

    def tick(self, now: int, wanted: State, actual: State, output: Any) -> None:
        """Publish what holds at ``now`` ns if it is time to."""
        if not self.due(now):
            return
        self.last = now
        states = (wanted, actual, wanted.minus(actual))
        if self.whole is not None:
            message = JointTrajectoryControllerState(joint_names=self.joints)
            if hasattr(message, "speed_scaling_factor"):  # from control_msgs 5.3 on
                message.speed_scaling_factor = 1.0
            message.header.stamp = time_message(now)
            message.reference, message.feedback, message.error = map(point, states)
            message.output = point(State(output, output[:0]))
            self.whole(message)
            return
        for publish, state in zip(self.parts, states, strict=False):
            publish(joint_state(now, self.joints, state.position, state.velocity))
        self.parts[-1](joint_state(now, self.joints, output))
