"""Trajectories and references in, corrected setpoints out: the model run backward. Nothing here needs ROS.

As ros2_control has it: the node hears and says, ``update`` decides. Times are ns of the node's clock, angles
are (joints,) rad.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from trunk_ros.errors import TrunkError
from trunk_ros.model import Model
from trunk_ros.nodes.control.begin import Begin, Graph, elsewhere
from trunk_ros.nodes.control.compensation import Compensation
from trunk_ros.nodes.control.follower import Follower, limits_of
from trunk_ros.nodes.control.goal import State
from trunk_ros.nodes.control.observation import Observation
from trunk_ros.nodes.control.parameters import Settings
from trunk_ros.nodes.control.unseen import Unseen
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.joints import MessageError
from trunk_ros.trajectory import Array, Trajectory

LONGEST_STEP = 0.1  # s that the output may move on after a pause


class Command(NamedTuple):
    """What goes out: the setpoint at the gearbox, and the reference with its speed where it is our own.

    ``silent``: the setpoint is held, and not sent anew.
    """

    setpoint: Array
    reference: tuple[Array, Array] | None
    silent: bool = False


@dataclass
class Running:
    """What there is while an arm is controlled; ``idle``: it is held where it was found."""

    follower: Follower
    compensation: Compensation
    idle: bool = True


class Controller:
    """``note`` takes oddities, ``refused`` why a command is not followed, ``interrupted`` the reason why a
    goal under way is over.
    """

    def __init__(
        self,
        model: Model,
        settings: Settings,
        strict: bool,
        note: Callable[[str], None],
        refused: Callable[[str], None],
        interrupted: Callable[[str], None],
    ):
        """``strict``: time is simulated, see Newest."""
        self.model, self.settings, self.strict = model, settings, strict
        self.note, self.refused, self.interrupted = note, refused, interrupted
        self.joints = model.arm.joints
        still = np.zeros(len(self.joints))
        Compensation(model, 0.0, still).step(still, 0.01, still, still)  # compiles, so that no step is late
        self.stop()

    def stop(self) -> None:
        """Let go of the arm; all begins anew where it stands by then: others may move it in between."""
        self.observation = Observation(self.model, self.strict)
        self.running: Running | None = None
        self.foreign: Array | None = None
        self.begin, self.unseen = Begin(), Unseen()
        self.time: int | None = None
        self.limited = ""

    # Commands

    def follow(self, trajectory: Trajectory, now: int, begin: float | None, graph: Graph) -> float | None:
        """Replace what is under way; returns its end [s], None where it waits for the arm to say where it is.

        Raises TrunkError where it is refused.
        """
        if self.running is None:
            self.foreign, self.begin.waiting = None, (trajectory, begin)
            return None
        if graph.lost:
            raise MessageError("no trunk/gearbox_states")
        if not self.unseen.over:
            raise MessageError("the arm is not where it was sent: it has to rest before")
        end = self.running.follower.follow(trajectory, now / SECOND, begin)
        self.foreign, self.running.idle = None, False
        return end

    def start(self, now: int) -> bool:
        """Begin at once where it is known where the arm stands; tells whether the arm is controlled."""
        if self.running is None and self.observation.stands(now) is not None:
            self._begin(now)
        return self.running is not None

    def refer(self, given: Array) -> None:
        """Take a foreign reference, NaN where it leaves a joint as it is."""
        held = self.reference
        self.begin.waiting = None
        self.foreign = given if held is None else np.where(np.isfinite(given), given, held)
        if self.running is not None:
            self.running.idle = False

    def hold(self, now: int) -> None:
        """Stay where the reference is."""
        if self.running is not None and self.foreign is None:
            self.running.follower.stop(now / SECOND)
        self.begin.waiting = None

    def halt(self, now: int) -> None:
        """Stay where the reference is, a foreign one aside."""
        self.foreign = None
        self.hold(now)

    def rewound(self) -> None:
        """Time was set: the trajectory's is gone."""
        self.time = None
        if self.running is not None:
            self.running.follower.hold(self.running.follower.position)

    def use(self, model: Model) -> None:
        """Act by another model of the arm; the setpoint goes over without a jump."""
        self.model = model
        self.observation.use(model)
        if self.running is not None:
            self.running.compensation.swap(model)

    def adjust(self, settings: Settings) -> None:
        """Act by other settings."""
        self.settings = settings
        if self.running is not None:
            self.running.compensation.reversal = settings.reversal
            self.running.follower.limits = limits_of(self.model.arm, settings.max_acceleration)

    # State

    @property
    def reference(self) -> Array | None:
        """What is wanted of the joints, None before the start."""
        if self.foreign is not None:
            return self.foreign
        return None if self.running is None else self.running.follower.position

    @property
    def moves(self) -> bool:
        """Whether it sends the arm anywhere, rather than hold it where it was found."""
        return self.running is not None and not self.running.idle

    @property
    def settled(self) -> bool:
        """Whether it is under way, and no matter who else is on the graph."""
        return self.moves and not self.begin.blind

    def observation_of(self, topic: str) -> Callable[[int, State], None]:
        """A function that takes a stamp [ns] and a state: of the ``gearbox``, or of the ``joints``."""
        return lambda stamp, state: getattr(self.observation.measured, topic).put(stamp, state)

    def compared(self, now: int, fresh: bool) -> tuple[int, State, State]:
        """Stamp of the newest sample, what was wanted then, and what it shows; ``fresh``: of joint_states."""
        return self.observation.compared(now, fresh)

    # The loop

    def update(self, now: int, graph: Graph) -> Command | None:
        """One step; None while nothing may go out."""
        if graph.lost:
            self.observation.lose_sight()
        if self.running is None and not self._begin_when_known(now, graph):
            return None
        if self.begin.blind and not self._seen(now, graph):
            return None
        lost = self._lost(now, graph)
        assert self.running is not None
        if self.running.idle and graph.others:
            self.running = None  # somebody else moves the arm, who may leave it anywhere
            return None
        period = 0.0 if self.time is None else min(max((now - self.time) / SECOND, 0.0), LONGEST_STEP)
        self.time = now
        return self._step(self.running, now, period, lost, graph.fresh)

    def _step(self, running: Running, now: int, period: float, lost: bool, fresh: bool) -> Command:
        reference, velocity = self._sample(running.follower, now, lost)
        self.observation.remember(now, reference, velocity)
        own = None if self.foreign is not None else (reference, velocity)
        compensation = running.compensation
        if (running.idle or self.unseen.silent) and compensation.out is not None:
            self.limited = ""
            return Command(compensation.out, own, self.unseen.silent)
        settings, limited = self.settings.feedback, compensation.limited
        trim = self.observation.correction(now, fresh, settings, reference, limited, period)
        if self.settings.lead and self.foreign is None:
            ahead, *known = running.follower.state(now / SECOND + compensation.sight)
            out = compensation.step(ahead + trim, period, *known)
        else:
            out = compensation.step(reference + trim, period)
        held = compensation.limited
        self.limited = self.joints[int(np.argmax(held))] if held.any() else ""
        return Command(out, own)

    def _sample(self, follower: Follower, now: int, lost: bool) -> tuple[Array, Array]:
        """Reference and speed: of the foreign one, or of our own."""
        if lost:
            self.hold(now)
            self.interrupted("no trunk/gearbox_states")
        if self.foreign is None:
            return follower.sample(now / SECOND)[:2]
        if not lost:
            follower.hold(self.foreign)
        return follower.position, np.zeros(len(self.joints))

    # The start

    def _begin_when_known(self, now: int, graph: Graph) -> bool:
        wanted = self.begin.waiting is not None or self.foreign is not None
        known = self.observation.stands(now) is not None
        if not wanted:
            if not known or graph.lost or graph.others:
                return False
        elif not self.begin.due(now, known, self._blindly(graph), self.settings.patience):
            if self.begin.over(now, self.settings.patience):
                self.foreign = None
                why = f": {graph.lacking}" if graph.lacking else ""
                self.refused(f"refused: trunk/gearbox_states do not say where all joints stand{why}")
            return False
        self._begin(now, graph)
        return True

    def _blindly(self, graph: Graph) -> bool:
        """Whether it may be taken to stand at 0: motors that tell nothing, and none under another name."""
        return not graph.said and (self.settings.open_loop or not graph.strange)

    def _lost(self, now: int, graph: Graph) -> bool:
        """Whether it is not known where the arm stands. Where it rests elsewhere than it was sent when it is
        back, its driver is a new one, or others moved it: all starts anew from there.
        """
        if graph.lost:
            self.unseen.lost(now)
        if self.unseen.over:
            return False
        stands = self.observation.stands(now)
        if stands is None or not self.unseen.rests(now, stands, self._out):
            self.unseen.goes_on(now)
            return True
        if not elsewhere(stands, self._out):
            self.unseen = Unseen()
            return False
        self.note("the arm is back, and stands elsewhere than it was sent: starting anew from there")
        self.foreign = None  # what was asked before may be far from here
        self._begin(now)
        return False

    @property
    def _out(self) -> Array | None:
        return None if self.running is None else self.running.compensation.out

    def _seen(self, now: int, graph: Graph) -> bool:
        """Whether an arm that was taken to stand at 0 may be moved: nobody is there to say where it stands,
        or somebody has. Where it stands elsewhere than it was asked to, all starts anew from there.
        """
        stands = self.observation.stands(now)
        if stands is None:
            return self._blindly(graph)
        self.begin.blind = False
        if elsewhere(stands, self._out):
            self.note("the arm stands elsewhere than was thought: starting anew from there")
            self._begin(now, graph)
        return True

    def _begin(self, now: int, graph: Graph | None = None) -> None:
        """Start from where the arm stands, at 0 where that is not known."""
        known = self.observation.stands(now)
        self.time, waiting = None, self.begin.begun(known is None)
        self.unseen = Unseen()
        arm = self.model.arm
        stands = arm.asked(arm.rest) if known is None else known
        compensation = Compensation(self.model, self.settings.reversal, stands)
        start = compensation.joint_angle(stands)
        limits = limits_of(self.model.arm, self.settings.max_acceleration)
        self.running = Running(Follower(self.joints, limits, start), compensation, known is not None)
        if self.foreign is not None:
            self.foreign = np.where(np.isfinite(self.foreign), self.foreign, start)
            self.running.idle = False
        if waiting is not None and graph is not None:
            self._follow_waiting(waiting, now, graph)

    def _follow_waiting(self, waiting: tuple[Trajectory, float | None], now: int, graph: Graph) -> None:
        try:
            self.follow(waiting[0], now, waiting[1], graph)
        except TrunkError as error:
            self.refused(f"trajectory refused: {error}")
