"""What the effects share by which a joint sags under its load other than in proportion."""

from abc import abstractmethod
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Motion, Now
from trunk_ros.effects.wire.elements import beside
from trunk_ros.effects.wire.held_links import HeldLinks
from trunk_ros.effects.wire.link_resonance import LinkResonance
from trunk_ros.effects.wire.on_both_sides import HELD, OnBothSides
from trunk_ros.effects.wire.swinging_links import Links
from trunk_ros.guards import TINY
from trunk_ros.parameter import Parameter

SMALL = 1e-3  # of the moment at which a wire bends, to either side of a load: where its stiffness is taken
FIRM = 10.0  # times the moment at which a wire bends: more than that, friction is not held by it


class Sagging(OnBothSides):
    """theta += sag(tau), bent at a moment of load that is the first parameter; includes the stretch.

    held: all of it before the friction, and the masses beyond the joint swing on it (``HeldLinks``).
    """

    stage, place, regime = "wire", 200, "posture"
    begins = grows = True
    scalable = False
    needs = ("load",)
    everywhere = True
    replaces = ("load_elasticity",)
    shaking = (HELD,)
    includes = MappingProxyType({HELD: LinkResonance.id})
    dear = MappingProxyType({HELD: 3})

    bent: ClassVar[tuple[str, ...]]
    """The parameters by which it bends."""
    levels: ClassVar[tuple[float, ...]]
    """Quantiles of the load that a fit starts the bend at."""

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """None of a joint that is only pushed: a measured load then follows the angle, and what bends over
        the one bends over the other.
        """
        if motion.masses:
            return super().forms_shown(motion)
        return () if motion.one_way else tuple(f for f in super().forms_shown(motion) if f != HELD)

    @abstractmethod
    def drawn(self, load: Array) -> Array:
        """(n, columns) N m that would sag as a ``load`` (n, columns) N m does, in proportion."""

    def sag(self, load: Array) -> Array:
        """(n, columns) rad that a ``load`` (n, columns) N m adds."""
        return np.asarray(self["compliance"] * self.drawn(load))

    def _sag(self, now: Now) -> Array:
        key = (self.id, self.form, *(self[name].tobytes() for name in self.bent if name in self.values))
        return np.asarray(self["compliance"] * now.of_load(key, self.drawn))

    def adjust(self, core: Core, now: Now) -> None:
        """Of what lies before the friction: a joint that sticks holds back from none to all of the friction's
        moment F, width over compliance, so that the wire bears tau - F to tau + F. A dead band that would
        take more than FIRM times the moment at which the wire bends is not the wire's. Links swing on it as
        stiff as it is in the mean of all that.
        """
        soft, bends = self["compliance"], self[self.parameters[0].name]
        friction = np.minimum(core.width / np.maximum(soft, TINY), FIRM * bends)
        most, least = (self.sag(now.load + side * friction) for side in (1.0, -1.0))
        core.width = core.width - soft * friction + (most - least) / 2.0
        core.middle = core.middle + (most + least) / 2.0 - self._sag(now)
        links = Links.on_wires(self, now) if self.form == HELD else None
        if links is not None:
            within = np.maximum(friction, SMALL * bends)
            gives = (self.sag(now.load + within) - self.sag(now.load - within)) / 2.0
            held = HeldLinks(links, now, within / np.maximum(gives, TINY))
            core.rounding = beside(core.rounding, held, links.omega > 0.0)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._sag(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._sag(now), None

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        if parameter is not self.parameters[0]:
            return super().grid(parameter, now, column, rest)
        return tuple(max(1.5e-3, q) for q in np.quantile(np.abs(now.load[:, column]), self.levels))


def bend(name: str, meaning: str, typical: float) -> Parameter:
    """The moment [N m] at which the sag bends; out of reach where it is absent."""
    return Parameter(name, "N*m", (1e-3, 1e3), meaning, typical=typical, null=1e3, scale="log")
