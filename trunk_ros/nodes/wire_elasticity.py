"""wire_elasticity: gearbox angle to joint reading, wire elongation and tension, tip pose."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.arm.urdf import urdf
from trunk_ros.chain import Chain, State
from trunk_ros.model import Declaration
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.elapsed import SECOND, Elapsed
from trunk_ros.nodes.graph.frames import FrameStream
from trunk_ros.nodes.graph.joints import JointMatcher, MessageError
from trunk_ros.nodes.graph.messages import fill_pose, nanoseconds
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.qos import LATCHED
from trunk_ros.nodes.graph.ros import JointState, PoseStamped, String
from trunk_ros.trajectory import Array

RESTART = SECOND  # ns that a stamp may be before the last one; more is a clock that was set back


class WireElasticity(TrunkNode):
    """One sample in, one sample out with the same stamp."""

    NAME = "wire_elasticity"
    idle = True
    OWN = (
        Declaration("timeout", 0.5, "s", (0.01, 60.0), "silence after which gearbox_states are called stale"),
        Declaration("base_frame", "", "", None, "frame of tip_pose; by default the arm's base link"),
        Declaration("tf", False, "", None, "publish /tf, where tf2_msgs is installed and nobody else does"),
    )

    def configure(self) -> None:
        """Create the chains and the streams."""
        arm = self.model.arm
        self.joints = arm.joints
        self.motors = arm.motor_names
        self.zero = self.model.effects.get("zero_offset", {}).get("offset", 0.0)
        self.wires = [f"wire_{number}" for number in range(1, len(arm.joints) + 1)]
        self.matcher = JointMatcher(self.motors)
        self.restart()
        still = np.zeros((2, len(arm.joints)))
        self.wire.run(still, np.arange(2.0) / 100)  # compiles, so that no sample is late
        self.publish_joints = self.joint_states_on("joint_states", self.joints)
        self.publish_wires = self.joint_states_on("trunk/wire_states", self.wires)
        self.publish_tip = self.publish_on(PoseStamped, "trunk/tip_pose")
        self.pose = PoseStamped()
        self.base_frame = self.value("base_frame") or arm.base_link
        self.frames = FrameStream(self, arm) if self.value("tf") else None
        self.publish_on(String, "robot_description", LATCHED)(String(data=urdf(arm)))
        self.gearbox = self.watch("trunk/gearbox_states", self.value("timeout"))
        self.listen_to(JointState, "trunk/gearbox_states", self.on_gearbox)

    def restart(self) -> None:
        """Begin with no memory, the play at its centre."""
        self.wire, self.tip = (Chain(self.model, stage, hold_time=True) for stage in ("wire", "arm"))
        self.state: State | None = None
        self.seen: State | None = None
        self.elapsed = Elapsed()
        self.last: tuple[int, Array] | None = None
        self.phi = np.full(len(self.joints), np.nan)

    def on_gearbox(self, message: Any) -> None:
        """Pass one sample through the wire. Raises MessageError for one that cannot be used."""
        now = nanoseconds(message.header.stamp)
        self.heard(self.gearbox, now)
        phi = self.complete(message)
        if self.last is not None and now <= self.last[0]:
            if self.last[0] - now < RESTART:
                raise MessageError("gearbox_states out of order: a sample was left out")
            self.health.note("the stamps of gearbox_states jumped back")
            self.last = None
        self.publish_all(now, phi, message)

    def complete(self, message: Any) -> Array:
        """Gearbox angles (joints,) rad; joints that the message leaves out keep their last angle."""
        phi = self.matcher.gather(message.name, message.position)
        for oddity in self.matcher.oddities():
            self.health.note(oddity)
        known = np.isfinite(phi)
        phi = phi if known.all() else np.where(known, phi, self.phi)
        if not known.all() and not np.isfinite(phi).all():
            raise MessageError(f"no angle yet of {self.motors[int(np.argmin(np.isfinite(phi)))]}")
        self.phi = phi
        return phi

    def publish_all(self, now: int, phi: Array, message: Any) -> None:
        """Publish the joints, the wires and the tip at ``now`` ns."""
        stamp = np.array([self.elapsed.at(now)])
        (shown,), self.state = self.wire.run(phi[None], stamp, self.state)
        theta = self.state.angles + self.zero  # where the joints are, not what late sensors show
        effort = -self.wire.arm.load(theta[None])[0]
        self.publish_joints(now, shown, self.speed(now, shown), effort)
        self.last = now, shown
        if self.model.arm.wire is not None:
            stretch, tension = wire_state(self.model.arm, phi, self.state.angles, effort)
            self.publish_wires(now, stretch, None, tension)
        if self.model.arm.has_geometry:
            (tip,), self.seen = self.tip.run(theta[None], stamp, self.seen)
            self.publish_tip(fill_pose(self.pose, now, self.base_frame, tip))
        if self.frames is not None:
            self.frames.publish(now, theta)

    def speed(self, now: int, shown: Array) -> Array:
        """Speed of the joint readings (joints,) rad/s since the last sample."""
        if self.last is None:
            return np.zeros_like(shown)
        return (shown - self.last[1]) * SECOND / (now - self.last[0])


def wire_state(arm: Any, phi: Array, theta: Array, effort: Array) -> tuple[Array, Array]:
    """Elongation [m] and tension [N] of the wires (joints,): lag of the joint, and pull plus load.

    ``theta``: joint angles [rad] from the gearbox's zero, since zeros that differ stretch no wire.
    """
    stretch = arm.wire.cylinder_radius * (arm.driven(phi) - theta)
    return stretch, arm.wire.pull_tension + np.abs(effort) / arm.wire.cylinder_radius


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(WireElasticity, argv)
