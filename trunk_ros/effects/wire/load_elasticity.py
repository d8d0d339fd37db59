"""The wire stretches under the load moment of the joint."""

from types import MappingProxyType
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Motion, Now
from trunk_ros.effects.wire.elements import beside
from trunk_ros.effects.wire.held_links import HeldLinks
from trunk_ros.effects.wire.link_resonance import LinkResonance
from trunk_ros.effects.wire.on_both_sides import HELD, UPSTREAM, OnBothSides
from trunk_ros.effects.wire.swinging_links import Links
from trunk_ros.parameter import Parameter

STEEPEST = 5.0  # of the compliance's logarithm
SPANS = 0.1  # of load times angle: what no parabola of either follows

COMPLIANCE = Parameter(
    "compliance", "rad/(N*m)", (0.0, 1e3), "deflection per moment", typical=0.03, stated="compliance"
)
PAYLOAD = Parameter(
    "payload", "kg", (0.0, 20.0), "mass at the tip", typical=0.05, shared=True, optional=True, carried=True
)


DAMPING = Parameter(
    "damping", "1", (0.002, 0.95), "damping ratio of the straight arm", typical=0.1, null=0.1, scale="log",
    scan=(0.05, 0.3),
)  # fmt: skip
SLOPE = Parameter(
    "slope", "1/rad", (-5.0, 5.0), "how fast the compliance grows with the wire's angle, in parts of itself",
    typical=0.2, scan=(-0.3, 0.3),
)  # fmt: skip


class LoadElasticity(OnBothSides):
    """weight: theta += compliance tau; lever: theta += compliance exp(slope r phi) tau; links: the masses
    beyond the joint swing on the same spring, compliance (M(q) theta'' + d (theta' - p')) + theta - p =
    compliance tau; held: all of it before the friction, by which the links stick and slip.
    """

    id = "load_elasticity"
    sizes = ("compliance",)
    stage, place, regime = "wire", 200, "posture"
    begins = grows = True
    signature = "The joint sags under weight: the residual follows the reach of all that hangs on the joint."
    source = (
        "Hooke: compliance = l_i/(E A_s R_c^2); Ciofu & Stan, sect. 4: "
        "deformation from the resistance moment. lever: R_c changes with the angle where the wire pulls at a "
        "lever and not at a wheel. links: Spong (1987), J. Dyn. Syst. 109(4), eq. (5). held: Moreau (1988), "
        "in Nonsmooth Mechanics and Applications, for dry friction in several joints at once."
    )
    parameters = (COMPLIANCE, PAYLOAD, UPSTREAM, DAMPING, SLOPE)
    forms = ("weight", "lever", "links", HELD)
    refined = ("lever", "links", HELD)
    shaking = ("links", HELD)
    dear = MappingProxyType({"links": 2, HELD: 3})
    includes = MappingProxyType(dict.fromkeys(shaking, LinkResonance.id))
    needs = ("load",)
    everywhere = True
    confused_with = (
        ("ratio_error", "move the other joints: a ratio error does not care"),
        ("joint_coupling", "reach the same moment with different joints"),
    )

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """A compliance that changes with the angle looks like a mass that is not known well."""
        return ("weight", "links", HELD) if motion.masses else ("weight", "lever")

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        own = {"links": (DAMPING,), HELD: (DAMPING,), "lever": (SLOPE,)}.get(form, (UPSTREAM,))
        return (COMPLIANCE, PAYLOAD, *own)

    def adjust(self, core: Core, now: Now) -> None:
        links = Links.on_wires(self, now) if self.form == HELD else None
        if links is not None:
            core.rounding = beside(core.rounding, HeldLinks(links, now), links.omega > 0.0)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        sagged = x + self._sag(now)
        links = None if self.form == HELD else Links.on_wires(self, now)
        return (sagged, None) if links is None else links.run(sagged, now, state)

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        links = None if self.form == HELD else Links.on_wires(self, now)
        still, state = (y, None) if links is None else links.invert(y, now, state)
        return still - self._sag(now), state

    def credible(self, now: Now, beside: bool = False) -> bool:
        """A lever: where load and angle change independently. Where one follows from the other, as when a tip
        is pushed, a wire that hardens or a curve of the angle does the same.
        """
        if self.form != "lever":
            return True
        load, angle = (signal - signal.mean() for signal in (now.load[:, 0], (now.ratio * now.gearbox)[:, 0]))
        both = load * angle
        told = np.column_stack([np.ones_like(load), angle, load, angle**2, load**2])
        left = both - told @ np.linalg.lstsq(told, both, rcond=None)[0]
        return bool(np.std(left) > SPANS * np.std(load) * np.std(angle) > 0.0)

    def _sag(self, now: Now) -> Array:
        if self.form != "lever":
            return np.asarray(self["compliance"] * now.load)
        grown = np.exp(np.clip(self["slope"] * now.ratio * now.gearbox, -STEEPEST, STEEPEST))
        return np.asarray(self["compliance"] * grown * now.load)
