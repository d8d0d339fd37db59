"""Whether the joints go where they are sent: what came of each way from rest to rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.trajectory import Array

WAY = 0.1  # rad: backlash, sag and drift are a small part of it
MISSED = 0.25  # of a way: more than effects of a wire do; a wrong ratio, sign or sensor does more
REST = 0.5  # s that the reference stands before joints are looked at: a servo of kp 5 1/s is there to 8 %


class Ways:
    """Times are ns. Joints that arrive late take back what was said of them."""

    def __init__(self, joints: Sequence[str]):
        self.joints = tuple(joints)
        self._wanted = self._began = self._stood = np.full(len(self.joints), np.nan)
        self._since = 0
        self._arrived: tuple[Array, Array] | None = None
        self._words = [""] * len(self.joints)

    @property
    def missed(self) -> str:
        """In words what joints did instead, "" where all did what they were sent to do last."""
        told = [words for words in self._words if words]
        asked = "does the model have ratio, sign and sensor right, and is the joint free?"
        return f"{'; '.join(told)}: {asked}" if told else ""

    def see(self, now: int, wanted: Array, actual: Array) -> None:
        """At ``now`` ns joints (joints,) rad are ``wanted`` and measured as ``actual``."""
        if not np.array_equal(wanted, self._wanted):
            self._leave(now, wanted)
        elif now - self._since >= REST * SECOND:
            self._arrived = wanted, actual
            self._judge(wanted - self._began, actual - self._stood)

    def _leave(self, now: int, wanted: Array) -> None:
        """The reference moves on: where it rested a way begins, unless the last one was too short to tell."""
        self._wanted, self._since = wanted.copy(), now
        if self._arrived is None:
            return
        (rested, stood), self._arrived = self._arrived, None
        anew = ~(np.abs(rested - self._began) <= WAY)
        self._began = np.where(anew, rested, self._began)
        self._stood = np.where(anew, stood, self._stood)

    def _judge(self, way: Array, came: Array) -> None:
        for j, joint in enumerate(self.joints):
            if not (abs(way[j]) > WAY and np.isfinite(came[j])):
                continue
            far = abs(came[j] - way[j]) > MISSED * abs(way[j])
            told = f"{joint} went {came[j]:+.2f} rad where {way[j]:+.2f} rad was asked"
            self._words[j] = told if far else ""
