"""A managed node's life: what fails in a transition is said, undone, and leaves the node where it was."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.graph.ros import LifecycleNode, LifecycleState, RCLError, TransitionCallbackReturn

DONE, FAILED = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class ManagedNode(LifecycleNode):
    """Subclasses override ``set_up``, ``let_go`` and ``halt``; ``active`` tells whether the node acts.

    ``failure``: why the last transition failed; ``attended``: who asked for it says so.
    """

    def __init__(self, name: str, **options: Any):
        self.active = self.attended = False
        self.failure = ""
        self.crash: Exception | None = None
        super().__init__(name, **options)
        self._refuse_impossible_transitions()

    def set_up(self) -> None:
        """Take all that the node needs. Raises TrunkError where that is impossible."""

    def let_go(self) -> None:
        """Undo ``set_up``, however far it came."""

    def halt(self) -> None:
        """The node was deactivated: the arm is to hold."""

    def last_call(self) -> None:
        """What comes later does not belong to the run any more."""

    def attempt(self, function: Callable[[], None]) -> bool:
        """Call within a transition, where rclpy swallows what goes wrong; tells whether all went well."""
        self.failure, self.crash = "", None
        try:
            function()
        except TrunkError as error:
            self.failure = str(error)
        except Exception as error:
            self.failure, self.crash = f"{type(error).__name__}: {error}", error
        if self.failure and not self.attended:
            self.get_logger().error(self.failure)
        return not self.failure

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Set up; where that fails the node is unconfigured as before."""
        if self.attempt(self.set_up):
            self.get_logger().info("configured")
            return DONE
        failed = self.failure, self.crash
        self.attempt(self.let_go)
        self.failure, self.crash = failed
        return FAILED

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to act."""
        self.active = True
        self.get_logger().info("active")
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop acting; the arm holds."""
        self.active = False
        self.attempt(self.halt)
        self.get_logger().info("inactive")
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let go of everything."""
        self.active = False
        self.attempt(self.let_go)
        return DONE

    on_shutdown = on_error = on_cleanup

    def _refuse_impossible_transitions(self) -> None:
        """One that the state does not have is answered with no success; rclpy would end the node."""
        change = self._service_change_state.callback

        def asked(request: Any, response: Any) -> Any:
            try:
                return change(request, response)
            except RCLError:
                self.get_logger().warning("refused: the node's state does not have this transition")
                response.success = False
                return response

        self._service_change_state.callback = asked


def start(node: ManagedNode) -> None:
    """Configure and activate. Raises TrunkError with the reason where that fails, and faults of ours."""
    node.attended = True
    try:
        for transition in (node.trigger_configure, node.trigger_activate):
            if transition() != DONE:
                _raise_crash(node)
                raise TrunkError(f"{node.get_name()}: {node.failure or 'the node could not be started'}")
    finally:
        node.attended = False


def retire(node: ManagedNode) -> None:
    """Stop acting before the end; who waits for the node is told while the executor is still served."""
    if node.active:
        node.active = False
        node.attempt(node.halt)


def end(node: ManagedNode, delivery: float) -> None:
    """Let the last messages arrive [s] and let go of everything, from any state. Raises faults of ours."""
    node.active, node.crash = False, None
    node.last_call()
    time.sleep(delivery)
    if node._state_machine.current_state[1] in ("unconfigured", "inactive", "active"):
        node.trigger_shutdown()
        _raise_crash(node)


def _raise_crash(node: ManagedNode) -> None:
    if node.crash is not None:
        raise node.crash
