"""wire_elasticity: gearbox angle to joint reading, wire elongation and tension, tip pose."""

from __future__ import annotations

from typing import Any

from trunk_ros.arm.urdf import urdf
from trunk_ros.model import Model
from trunk_ros.nodes.arm.wire import Wire
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.frames import FrameStream
from trunk_ros.nodes.graph.messages import fill_pose, nanoseconds
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.qos import LATCHED
from trunk_ros.nodes.graph.ros import PoseStamped, String
from trunk_ros.nodes.parameters import PARAMETERS


class WireElasticity(TrunkNode):
    """One sample in, one sample out with the same stamp."""

    NAME = "wire_elasticity"
    idle = True
    OWN = PARAMETERS[NAME]
    wire: Wire | None = None

    def configure(self) -> None:
        """Create the model and the streams."""
        arm = self.model.arm
        self.wire = Wire(self.model)
        wires = [f"wire_{number}" for number in range(1, len(arm.joints) + 1)]
        self.publish_joints = self.streams.publish_joints("joint_states", arm.joints)
        self.publish_wires = self.streams.publish_joints("trunk/wire_states", wires)
        self.publish_tip = self.streams.publish(PoseStamped, "trunk/tip_pose")
        self.pose = PoseStamped()
        self.base_frame = self.value("base_frame") or arm.base_link
        self.frames = FrameStream(self.streams, arm) if self.value("tf") else None
        if self.value("publish_description"):
            self.streams.publish(String, "robot_description", LATCHED)(String(data=urdf(arm)))
        self.gearbox = self.streams.watch("trunk/gearbox_states", self.value("timeout"))
        self.streams.sense("trunk/gearbox_states", self.on_gearbox)

    def use(self, model: Model) -> None:
        """The simulated arm changes."""
        super().use(model)
        if self.wire is not None:
            self.wire.swap(model)

    def on_gearbox(self, message: Any) -> None:
        """Pass one sample through the wire. Raises MessageError for one that cannot be used."""
        assert self.wire is not None
        now = nanoseconds(message.header.stamp)
        self.streams.heard(self.gearbox, now)
        phi = self.wire.complete(message.name, message.position)
        for oddity in self.wire.matcher.oddities():
            self.health.note(oddity)
        if self.wire.begins_anew(now):
            self.health.note("the stamps of gearbox_states jumped back")
        shown = self.wire.update(now, phi)
        self.publish_joints(now, shown.joints, shown.velocity, shown.effort)
        if shown.wires is not None:
            self.publish_wires(now, shown.wires[0], None, shown.wires[1])
        if shown.tip is not None:
            frame = self.value("frame_prefix") + self.base_frame
            self.publish_tip(fill_pose(self.pose, now, frame, shown.tip))
        if self.frames is not None:
            self.frames.publish(now, shown.true, self.value("frame_prefix"))


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(WireElasticity, argv)
