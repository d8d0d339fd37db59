"""Joints are matched by name, whatever the order and number in which a message has them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trunk_ros.errors import TrunkError
from trunk_ros.trajectory import Array

LARGEST = 1e6  # rad: an angle beyond is none


class MessageError(TrunkError):
    """A message cannot be used; the node says so on diagnostics and goes on."""


class StrangersError(MessageError):
    """A message speaks of other joints alone."""


class JointMatcher:
    """Brings the values of messages into the order of ``joints``.

    ``unknown`` and ``missing`` name what the last message had too much and too little.
    """

    def __init__(self, joints: Sequence[str]):
        self.joints = tuple(joints)
        self.unknown: tuple[str, ...] = ()
        self.missing: tuple[str, ...] = ()
        self._names: list[str] | None = None
        self._as_is = False
        self._from: list[int] = []
        self._to: list[int] = []

    def match(self, names: Sequence[str]) -> None:
        """Prepare for messages with these names. Raises MessageError where one comes twice or none fits."""
        if names == self._names:
            return
        names = list(names)
        if len(set(names)) != len(names):
            raise MessageError(f"a joint is named twice: {', '.join(names)}")
        known = [name for name in names if name in self.joints]
        self.unknown = tuple(name for name in names if name not in self.joints)
        self.missing = tuple(joint for joint in self.joints if joint not in names)
        self._names = None
        if not known:
            raise StrangersError(f"no joint of {', '.join(names) or 'an empty list'} belongs to the arm")
        self._from = [names.index(name) for name in known]
        self._to = [self.joints.index(name) for name in known]
        self._names, self._as_is = names, tuple(names) == self.joints

    def gather(self, names: Sequence[str], values: Sequence[float]) -> Array:
        """Values (joints,) in the arm's order, NaN where the message has none; a field may be empty.

        Raises MessageError where names and values do not go together.
        """
        self.match(names)
        if not len(values):
            return np.full(len(self.joints), np.nan)
        if len(values) != len(names):
            raise MessageError(f"{len(names)} names but {len(values)} values")
        if self._as_is:
            return np.array(values, dtype=float)
        out = np.full(len(self.joints), np.nan)
        out[self._to] = np.asarray(values, dtype=float)[self._from]
        return out

    def angles(self, names: Sequence[str], values: Sequence[float]) -> Array:
        """As ``gather``, of angles [rad]. Raises MessageError for numbers that no joint can be at as well."""
        found = self.gather(names, values)
        if (wild := np.abs(found) > LARGEST).any():
            j = int(np.argmax(wild))
            raise MessageError(f"{self.joints[j]} at {found[j]:.3g} rad is no angle: a sample was left out")
        return found

    def lacking(self) -> str:
        """What the last message did not have, and what it may have had instead; "" where it had all."""
        unknown = f", {_are(self.unknown)} unknown" if self.unknown else ""
        return f"{_are(self.missing)} missing{unknown}" if self.missing else ""

    def oddities(self) -> list[str]:
        """What is wrong with the names, in words."""
        said = [f"unknown joint {name} ignored" for name in self.unknown]
        return said + [f"joint {name} missing" for name in self.missing]


def _are(names: Sequence[str]) -> str:
    return f"{', '.join(names)} {'is' if len(names) == 1 else 'are'}"
