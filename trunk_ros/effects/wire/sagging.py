"""What the effects share by which a joint sags under its load other than in proportion."""

from abc import abstractmethod
from collections import deque
from collections.abc import Hashable
from typing import Any, ClassVar

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Motion, Now
from trunk_ros.effects.wire.on_both_sides import OnBothSides
from trunk_ros.guards import TINY
from trunk_ros.parameter import Parameter

LAST: deque[tuple[Hashable, Array, Array]] = deque(maxlen=2)
"""What loads draw, by what bends and the load: of a whole recording, and of how it began."""
FIRM = 10.0  # times the moment at which a wire bends: more than that, friction is not held by it


class Sagging(OnBothSides):
    """theta += sag(tau), bent at a moment of load that is the first parameter; includes the stretch."""

    stage, place, regime = "wire", 200, "posture"
    begins = grows = True
    scalable = False
    needs = ("load",)
    everywhere = True
    replaces = ("load_elasticity",)

    bent: ClassVar[tuple[str, ...]]
    """The parameters by which it bends."""
    levels: ClassVar[tuple[float, ...]]
    """Quantiles of the load that a fit starts the bend at."""

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """None of a joint that is only pushed: a measured load then follows the angle, and what bends over
        the one bends over the other.
        """
        return () if motion.one_way and not motion.masses else super().forms_shown(motion)

    @abstractmethod
    def drawn(self, load: Array) -> Array:
        """(n, columns) N m that would sag as a ``load`` (n, columns) N m does, in proportion."""

    def sag(self, load: Array) -> Array:
        """(n, columns) rad that a ``load`` (n, columns) N m adds. What it draws is kept: both sides of the
        friction ask for it, and a fit again with another compliance.
        """
        key = (self.id, self.form, *(self[name].tobytes() for name in self.bent if name in self.values))
        drawn = next((drawn for known, of, drawn in tuple(LAST) if of is load and known == key), None)
        if drawn is None:
            drawn = self.drawn(load)
            LAST.append((key, load, drawn))
        return np.asarray(self["compliance"] * drawn)

    def adjust(self, core: Core, now: Now) -> None:
        """Of what lies before the friction: a joint that sticks holds back from none to all of the friction's
        moment F, width over compliance, so that the wire bears tau - F to tau + F. A dead band that would
        take more than FIRM times the moment at which the wire bends is not the wire's.
        """
        soft = self["compliance"]
        friction = np.minimum(core.width / np.maximum(soft, TINY), FIRM * self[self.parameters[0].name])
        most, least = (soft * self.drawn(now.load + side * friction) for side in (1.0, -1.0))
        core.width = core.width - soft * friction + (most - least) / 2.0
        core.middle = core.middle + (most + least) / 2.0 - self.sag(now.load)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self.sag(now.load), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self.sag(now.load), None

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        if parameter is not self.parameters[0]:
            return super().grid(parameter, now, column, rest)
        return tuple(max(1.5e-3, q) for q in np.quantile(np.abs(now.load[:, column]), self.levels))


def bend(name: str, meaning: str, typical: float) -> Parameter:
    """The moment [N m] at which the sag bends; out of reach where it is absent."""
    return Parameter(name, "N*m", (1e-3, 1e3), meaning, typical=typical, null=1e3, scale="log")
