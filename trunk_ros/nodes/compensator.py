"""compensator: trajectory or reference in, corrected setpoints out: the model run backward."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from trunk_ros.errors import ModelError, TrunkError
from trunk_ros.model import Model
from trunk_ros.nodes.control.action import FollowAction
from trunk_ros.nodes.control.begin import Graph
from trunk_ros.nodes.control.controller import Controller
from trunk_ros.nodes.control.controller_state import ControllerState
from trunk_ros.nodes.control.foreign import ForeignReference
from trunk_ros.nodes.control.parameters import settings_of
from trunk_ros.nodes.control.states import HeardStates
from trunk_ros.nodes.control.ways import Ways
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.health import OK, REFUSED, WARN
from trunk_ros.nodes.graph.messages import nanoseconds
from trunk_ros.nodes.graph.model_swap import check_description
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.ros import FollowJointTrajectory, JointState, JointTrajectory, String
from trunk_ros.nodes.graph.trajectory_reader import read_order
from trunk_ros.nodes.parameters import PARAMETERS
from trunk_ros.recording.topics import JOINT_STATE

OTHERS = "others on trunk/setpoints"
"""The value under which it names nodes that may send setpoints while it moves the arm."""


class Compensator(TrunkNode):
    """Holds the arm where it finds it, follows trajectories; a foreign ``trunk/reference`` has precedence."""

    NAME = "compensator"
    OWN = PARAMETERS[NAME]
    controller: Controller | None = None
    action: FollowAction | None = None

    def configure(self) -> None:
        """Create the controller and the streams; nothing goes out until it is known where the arm stands."""
        joints, timeout, streams = self.model.arm.joints, self.value("timeout"), self.streams
        motors = self.model.arm.motor_names
        settings = settings_of(self)
        says = self.health.note, self.refuse, self.end_goal
        self.controller = Controller(self.model, settings, self.simulated, *says)
        self.foreign_reference = ForeignReference(self.model.arm)
        self.publish_reference = streams.publish_joints("trunk/reference", joints)
        self.publish_setpoints = streams.publish_joints("trunk/setpoints", motors)
        self.shown = ControllerState(streams, joints, self.value("state_rate"))
        streams.obey(JointTrajectory, "trunk/joint_trajectory", self.on_trajectory, raw=True)
        streams.obey(JointState, "trunk/reference", self.on_reference, raw=True)
        gearbox, measured = (self.controller.observation_of(topic) for topic in ("gearbox", "joints"))
        self.motors = HeardStates(self, "trunk/gearbox_states", motors, timeout, gearbox)
        self.measured = HeardStates(self, "joint_states", joints, timeout, measured)
        self.ways = Ways(joints)
        streams.latched(String, "robot_description", self.on_description)
        self.action = FollowAction(self, self.controller) if FollowJointTrajectory is not None else None

    # In

    def on_description(self, message: Any) -> None:
        """Refuse to move an arm that is not the model's."""
        before, self.health.fault = self.health.fault, ""
        try:
            check_description(message.data, self.model.arm)
        except ModelError as error:
            self.forget(f"refused: {error}")
            self.health.fault = f"refused: {error}"
            if before != self.health.fault:
                self.get_logger().error(self.health.fault)

    def on_trajectory(self, raw: bytes) -> None:
        """Replace what is under way, or say why the trajectory is refused."""
        assert self.controller is not None
        if self.health.fault:
            self.refuse(f"trajectory refused: {self.health.fault}")
            return
        try:
            order = read_order(raw)
            if order.trajectory is not None:
                self.controller.follow(order.trajectory, self.now(), order.begin, self.graph())
        except TrunkError as error:
            self.refuse(f"trajectory refused: {error}")
            return
        self.health.values.pop(REFUSED, None)
        if order.trajectory is None:
            self.controller.halt(self.now())
        self.end_goal(f"{'stopped by an empty' if order.trajectory is None else 'replaced by a'} trajectory")
        self.log(OK, "stopping" if order.trajectory is None else "trajectory accepted")

    def refuse(self, why: str) -> None:
        """Say that a command is not followed: a bringup that gave it ends with that."""
        self.health.values[REFUSED] = why
        self.health.note(why)

    def on_reference(self, raw: bytes) -> None:
        """Take a foreign reference; our own comes back as well and is left alone."""
        assert self.controller is not None
        message = self.foreign_reference.message(raw)
        if message is None:
            return
        given = self.foreign_reference.position(message)
        stream = self.streams.watch("trunk/reference", self.value("timeout"))
        self.streams.heard(stream, nanoseconds(message.header.stamp))
        for oddity in self.foreign_reference.matcher.oddities():
            self.health.note(oddity)
        self.controller.refer(given)
        self.end_goal("a foreign reference has come")

    def graph(self) -> Graph:
        """What there is to know of the topics; who publishes them only where that matters."""
        assert self.controller is not None
        now, lost = self.now(), self.motors.stream.stale(self.now())
        fresh = self.measured.stream.last is not None and not self.measured.stream.stale(now)
        if self.controller.settled:
            return Graph(True, lost, fresh)
        said, others = self.publishers("trunk/gearbox_states") > 0, self.publishers("trunk/setpoints") > 1
        strangers = [] if said else self.strangers(JOINT_STATE)
        lacking = self.motors.matcher.lacking() if said else self._nobody(strangers)
        return Graph(said, lost, fresh, others, bool(strangers), lacking)

    def _nobody(self, strangers: Sequence[str] = ()) -> str:
        nobody = f"nobody publishes {self.resolve_topic_name('trunk/gearbox_states')}"
        if not strangers:
            return nobody
        return f"{nobody}; {', '.join(strangers)} may be it: remap it, or set open_loop"

    # Out

    def tick(self, now: int) -> None:
        """Sample the reference and publish the setpoint."""
        assert self.controller is not None
        graph = self.graph()
        command = None if self.health.fault else self.controller.update(now, graph)
        if command is None:
            return
        if command.reference is not None:
            self.foreign_reference.sent(now, command.reference[0])
            self.publish_reference(now, *command.reference)
        if command.silent:
            self.ways = Ways(self.model.arm.joints)  # who knows how it will go on from here
        else:
            self.publish_setpoints(now, command.setpoint)
        if self.controller.limited:
            self.health.note(f"held back at a limit: {self.controller.limited}", level=OK)
        busy = self.action is not None and self.action.busy
        if graph.fresh and not busy and not self.shown.due(now):
            return  # a model in the place of joint_states has to see every step
        stamp, wanted, actual = self.controller.compared(now, graph.fresh)
        self.shown.tick(stamp, wanted, actual, command.setpoint)
        reference = self.controller.reference
        if graph.fresh and reference is not None and not (command.silent or self.controller.limited):
            self.ways.see(now, reference, actual.position)
        if self.action is not None:
            self.action.tick(now, wanted, actual)

    def diagnosing(self) -> None:
        """Once a second: which joints go astray, and what is odd about who is there."""
        self.health.trouble("ways", self.ways.missed)
        for heard in (self.motors, self.measured):
            heard.look_for_rivals()
        if self.controller is None or not self.controller.moves:
            return
        if self.controller.begin.blind:
            self.health.note(f"{self._nobody()}: the arm moves unseen, as if it had stood at 0")
        self._say_who_else_may_move_it()

    def _say_who_else_may_move_it(self) -> None:
        before, others = self.health.values.pop(OTHERS, ""), ""
        if self.publishers("trunk/setpoints") > 1:
            there = self.get_publishers_info_by_topic("trunk/setpoints")
            others = ", ".join(sorted({each.node_name for each in there} - {self.get_name()}))
            others = self.health.values[OTHERS] = others or "another compensator"
        if others and others != before:
            self.log(WARN, f"trunk/setpoints may also come from {others}: only one may move the arm")

    # What stops it

    def end_goal(self, reason: str) -> None:
        """Tell the client of a goal that something else moves or holds the arm."""
        if self.action is not None:
            self.action.abort(reason)

    def forget(self, reason: str) -> None:
        """Hold, and start anew from where the arm stands by then."""
        self.end_goal(reason)
        if self.controller is not None:
            self.controller.stop()
            self.ways = Ways(self.model.arm.joints)
            self.health.trouble("ways", "")

    def halt(self) -> None:
        """Deactivated: stay."""
        self.forget("the compensator was deactivated")

    def rewound(self, now: int) -> None:
        """The trajectory's time is gone: stay."""
        if self.controller is not None:
            self.controller.rewound()
        self.end_goal("time was set")

    # Changes at run time

    def changed(self) -> None:
        """Act by other parameters."""
        super().changed()
        if self.controller is not None:
            self.controller.adjust(settings_of(self))
            self.shown.rate = self.value("state_rate")

    def use(self, model: Model) -> None:
        """Swap the model; the setpoint goes over without a jump."""
        super().use(model)
        if self.controller is not None:
            self.controller.use(model)
            self.log(OK, f"model {model.hash()}")

    def release(self) -> None:
        """The controller ends with the streams."""
        self.controller = self.action = None


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(Compensator, argv)
