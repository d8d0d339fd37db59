"""compensator: trajectory or reference in, corrected setpoints out: the model run backward."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.errors import ModelError, TrunkError
from trunk_ros.model import Model
from trunk_ros.nodes.control.action import FollowAction
from trunk_ros.nodes.control.compensation import Compensation
from trunk_ros.nodes.control.controller_state import ControllerState
from trunk_ros.nodes.control.follower import Follower, limits_of
from trunk_ros.nodes.control.foreign import ForeignReference
from trunk_ros.nodes.control.model_swap import ModelSwap, check_description
from trunk_ros.nodes.control.observation import Observation
from trunk_ros.nodes.control.parameters import FEEDBACK, OWN
from trunk_ros.nodes.control.slow_feedback import Settings
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.joints import JointMatcher, MessageError
from trunk_ros.nodes.graph.messages import nanoseconds, state_of, trajectory_of
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.ros import FollowJointTrajectory, JointState, JointTrajectory, String
from trunk_ros.trajectory import Array

LONGEST_STEP = 0.1  # s that the output may move on after a pause
ELSEWHERE = 0.02  # rad at the gearbox between where an arm was sent unseen and where it then shows to be


class Compensator(TrunkNode):
    """Publishes the reference while it follows a trajectory; a foreign ``trunk/reference`` has precedence."""

    NAME = "compensator"
    OWN = OWN
    swap: ModelSwap | None = None

    def configure(self) -> None:
        """Create the streams; nothing goes out until a trajectory or a reference has come in."""
        self.joints = self.model.arm.joints
        still = np.zeros(len(self.joints))
        Compensation(self.model, 0.0, still).step(still, 0.01)  # compiles, so that no step is late
        self.compensation: Compensation | None = None
        self.follower: Follower | None = None
        self.foreign: Array | None = None
        self.waiting: Any = None
        self.since: int | None = None
        self.blind = False
        self.foreign_reference = ForeignReference(self.model.arm)
        self.observation = Observation(self.model, self.simulated)
        self.gearbox_matcher = JointMatcher(self.model.arm.motor_names)
        self.joints_matcher = JointMatcher(self.joints)
        self.open_streams()
        self.swap = ModelSwap(self, self.use)

    def open_streams(self) -> None:
        """Publishers, subscriptions, and the action where control_msgs is installed."""
        timeout = self.value("timeout")
        self.gearbox_stream = self.watch("trunk/gearbox_states", timeout)
        self.joints_stream = self.watch("joint_states", timeout)
        self.publish_reference = self.joint_states_on("trunk/reference", self.joints)
        self.publish_setpoints = self.joint_states_on("trunk/setpoints", self.model.arm.motor_names)
        self.shown = ControllerState(self, self.joints, self.value("state_rate"))
        self.listen_to(JointTrajectory, "trunk/joint_trajectory", self.on_trajectory)
        self.listen_to(JointState, "trunk/reference", self.on_reference, raw=True)
        self.listen_to(JointState, "trunk/gearbox_states", self.on_gearbox)
        self.listen_to(JointState, "joint_states", self.on_joints)
        self.listen_latched(String, "robot_description", self.on_description)
        self.action = FollowAction(self) if FollowJointTrajectory is not None else None

    # In

    def on_gearbox(self, message: Any) -> None:
        """Remember where the shafts stand."""
        stamp = self.arrived(self.gearbox_stream, message)
        self.observation.measured.gearbox.put(stamp, state_of(message, self.gearbox_matcher))

    def on_joints(self, message: Any) -> None:
        """Remember where the joints are measured to stand."""
        stamp = self.arrived(self.joints_stream, message)
        self.observation.measured.joints.put(stamp, state_of(message, self.joints_matcher))

    def on_description(self, message: Any) -> None:
        """Refuse to move an arm that is not the model's."""
        self.health.fault = ""
        try:
            check_description(message.data, self.model.arm)
        except ModelError as error:
            self.forget(f"refused: {error}")
            self.health.fault = f"refused: {error}"

    def on_trajectory(self, message: Any) -> None:
        """Replace what is under way. Raises TrunkError where the trajectory is refused."""
        if self.health.fault:
            raise MessageError(f"trajectory refused: {self.health.fault}")
        if self.follower is None:
            self.foreign, self.waiting = None, message
        elif not message.points:
            self.foreign = None
            self.hold("stopped by an empty trajectory")
        else:
            try:
                self.follow(message)
            except TrunkError as error:
                raise MessageError(f"trajectory refused: {error}") from None
            self.end_goal("replaced by a trajectory")

    def follow(self, message: Any) -> float:
        """Follow a trajectory message; returns its end [s]. Raises TrunkError where it is refused."""
        assert self.follower is not None
        if self.gearbox_stream.stale(self.now()):
            raise MessageError("no trunk/gearbox_states")
        begin = nanoseconds(message.header.stamp) / SECOND or None
        end = self.follower.follow(trajectory_of(message), self.now() / SECOND, begin)
        self.foreign = None
        return end

    def on_reference(self, raw: bytes) -> None:
        """Take a foreign reference; our own comes back as well and is left alone."""
        message = self.foreign_reference.message(raw)
        if message is None:
            return
        given = self.foreign_reference.position(message)
        stream = self.watch("trunk/reference", self.value("timeout"))
        self.heard(stream, nanoseconds(message.header.stamp))
        for oddity in self.foreign_reference.matcher.oddities():
            self.health.note(oddity)
        held, self.waiting = self.reference_now(), None
        self.foreign = given if held is None else np.where(np.isfinite(given), given, held)
        self.end_goal("a foreign reference has come")

    def reference_now(self) -> Array | None:
        """The reference of all joints, None before the start."""
        if self.foreign is not None:
            return self.foreign
        return None if self.follower is None else self.follower.position

    # Out

    def tick(self, now: int) -> None:
        """Sample the reference and publish the setpoint."""
        if self.health.fault or (self.compensation is None and not self.begin_when_known(now)):
            return
        assert self.compensation is not None
        if self.blind and not self.seen(now):
            return
        dt = min(max((now - self.since) / SECOND, 0.0), LONGEST_STEP) if self.since is not None else 0.0
        self.since = now
        reference, velocity, acceleration = self.sample(now)
        self.observation.remember(now, reference, velocity)
        lead = self.compensation.ahead(velocity, acceleration, dt) if self.value("lead") else 0.0
        out = self.compensation.step(reference + lead + self.correction(now, reference, dt), dt)
        if self.compensation.limited.any():
            held_back = self.joints[int(np.argmax(self.compensation.limited))]
            self.health.note(f"held back at a limit: {held_back}", level=0)
        self.publish_setpoints(now, out)
        self.tell(now, out)

    def tell(self, now: int, out: Array) -> None:
        """Say what came of what was wanted to those who want to know at ``now`` ns; a model in the place of
        joint_states has to see every step.
        """
        measured = self.joints_stream.last is not None and not self.joints_stream.stale(now)
        busy = self.action is not None and self.action.busy
        if measured and not busy and not self.shown.due(now):
            return
        stamp, wanted, actual = self.observation.compared(now, not self.joints_stream.stale(now))
        self.shown.tick(stamp, wanted, actual, out)
        if self.action is not None:
            self.action.tick(now, wanted, actual)

    def correction(self, now: int, reference: Array, dt: float) -> Array:
        """What the slow feedback adds to the reference (joints,) rad."""
        assert self.compensation is not None
        settings = Settings(*[self.value(each.name) for each in FEEDBACK])
        fresh, limited = not self.joints_stream.stale(now), self.compensation.limited
        return self.observation.correction(now, fresh, settings, reference, limited, dt)

    def begin_when_known(self, now: int) -> bool:
        """Start when there is something to do and it is known where the arm stands, or nobody says it.

        A trajectory waits for that: who says it may not have been found yet.
        """
        if self.waiting is None and self.foreign is None:
            return False
        told = self.observation.stands(now) is not None
        said = self.count_publishers("trunk/gearbox_states")
        self.since = now if self.since is None else self.since
        patient = now - self.since < self.value("patience") * SECOND
        if told or not (said or (patient and self.waiting is not None)):
            self.begin(now)
            return True
        if not patient:
            self.waiting = self.since = None
            self.health.note("refused: trunk/gearbox_states do not say where all joints stand")
        return False

    def seen(self, now: int) -> bool:
        """Whether an arm that was taken to stand at 0 may be moved: nobody is there to say where it stands,
        or somebody has. Where it stands elsewhere than it was asked to, all starts anew from there.
        """
        stands = self.observation.stands(now)
        if stands is None:
            return not self.count_publishers("trunk/gearbox_states")
        out, self.blind = self.compensation.out if self.compensation else None, False
        if out is None or np.abs(stands - out).max() > ELSEWHERE:
            self.health.note("the arm stands elsewhere than was thought: starting anew from there")
            self.begin(now)
        return True

    def begin(self, now: int) -> None:
        """Start from where the arm stands, at 0 where that is not known."""
        self.since = None
        stands = self.observation.stands(now)
        self.blind = stands is None
        self.compensation = Compensation(self.model, self.value("reversal"), stands)
        arm = self.model.arm
        start = self.compensation.joint_angle(arm.asked(arm.rest) if stands is None else stands)
        self.follower = Follower(
            self.joints, limits_of(self.model.arm, self.value("max_acceleration")), start
        )
        if self.foreign is not None:
            self.foreign = np.where(np.isfinite(self.foreign), self.foreign, start)
        if self.waiting is not None:
            message, self.waiting = self.waiting, None
            self.guarded(self.on_trajectory, message)

    def sample(self, now: int) -> tuple[Array, Array, Array]:
        """Reference, speed, acceleration (joints,): the foreign one, or our own, which is published."""
        assert self.follower is not None
        lost = self.gearbox_stream.stale(now)
        if lost:
            self.hold("no trunk/gearbox_states")
        if self.foreign is not None:
            if not lost:
                self.follower.hold(self.foreign)
            rest = np.zeros(len(self.joints))
            return self.follower.position, rest, rest
        position, velocity, acceleration = self.follower.sample(now / SECOND)
        self.foreign_reference.sent(now, position)
        self.publish_reference(now, position, velocity)
        return position, velocity, acceleration

    # What stops it

    def hold(self, reason: str = "") -> None:
        """Stay where the reference is, and give up the goal under way if a reason is given."""
        if self.follower is not None and self.foreign is None:
            self.follower.stop(self.now() / SECOND)
        self.waiting = None
        if reason:
            self.end_goal(reason)

    def end_goal(self, reason: str) -> None:
        """Tell the client of a goal that something else moves or holds the arm."""
        if self.action is not None:
            self.action.abort(reason)

    def halt(self) -> None:
        """Deactivated: stay."""
        self.forget("the compensator was deactivated")

    def forget(self, reason: str) -> None:
        """Hold, and start anew from where the arm stands by then: others may move it in between."""
        self.hold(reason)
        self.compensation = self.follower = self.foreign = self.since = None
        self.observation = Observation(self.model, self.simulated)

    def rewound(self, now: int) -> None:
        """The trajectory's time is gone: stay."""
        self.since = None
        if self.follower is not None:
            self.follower.hold(self.follower.position)
        self.end_goal("time was set")

    def release(self) -> None:
        """Watch the parameters no longer."""
        if self.swap is not None:
            self.swap.stop()
            self.swap = None

    def use(self, model: Model) -> None:
        """Swap the model; the setpoint goes over without a jump."""
        self.model = model
        self.health.values["model"] = model.hash()
        self.observation.use(model)
        if self.compensation is not None:
            self.compensation.swap(model)


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(Compensator, argv)
