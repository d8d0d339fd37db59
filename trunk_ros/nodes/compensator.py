"""compensator: trajectory or reference in, corrected setpoints out: the model run backward."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.errors import ModelError, TrunkError
from trunk_ros.model import Declaration, Model, declared_parameters, load_model
from trunk_ros.nodes import parameters
from trunk_ros.nodes.base import TrunkNode
from trunk_ros.nodes.compensation import Compensation
from trunk_ros.nodes.follower import Follower
from trunk_ros.nodes.joints import JointMatcher, MessageError
from trunk_ros.nodes.messages import SECOND, joint_state, nanoseconds, trajectory_of
from trunk_ros.nodes.process import run_node
from trunk_ros.nodes.ros import JointState, JointTrajectory, SetParametersResult, deserialize_message
from trunk_ros.trajectory import Array, Limits

LONGEST_STEP = 0.1  # s that the output may move on after a pause


class Compensator(TrunkNode):
    """Publishes the reference while it follows a trajectory; a foreign ``trunk/reference`` has precedence."""

    NAME = "compensator"
    OWN = (
        Declaration(
            "timeout",
            0.5,
            "s",
            (0.01, 60.0),
            "silence after which gearbox_states or a reference are called stale",
        ),
        Declaration(
            "reversal", 5e-5, "rad", (0.0, 0.1), "a reference that turns back by less keeps its direction"
        ),
        Declaration(
            "max_acceleration",
            100.0,
            "rad/s^2",
            (0.1, 1e6),
            "joint acceleration that a trajectory may ask for",
        ),
        Declaration("lead", True, "", None, "let setpoints of a trajectory run ahead by the servo's lag"),
        Declaration(
            "patience",
            1.0,
            "s",
            (0.0, 60.0),
            "wait for gearbox_states before starting without knowing where the arm is",
        ),
    )

    def configure(self) -> None:
        """Create the streams; nothing goes out until a trajectory or a reference has come in."""
        self.joints = self.model.arm.joints
        still = np.zeros(len(self.joints))
        Compensation(self.model, self.value("reversal"), still).step(
            still, 0.01
        )  # compiles, so that no step is late
        self.from_gearbox, self.from_reference = JointMatcher(self.joints), JointMatcher(self.joints)
        self.gearbox: Array | None = None
        self.compensation: Compensation | None = None
        self.follower: Follower | None = None
        self.foreign: Array | None = None
        self.waiting: Any = None
        self.since: int | None = None
        self.ours: deque[bytes] = deque(maxlen=1000)
        timeout = self.value("timeout")
        self.gearbox_stream = self.watch("trunk/gearbox_states", timeout)
        self.publish_reference = self.publish_on(JointState, "trunk/reference")
        self.publish_setpoints = self.publish_on(JointState, "trunk/setpoints")
        self.listen_to(JointTrajectory, "trunk/joint_trajectory", self.on_trajectory)
        self.listen_to(JointState, "trunk/reference", self.on_reference, raw=True)
        self.listen_to(JointState, "trunk/gearbox_states", self.on_gearbox)
        self.describing = False
        self.add_on_set_parameters_callback(self.on_parameters)
        self.add_post_set_parameters_callback(self.after_parameters)

    # In

    def on_gearbox(self, message: Any) -> None:
        """Remember where the shafts stand."""
        self.gearbox_stream.arrived(self.now())
        self.gearbox = self.from_gearbox.gather(message.name, message.position)

    def on_trajectory(self, message: Any) -> None:
        """Replace what is under way. Raises TrunkError where the trajectory is refused."""
        self.foreign = None
        if self.follower is None:
            self.waiting = message
            return
        now = self.now()
        if not message.points:
            self.follower.stop(now / SECOND)
            return
        begin = nanoseconds(message.header.stamp) / SECOND or None
        try:
            self.follower.follow(trajectory_of(message), now / SECOND, begin)
        except TrunkError as error:
            raise MessageError(f"trajectory refused: {error}") from None

    def on_reference(self, raw: bytes) -> None:
        """Take a foreign reference; our own comes back as well and is left alone."""
        if raw[4:12] in self.ours:
            return
        message = deserialize_message(raw, JointState)
        given = self.from_reference.gather(message.name, message.position)
        self.watch("trunk/reference", self.value("timeout")).arrived(self.now())
        for oddity in self.from_reference.oddities():
            self.health.note(oddity)
        if not np.isfinite(given[[j not in self.from_reference.missing for j in self.joints]]).all():
            raise MessageError("reference refused: not a number")
        held = self.reference_now()
        self.foreign = given if held is None else np.where(np.isfinite(given), given, held)

    def reference_now(self) -> Array | None:
        """The reference of all joints, None before the start."""
        if self.foreign is not None:
            return self.foreign
        return None if self.follower is None else self.follower.position

    # Out

    def tick(self, now: int) -> None:
        """Sample the reference and publish the setpoint."""
        if self.compensation is None and not self.begin(now):
            return
        assert self.compensation is not None
        dt = min(max((now - self.since) / SECOND, 0.0), LONGEST_STEP) if self.since is not None else 0.0
        self.since = now
        reference, velocity, acceleration = self.sample(now)
        if self.value("lead"):
            reference = reference + self.compensation.ahead(velocity, acceleration, dt)
        out = self.compensation.step(reference, dt)
        if self.compensation.limited.any():
            self.health.note(
                f"held back at a limit: {self.joints[int(np.argmax(self.compensation.limited))]}", level=0
            )
        self.publish_setpoints(joint_state(now, self.joints, out))

    def begin(self, now: int) -> bool:
        """Start from where the arm stands, once there is something to do; False while there is not."""
        if self.waiting is None and self.foreign is None:
            return False
        self.since = self.since if self.since is not None else now
        known = self.gearbox is not None and np.isfinite(self.gearbox).all()
        if not known and now - self.since < self.value("patience") * SECOND and self.expects_gearbox():
            return False
        self.since = None
        stands = self.gearbox if known else None
        self.compensation = Compensation(self.model, self.value("reversal"), stands)
        start = self.compensation.joint_angle(np.zeros(len(self.joints)) if stands is None else stands)
        self.follower = Follower(self.joints, self.limits(), start)
        if self.foreign is not None:
            self.foreign = np.where(np.isfinite(self.foreign), self.foreign, start)
        if self.waiting is not None:
            message, self.waiting = self.waiting, None
            self.guarded(self.on_trajectory, message)
        return True

    def expects_gearbox(self) -> bool:
        """Whether anybody publishes the state of the gearbox."""
        return self.count_publishers("trunk/gearbox_states") > 0

    def sample(self, now: int) -> tuple[Array, Array, Array]:
        """Reference, speed, acceleration (joints,): the foreign one, or our own, which is published."""
        assert self.follower is not None
        stream = self.health.streams.get("trunk/reference")
        if self.foreign is not None and stream is not None:
            self.follower = Follower(self.joints, self.limits(), self.foreign)
            rest = np.zeros(len(self.joints))
            return self.foreign, rest, rest
        position, velocity, acceleration = self.follower.sample(now / SECOND)
        message = joint_state(now, self.joints, position, velocity)
        stamp = message.header.stamp
        self.ours.append(stamp.sec.to_bytes(4, "little") + stamp.nanosec.to_bytes(4, "little"))
        self.publish_reference(message)
        return position, velocity, acceleration

    def rewound(self, now: int) -> None:
        """The trajectory's time is gone: stay."""
        self.since = None
        if self.follower is not None:
            self.follower = Follower(self.joints, self.limits(), self.follower.position)

    def limits(self) -> Limits:
        """What a trajectory may ask for."""
        arm = self.model.arm
        everywhere = np.ones(len(self.joints))
        return Limits(
            arm.lower, arm.upper, arm.v_max * np.abs(arm.ratio), everywhere * self.value("max_acceleration")
        )

    # Model at run time

    def on_parameters(self, changes: list[Any]) -> Any:
        """Take a new model, or refuse it with the reason; the setpoint goes over without a jump."""
        if self.describing:
            return SetParametersResult(successful=True)
        try:
            model = self.changed({change.name: change.value for change in changes})
        except TrunkError as error:
            return SetParametersResult(successful=False, reason=str(error))
        if model is not None and model.hash() != self.model.hash():
            self.use(model)
        return SetParametersResult(successful=True)

    def after_parameters(self, changes: list[Any]) -> None:
        """Let the other parameters show the model that ``model`` has loaded."""
        if not self.describing and any(change.name == parameters.MODEL.name for change in changes):
            self.describing = True
            parameters.describe_model(self, self.model)
            self.describing = False

    def changed(self, changes: dict[str, Any]) -> Model | None:
        """The model that changed parameters describe, None where they are not about it. Raises TrunkError."""
        if "model" in changes:
            return self.fitting(load_model(changes["model"]))
        names = {d.name for d in declared_parameters()}
        if not names & changes.keys():
            return None
        flat = {name: self.value(name) for name in names} | {k: v for k, v in changes.items() if k in names}
        return self.fitting(Model.from_parameters(flat))

    def fitting(self, model: Model) -> Model:
        """The model if it is of the running arm. Raises TrunkError where it is another arm's."""
        if model.any_joints:
            model = model.for_joints(self.joints)
        check_same_arm(model.arm, self.model.arm)
        return model

    def use(self, model: Model) -> None:
        """Swap the model."""
        self.model = model
        self.health.values["model"] = model.hash()
        if self.compensation is not None:
            self.compensation.swap(model)


def check_same_arm(new: Arm, running: Arm) -> None:
    """Raise ModelError where a model is not of the running arm; effects may differ, the arm may not."""
    if new.joints != running.joints:
        raise ModelError(f"the model has joints {', '.join(new.joints)}, the arm {', '.join(running.joints)}")
    for name in ("ratio", "lower", "upper"):
        if not np.allclose(getattr(new, name), getattr(running, name), rtol=1e-6):
            raise ModelError(f"the model's {name} is not that of the running arm")


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(Compensator, argv)
