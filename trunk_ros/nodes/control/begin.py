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
    ``fresh``: joint_states come; ``others``: somebody else publishes setpoints; ``lacking``: in words, the
    joints that gearbox_states leave out.
    """

    said: bool = True
    lost: bool = False
    fresh: bool = False
    others: bool = False
    lacking: str = ""


class Begin:
    """A command that waits (``waiting``: a trajectory and when it begins [s]), and since when [ns].

    ``blind``: it was begun unseen, the arm taken to stand at 0.
    """

    def __init__(self) -> None:
        self.waiting: tuple[Trajectory, float | None] | None = None
        self.blind = False
        self._since: int | None = None

    def due(self, now: int, known: bool, said: bool, patience: float) -> bool:
        """Whether a command may begin: who says where the arm stands may not have been found yet."""
        self._since = now if self._since is None else self._since
        if known:
            return True
        return not said and not (self.waiting is not None and self._patient(now, patience))

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

    def elsewhere(self, stands: Array, asked: Array | None) -> bool:
        """Whether an arm shows to stand elsewhere (joints,) than it was sent to."""
        return asked is None or bool(np.abs(stands - asked).max() > ELSEWHERE)

    def _patient(self, now: int, patience: float) -> bool:
        return self._since is not None and now - self._since < patience * SECOND
