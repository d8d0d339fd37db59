"""References that others publish, told from our own, which come back on the same topic."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.joints import JointMatcher, MessageError
from trunk_ros.nodes.graph.reader import unpacked
from trunk_ros.nodes.graph.ros import JointState
from trunk_ros.trajectory import Array

REMEMBERED = 1000  # stamps of our own messages
ROUNDING = 1e-9  # rad
STAMP = slice(4, 12)  # bytes of the stamp in a serialised message with a header


class ForeignReference:
    """Knows our own messages by stamp and angles, without unpacking each.

    In simulated time others stamp as we do. One of theirs that asks for the same as ours may pass for ours.
    """

    def __init__(self, arm: Arm):
        self.arm = arm
        self.matcher = JointMatcher(arm.joints)
        self._ours: dict[bytes, bytes] = {}

    def sent(self, ns: int, position: Array) -> None:
        """Note stamp and angles (joints,) rad of one of our own."""
        seconds, rest = divmod(ns, SECOND)
        stamp = seconds.to_bytes(4, "little") + rest.to_bytes(4, "little")
        self._ours[stamp] = position.tobytes()
        if len(self._ours) > REMEMBERED:
            del self._ours[next(iter(self._ours))]

    def message(self, raw: bytes) -> Any:
        """The message, None where it is our own."""
        ours = self._ours.get(raw[STAMP])
        return None if ours is not None and ours in raw else unpacked(raw, JointState)

    def position(self, message: Any) -> Array:
        """Wanted angles (joints,) rad, NaN where it has none.

        Raises MessageError where one is no number, or outside the joint's limits.
        """
        given = self.matcher.gather(message.name, message.position)
        named = [joint not in self.matcher.missing for joint in self.matcher.joints]
        if len(message.position) and not np.isfinite(given[named]).all():
            raise MessageError("reference refused: not a number")
        lower, upper = self.arm.lower, self.arm.upper
        if (outside := (given < lower - ROUNDING) | (given > upper + ROUNDING)).any():
            j = int(np.argmax(outside))
            raise MessageError(
                f"reference refused: {self.arm.joints[j]} at {given[j]:.4f} rad is outside "
                f"{lower[j]:.4f} ... {upper[j]:.4f}; holding the last one"
            )
        return given
