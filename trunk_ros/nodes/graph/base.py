"""What all nodes share. A node talks; what it decides is decided by a plain object that it feeds and asks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from trunk_ros.model import Model
from trunk_ros.nodes.graph import parameters
from trunk_ros.nodes.graph.health import ERROR, OK, Health
from trunk_ros.nodes.graph.loop import Loop, steady_clock
from trunk_ros.nodes.graph.managed import ManagedNode
from trunk_ros.nodes.graph.model_swap import ModelSwap
from trunk_ros.nodes.graph.report import Report
from trunk_ros.nodes.graph.ros import INFO, WARNING
from trunk_ros.nodes.graph.streams import Streams
from trunk_ros.nodes.parameters import COMMON, MODEL
from trunk_ros.parameter import Declaration
from trunk_ros.recording.topics import TOPICS


class TrunkNode(ManagedNode):
    """A node with parameters, streams, a loop and a report. ``fault``: why it has to end."""

    NAME = "node"
    OWN: tuple[Declaration, ...] = ()
    fixed_model = False  # it holds from the start
    idle = False  # nothing to do in the loop of real time: the node acts on what arrives
    model: Model

    def __init__(self, **options: Any):
        """``options`` are those of rclpy's Node. Raises TrunkError for parameters that make no sense."""
        super().__init__(self.NAME, allow_undeclared_parameters=True, **options)  # Settings refuses them
        self.fault = ""
        for declaration in (*COMMON, *self.OWN):
            if declaration is not MODEL:
                parameters.declare(self, declaration)
        if self.needs_model:
            self.model = parameters.declare_model(self, self.fixed_model)
            self.swap = ModelSwap(self.model, self.get_parameter(MODEL.name).value)
        for line in parameters.unknown(self):
            self.get_logger().warning(line)
        self.simulated = bool(self.get_parameter("use_sim_time").value)
        if self.get_parameter("supervised").value and self.get_logger().get_effective_level() == INFO:
            self.get_logger().set_level(WARNING)
        self.health = Health(log=self.log)
        self.settings = parameters.Settings(self, (*COMMON, *self.OWN))
        self.streams = Streams(self, self.simulated and self.value("supervised"))
        self.loop = Loop(self, self.value("rate"), self.idle, self._step)
        self.report = Report(self)

    # What a subclass does

    def configure(self) -> None:
        """Create streams. Raises TrunkError where that is impossible."""

    def tick(self, now: int) -> None:
        """One step of the loop at ``now`` ns."""

    def rewound(self, now: int) -> None:
        """Time was set to ``now`` ns: back, or far ahead."""

    def changed(self) -> None:
        """Parameters have changed."""
        for stream in self.health.streams.values():
            stream.timeout = self.value("timeout")

    def use(self, model: Model) -> None:
        """Act by another model of the same arm."""
        self.model = self.swap.model = model
        self.health.values["model"] = model.hash()

    def diagnosing(self) -> None:
        """The node's health is about to be told: bring ``health.values`` up to date."""

    def beat(self) -> None:
        """A bringup is about to hear how far the node is."""
        self.streams.count_partners()

    def release(self) -> None:
        """Let go of what ``configure`` took, streams aside."""

    # What it can rely on

    @property
    def needs_model(self) -> bool:
        """Whether it acts by a model."""
        return MODEL in self.OWN

    def value(self, name: str) -> Any:
        """A parameter's value."""
        return self.settings.value(name)

    def now(self) -> int:
        """ns of the node's clock: in simulated time the stamp of the step under way."""
        return self.loop.now()

    def publishers(self, topic: str) -> int:
        """How many nodes publish a topic of ours, whatever it was renamed to: rclpy counts those of a name
        as it stands.
        """
        return int(self.count_publishers(self.resolve_topic_name(topic)))

    def strangers(self, kind: str) -> list[str]:
        """Topics of that kind which others publish, and which are none of ours."""
        ours = {self.resolve_topic_name(topic) for topic in TOPICS.values()}
        there = [name for name, kinds in self.get_topic_names_and_types() if kind in kinds]
        return [name for name in sorted(there) if name not in ours and self.count_publishers(name)]

    def every(self, seconds: float, function: Callable[[], Any]) -> None:
        """Call a function by the wall's clock, until the streams are closed."""
        self.streams.own(self.destroy_timer, self.create_timer(seconds, function, clock=steady_clock()))

    def tell(self) -> None:
        """In simulated time, say how far the node is."""
        self.report.tell(self.simulated)

    def log(self, level: int, text: str) -> None:
        """A line in the log. What is odd in a bringup is said by that."""
        logger = self.get_logger()
        if level >= ERROR:
            logger.error(text)
        elif level > OK and not self.value("supervised"):
            logger.warning(text)
        else:
            logger.info(text)

    def set_parameters_atomically(self, parameter_list: list[Any]) -> Any:
        """As rclpy does; but one that holds from the start may be set to what it is: a dump can be loaded."""
        return super().set_parameters_atomically(parameters.meant(self, parameter_list))

    # Life

    def set_up(self) -> None:
        """But for diagnostics the node is silent until activated."""
        self.report.open()
        if self.needs_model:
            self.health.values["model"] = self.model.hash()
        self.configure()
        self.loop.start()

    def let_go(self) -> None:
        """End the streams, whatever else goes wrong."""
        try:
            self.release()
        finally:
            self.streams.close()

    def _step(self, now: int) -> None:
        if self.active:
            self.streams.guarded(self.tick, now)
        self.report.step(now)
