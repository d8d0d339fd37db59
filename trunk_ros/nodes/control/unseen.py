"""When the motors fall silent: how long setpoints go on, and what is made of where the arm is then."""

from __future__ import annotations

import numpy as np

from trunk_ros.nodes.control.begin import ELSEWHERE, elsewhere
from trunk_ros.nodes.control.observation import SETTLE
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.trajectory import Array


class Unseen:
    """Times are ns. ``silent``: nothing goes out any more.

    A driver that goes on holds what it was sent last; one that was started anew must not be sent to a place
    that the arm has left.
    """

    def __init__(self) -> None:
        self.silent = False
        self._since: int | None = None
        self._stood: tuple[int, Array] | None = None

    @property
    def over(self) -> bool:
        """Whether it is known where the arm stands."""
        return self._since is None

    def goes_on(self, now: int) -> None:
        """Nobody says where the arm stands: setpoints go on until the output is back from its lead."""
        self._since = now if self._since is None else self._since
        self.silent |= not 0 <= now - self._since < SETTLE * SECOND

    def lost(self, now: int) -> None:
        """The motors are silent."""
        self.goes_on(now)
        self._stood = None

    def rests(self, now: int, stands: Array, sent: Array | None) -> bool:
        """Whether the arm is where it was ``sent``, or rests elsewhere: one on its way may only be late."""
        if not elsewhere(stands, sent):
            return True
        at, stood = self._stood or (now, stands)
        if now < at or np.abs(stands - stood).max() > ELSEWHERE:
            at, stood = now, stands
        self._stood = at, stood
        return now - at >= SETTLE * SECOND
