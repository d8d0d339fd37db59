"""reality: between a simulator and its controllers, adds what the simulator lacks of the arm."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.export.reality import RealityLayer
from trunk_ros.model import Model, load_model
from trunk_ros.nodes.bus import gearbox_limits
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.joints import JointMatcher, MessageError
from trunk_ros.nodes.graph.messages import nanoseconds
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.ros import JointState
from trunk_ros.nodes.parameters import PARAMETERS
from trunk_ros.trajectory import Array

FIRST = 0.01  # s that pass with the first of the simulator's states
LONGEST = 1.0  # s between two of them; after a longer silence, or a step back in time, the layer begins anew


class Reality(TrunkNode):
    """A step with each of the simulator's states: ``trunk/setpoints`` go to ``simulator/setpoints``, and
    ``simulator/joint_states`` to ``joint_states``, both with what ``model`` adds.
    """

    NAME = "reality"
    idle = True
    layer: RealityLayer | None = None
    OWN = PARAMETERS[NAME]

    def configure(self) -> None:
        """Create the layer and the streams. Raises TrunkError where the model cannot be added."""
        arm = self.model.arm
        self.joints = arm.joints
        self.lower, self.upper = gearbox_limits(arm)
        theirs = self.value("simulation")
        simulation = load_model(theirs) if theirs else None
        self.simulation = simulation
        self.layer = self.layered(self.model)
        self.asking, self.showing = JointMatcher(self.joints), JointMatcher(self.joints)
        self.asked = np.full(len(self.joints), np.nan)
        self.state = np.full(len(self.joints), np.nan)
        self.last: tuple[int, Array] | None = None
        self.setpoints = self.streams.watch("trunk/setpoints", self.value("timeout"))
        self.states = self.streams.watch("simulator/joint_states", self.value("timeout"))
        self.publish_setpoints = self.streams.publish_joints("simulator/setpoints", self.joints)
        self.publish_joints = self.streams.publish_joints("joint_states", self.joints)
        self.streams.obey(JointState, "trunk/setpoints", self.on_setpoints)
        self.streams.sense("simulator/joint_states", self.on_states)

    def layered(self, model: Model) -> RealityLayer:
        """What is added, compiled, so that no sample is late."""
        layer = RealityLayer(model, 1, self.simulation, self.value("lag"))
        for remark in layer.remarks:
            self.health.note(remark)
        still = np.zeros(len(self.joints))
        layer.step(still, still, FIRST)
        layer.reset()
        return layer

    def use(self, model: Model) -> None:
        """Another model of the arm: its memory begins anew."""
        super().use(model)
        if self.layer is not None:
            self.layer = self.layered(model)

    def on_setpoints(self, message: Any) -> None:
        """Keep a command for the next step. Raises MessageError where it is refused."""
        self.streams.arrived(self.setpoints, message)
        given = self.asking.gather(message.name, message.position)
        named = [joint not in self.asking.missing for joint in self.joints]
        if not np.isfinite(given[named]).all():
            raise MessageError("setpoint refused: it holds a value that is no number")
        self.asked = np.where(named, given, self.asked)

    def on_states(self, message: Any) -> None:
        """One step. Raises MessageError for a state that cannot be used."""
        now = nanoseconds(message.header.stamp)
        self.streams.heard(self.states, now)
        given = self.showing.gather(message.name, message.position)
        self.state = np.where(np.isfinite(given), given, self.state)
        if not np.isfinite(self.state).all():
            raise MessageError(f"no angle yet of {self.joints[int(np.argmin(np.isfinite(self.state)))]}")
        assert self.layer is not None
        dt = self.since(now)
        if dt == 0.0:
            raise MessageError("simulator/joint_states out of order: a sample was left out")
        shown = self.state
        if np.isfinite(self.asked).all():
            sent, shown = self.layer.step(self.asked, self.state, dt)
            self.publish_setpoints(now, self.safe(sent))
        speed = np.zeros_like(shown) if self.last is None else (shown - self.last[1]) / dt
        self.publish_joints(now, shown, speed, self.effort(message))
        self.last = now, shown

    def since(self, now: int) -> float:
        """Time [s] since the state before; 0 for one that is not after it."""
        if self.last is None:
            return FIRST
        passed = (now - self.last[0]) / SECOND
        if -LONGEST < passed <= LONGEST:
            return max(passed, 0.0)
        self.health.note("the simulator's stamps jumped: the layer begins anew")
        if self.layer is not None:
            self.layer.reset()
        self.last = None
        return FIRST

    def safe(self, sent: Array) -> Array:
        """Commands within the arm's limits (joints,) rad."""
        inside = np.clip(sent, self.lower, self.upper)
        if np.any(inside != sent) and np.all((self.asked >= self.lower) & (self.asked <= self.upper)):
            self.health.note("a command was held at the joint's limit")
        return inside

    def effort(self, message: Any) -> Array | None:
        """The simulator's effort, in the order of the joints."""
        return self.showing.gather(message.name, message.effort) if len(message.effort) else None


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(Reality, argv)
