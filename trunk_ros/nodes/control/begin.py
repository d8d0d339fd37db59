"""When to begin: where the arm stands has to be known first, or nobody may be there to say it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.trajectory import Array, Trajectory

ELSEWHERE = 0.02  # rad at the gearbox between where an arm was sent unseen and where it then shows to be


@dataclass(frozen=True)
class Graph:
    """What a node knows of its topics: ``said``: somebody publishes gearbox_states; ``lost``: they dried up;
    ``fresh``: joint_states come; ``others``: somebody else publishes setpoints; ``strange``:
    somebody publishes states of joints on a topic that is none of ours; ``lacking``: in words, what
    is missing of gearbox_states.
    """

    said: bool = True
    lost: bool = False
    fresh: bool = False
    others: bool = False
    strange: bool = False
    lacking: str = ""


class Begin:
    """A command that waits (``waiting``: a trajectory and when it begins [s]), and since when [ns].

    ``blind``: it was begun in open loop, the arm taken to stand at 0.
    """

    def __init__(self) -> None:
        self.waiting: tuple[Trajectory, float | None] | None = None
        self.blind = False
        self._since: int | None = None

    def due(self, now: int, known: bool, blindly: bool, patience: float) -> bool:
        """Whether a command may begin. ``blindly``: also unseen, once who says where the arm stands has had
        the time to be found.
        """
        self._since = now if self._since is None else self._since
        if known:
            return True
        return blindly and not (self.waiting is not None and self._patient(now, patience))

    def over(self, now: int, patience: float) -> bool:
        """Whether the command has waited too long; it is given up then."""
        if self._patient(now, patience):
            return False
        self.waiting = self._since = None
        return True

    def begun(self, blind: bool) -> tuple[Trajectory, float | None] | None:
        """It has begun; returns what waited for it."""
        waiting, self.waiting, self._since, self.blind = self.waiting, None, None, blind
        return waiting

    def _patient(self, now: int, patience: float) -> bool:
        return self._since is not None and now - self._since < patience * SECOND


def elsewhere(stands: Array, sent: Array | None) -> bool:
    """Whether an arm shows to stand elsewhere (joints,) than it was sent to."""
    return sent is None or bool(np.abs(stands - sent).max() > ELSEWHERE)
