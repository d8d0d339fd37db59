"""servo_driver: setpoints in, state of the gearbox shafts out; the motors sit behind a bus."""

from __future__ import annotations

from typing import Any

from trunk_ros.nodes.arm.servo import Servo
from trunk_ros.nodes.bus import bus_of
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.ros import JointState
from trunk_ros.nodes.parameters import PARAMETERS


class ServoDriver(TrunkNode):
    """Refuses setpoints outside the limits, holding the last safe one; holds as well when they dry up."""

    NAME = "servo_driver"
    fixed_model = True
    OWN = PARAMETERS[NAME]
    servo: Servo | None = None

    def configure(self) -> None:
        """Open the bus and the streams."""
        arm = self.model.arm
        self.servo = Servo(arm, bus_of(self.value("bus"), self.model))
        self.setpoints = self.streams.watch("trunk/setpoints", self.value("timeout"))
        self.publish_state = self.streams.publish_joints("trunk/gearbox_states", arm.motor_names)
        self.streams.obey(JointState, "trunk/setpoints", self.on_setpoints)

    def tick(self, now: int) -> None:
        """Read the shafts and publish."""
        assert self.servo is not None
        sample = self.servo.update(now)
        self.publish_state(now, sample.position, sample.velocity, sample.effort)

    def on_setpoints(self, message: Any) -> None:
        """Hand a setpoint on. Raises MessageError where it is refused."""
        assert self.servo is not None
        stamp = self.streams.arrived(self.setpoints, message)
        for oddity in self.servo.ask(message.name, message.position, stamp):
            self.health.note(oddity)

    def release(self) -> None:
        """Close the bus."""
        if self.servo is not None:
            servo, self.servo = self.servo, None
            servo.bus.close()


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(ServoDriver, argv)
