"""What all nodes share: life cycle, clock, counted streams, diagnostics, and the loop of a process."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.model import Declaration, Model
from trunk_ros.nodes.graph import parameters
from trunk_ros.nodes.graph.elapsed import LONGEST_PAUSE, SECOND
from trunk_ros.nodes.graph.messages import nanoseconds, time_message
from trunk_ros.nodes.graph.progress import Listener
from trunk_ros.nodes.graph.ros import (
    Clock,
    ClockType,
    DiagnosticArray,
    DiagnosticStatus,
    KeyValue,
    LifecycleState,
    QoSProfile,
    SteadyClock,
    String,
    TransitionCallbackReturn,
)
from trunk_ros.nodes.graph.streams import DEPTH, StreamNode
from trunk_ros.nodes.graph.unpack import if_readable

PROGRESS_TOPIC = "trunk/_progress"  # hidden: only listened to by the bringup that started the node

WATCH = SECOND // 20  # ns between two steps of a loop that only looks after health

DELIVERY = 0.05  # s for the last messages to arrive; waiting for acknowledgements takes a heartbeat of 3 s

COMMON = (
    Declaration("rate", 100.0, "Hz", (1.0, 2000.0), "rate of the node's loop"),
    Declaration("autostart", True, "", None, "configure and activate the node by itself"),
    Declaration("supervised", False, "", None, "tell a bringup how far the node is"),
)


def steady_clock() -> Any:
    """A clock that nothing sets; one for each timer, as rclpy wants it."""
    return SteadyClock(clock_type=ClockType.STEADY_TIME)


class TrunkNode(StreamNode):
    """A managed node with a model. Subclasses override ``configure``, ``tick`` and ``release``."""

    NAME = "node"
    OWN: tuple[Declaration, ...] = ()
    needs_model = True
    idle = False  # nothing to do in the loop of real time: the node acts on what arrives
    model: Model

    def __init__(self, **options: Any):
        """``options`` are those of rclpy's Node. Raises TrunkError for parameters that make no sense."""
        super().__init__(self.NAME, **options)
        self._values: dict[str, Any] = {}
        self.add_post_set_parameters_callback(lambda _: self._values.clear())
        for declaration in (*COMMON, *self.OWN):
            parameters.declare(self, declaration)
        if self.needs_model:
            self.model = parameters.declare_model(self)
        for line in parameters.unknown(self):
            self.get_logger().warning(line)
        self.simulated = bool(self.value("use_sim_time"))
        period = round(SECOND / self.value("rate"))
        self.period = max(period, WATCH) if self.idle and not self.simulated else period
        self.fault = ""
        self.crash: Exception | None = None
        self._last = -1
        self._woken: float | None = None

    def value(self, name: str) -> Any:
        """A parameter's value."""
        if name not in self._values:
            self._values[name] = self.get_parameter(name).value
        return self._values[name]

    # What a subclass does

    def configure(self) -> None:
        """Create streams. Raises TrunkError where that is impossible."""

    def tick(self, now: int) -> None:
        """One step of the loop at ``now`` ns."""

    def rewound(self, now: int) -> None:
        """Time was set to ``now`` ns: back, or far ahead."""

    def halt(self) -> None:
        """The node was deactivated: the arm is to hold."""

    def release(self) -> None:
        """Let go of what ``configure`` took, streams aside."""

    # Clock

    def every(self, seconds: float, function: Callable[[], Any]) -> None:
        """Call a function by the wall's clock."""
        self._parts.append((self.destroy_timer, self.create_timer(seconds, function, clock=steady_clock())))

    def now(self) -> int:
        """ns of the node's clock: in simulated time the stamp of the step under way."""
        return self._last if self.simulated else time.time_ns()

    def _start_clock(self) -> None:
        if self.simulated:
            self._parts.append((self.destroy_subscription, self._hear_clock()))
        else:
            self.every(self.period / SECOND, self._on_timer)
        if self.value("supervised"):
            self.every(0.05, self._heartbeat)

    def _hear_clock(self) -> Any:
        return self.create_subscription(Clock, "/clock", if_readable(Clock, self._on_clock), DEPTH, raw=True)

    def _on_clock(self, message: Any) -> None:
        now = nanoseconds(message.clock)
        if self._last < 0 or not 0 <= now - self._last < self.period:
            self._step(now, 0)

    def _on_timer(self) -> None:
        awake, before = time.monotonic(), self._woken
        self._woken = awake
        late = 0.0 if before is None else max(awake - before - self.period / SECOND, 0.0)
        self._step(self.now(), round(late * SECOND))

    def _step(self, now: int, late: int) -> None:
        before, self._last = self._last, now
        if before >= 0 and not 0 <= now - before <= LONGEST_PAUSE:
            self.health.note("time jumped back" if now < before else "time jumped ahead")
            self.rewound(now)
        self.health.ticked(late)
        if self.active:
            self.guarded(self.tick, now)
        if self.health.due(now):
            self._diagnose(now)
        self.progress.stamp = now
        self._tell()

    # What others are told

    def _diagnose(self, now: int) -> None:
        level, words, values = self.health.report(now)
        status = DiagnosticStatus(level=bytes([level]), name=self.get_fully_qualified_name(), message=words)
        status.hardware_id = "trunk"
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp = time_message(now)
        self._publish_diagnostics(message)

    def _heartbeat(self) -> None:
        for destroy, part in self._parts:
            if destroy == self.destroy_publisher:
                self.progress.matched[">" + part.topic_name] = part.get_subscription_count()
            elif destroy == self.destroy_subscription:
                self.progress.matched["<" + part.topic_name] = part.get_publisher_count()
        self._tell(beat=True)

    # Life cycle

    def start(self) -> None:
        """Configure and activate. Raises TrunkError with the reason where that fails."""
        for transition in (self.trigger_configure, self.trigger_activate):
            succeeded = transition() == TransitionCallbackReturn.SUCCESS
            self._raise_crash()
            if not succeeded:
                raise TrunkError(f"{self.get_name()}: {self.fault or 'the node could not be started'}")

    def retire(self) -> None:
        """Stop acting before the end; who waits for the node is told while the executor is still served."""
        if self.active:
            self.active = False
            self._uncrashed(self.halt)

    def end(self) -> None:
        """Let the last messages arrive and let go of everything, from any state."""
        self.active = False
        time.sleep(DELIVERY)
        self.trigger_shutdown()
        self._raise_crash()

    def _raise_crash(self) -> None:
        if self.crash is not None:
            raise self.crash

    def _uncrashed(self, function: Callable[[], None]) -> bool:
        """Call within a transition, where rclpy swallows what goes wrong; tells whether all went well."""
        try:
            function()
        except TrunkError as error:
            self.fault = str(error)
            return False
        except Exception as error:
            self.crash = error
            return False
        return True

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Create streams and start the clock; but for diagnostics the node is silent until activated."""
        self._publish_diagnostics = self.publish_on(DiagnosticArray, "diagnostics")
        if self.needs_model:
            self.health.values["model"] = self.model.hash()
        if not self._uncrashed(self.configure):
            self._let_go()
            return TransitionCallbackReturn.FAILURE
        if self.value("supervised") and self.listener is None:
            self.listener = self._distant_listener()
        self._start_clock()
        return TransitionCallbackReturn.SUCCESS

    def _distant_listener(self) -> Listener:
        publisher = self.create_publisher(String, PROGRESS_TOPIC, QoSProfile(depth=DEPTH))
        return lambda progress: publisher.publish(String(data=progress.to_json()))

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to act."""
        self.active = True
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop acting; the arm holds."""
        self.retire()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Undo ``on_configure``."""
        self._let_go()
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End from any state."""
        self.active = False
        self._uncrashed(self._let_go)
        return TransitionCallbackReturn.SUCCESS

    def _let_go(self) -> None:
        self.release()
        self._close_streams()
