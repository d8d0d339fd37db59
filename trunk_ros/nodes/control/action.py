"""The action follow_joint_trajectory, where control_msgs is installed; a goal at a time, the newest wins."""

from __future__ import annotations

from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.control.controller import Controller
from trunk_ros.nodes.control.goal import Code, Goal, GoalError, Outcome, State, Tolerance, leeway, overlaid
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.health import OK
from trunk_ros.nodes.graph.messages import point, time_message
from trunk_ros.nodes.graph.ros import ActionServer, CancelResponse, FollowJointTrajectory, GoalResponse
from trunk_ros.nodes.graph.trajectory_reader import order_of

NAME = "trunk/follow_joint_trajectory"
MONITORED = SECOND // 20  # ns between two feedback messages


class PatientServer(ActionServer):
    """Lets a goal execute without a coroutine that waits: one would keep the events executor busy."""

    def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
        """Executing begins; ``finish`` says when it is over."""

    def finish(self, goal_handle: Any, state: str, outcome: Outcome) -> None:
        """Bring a goal to an end: ``succeed``, ``abort`` or ``canceled``."""
        result = FollowJointTrajectory.Result(error_code=int(outcome.code), error_string=outcome.text)

        def conclude(handle: Any) -> Any:
            getattr(handle, state)()
            return result

        super().notify_execute(goal_handle, conclude)


class FollowAction:
    """Serves goals to the ``controller`` of the compensator ``node``, which follows their trajectories."""

    def __init__(self, node: Any, controller: Controller):
        self.node, self.controller = node, controller
        self.goal: Goal | None = None
        self.next_goal: Goal | None = None
        self.handle: Any = None
        self.told = 0
        self.server = PatientServer(
            node,
            FollowJointTrajectory,
            NAME,
            execute_callback=lambda handle: None,  # never called: see PatientServer
            goal_callback=self.asked,
            handle_accepted_callback=self.accepted,
            cancel_callback=self.cancelled,
        )
        node.streams.own(lambda server: server.destroy(), self.server)

    def asked(self, request: Any) -> Any:
        """Take a goal, or refuse it with the reason in the log and on diagnostics."""
        try:
            self.next_goal = self.begin(request)
        except TrunkError as error:
            self.node.health.note(f"goal refused: {error}")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def begin(self, request: Any) -> Goal:
        """Follow a goal. Raises TrunkError with the reason where that is refused."""
        node = self.node
        if not node.active or node.health.fault:
            raise GoalError(node.health.fault or "the compensator is not active")
        if request.multi_dof_trajectory.points:
            raise GoalError("it has a multi_dof_trajectory: the arm has single joints only")
        if not request.trajectory.points:
            raise GoalError("its trajectory has no points")
        path = self.tolerance(request.path_tolerance, node.value("path_tolerance"), 0.0)
        goal = self.tolerance(
            request.goal_tolerance, node.value("goal_tolerance"), node.value("stopped_velocity")
        )
        late = leeway(request.goal_time_tolerance, node.value("goal_time"))
        order = order_of(request.trajectory)
        assert order.trajectory is not None
        if not self.controller.start(node.now()):
            raise GoalError("where the arm stands is not known: no trunk/gearbox_states")
        end = self.controller.follow(order.trajectory, node.now(), order.begin, node.graph())
        assert end is not None
        return Goal(self.controller.joints, end, path, goal, late)

    def tolerance(self, given: Any, position: float, velocity: float) -> Tolerance:
        """What a goal asks over the node's own."""
        joints = self.controller.joints
        return overlaid(given, joints, Tolerance.same(len(joints), position, velocity))

    def accepted(self, handle: Any) -> None:
        """A goal that was taken replaces the one under way."""
        self.abort("replaced by a new goal")
        self.handle, self.goal = handle, self.next_goal
        self.node.log(OK, "goal accepted")
        handle.execute()

    def cancelled(self, handle: Any) -> Any:
        """Hold; the goal ends with the next step of the loop."""
        if handle is self.handle:
            self.controller.hold(self.node.now())
        return CancelResponse.ACCEPT

    def abort(self, reason: str) -> None:
        """End the goal under way, if there is one, since something else moves or holds the arm."""
        if self.handle is not None:
            self._end("abort", Outcome(Code.INVALID_GOAL, reason))

    @property
    def busy(self) -> bool:
        """Whether a goal is under way."""
        return self.handle is not None

    def tick(self, now: int, wanted: State, actual: State) -> None:
        """Judge the goal under way at ``now`` ns, and tell the client how it goes."""
        if self.handle is None or self.goal is None:
            return
        if self.handle.is_cancel_requested:
            self._end("canceled", Outcome(Code.SUCCESSFUL, "cancelled; holding"))
            return
        outcome = self.goal.judge(now / SECOND, wanted, actual)
        if outcome is None:
            self._tell(now, wanted, actual)
        elif outcome.code == Code.SUCCESSFUL:
            self._end("succeed", outcome)
        else:
            self.controller.hold(now)
            self._end("abort", outcome)

    def _end(self, state: str, outcome: Outcome) -> None:
        if outcome.code != Code.SUCCESSFUL:
            self.node.health.note(f"goal aborted: {outcome.text}")
        else:
            self.node.log(OK, outcome.text)
        handle, self.handle, self.goal = self.handle, None, None
        self.server.finish(handle, "canceled" if handle.is_cancel_requested else state, outcome)

    def _tell(self, now: int, wanted: State, actual: State) -> None:
        if 0 <= now - self.told < MONITORED:
            return
        self.told = now
        assert self.goal is not None
        message = FollowJointTrajectory.Feedback(joint_names=list(self.goal.joints))
        message.header.stamp = time_message(now)
        message.desired, message.actual = point(wanted), point(actual)
        message.error = point(wanted.minus(actual))
        self.handle.publish_feedback(message)
