"""The wire beyond the paper's two lumps: friction spread over the arcs of an antagonistic pair."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm import Wire
from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.wire.elements import beside
from trunk_ros.effects.wire.wire_pair import WirePair
from trunk_ros.errors import ModelError
from trunk_ros.parameter import Parameter

PIECES = 6  # of each arc


class DistributedWire(Effect):
    """In place of the play: the joint stands where two wires under pretension T carry its load.

    T_forward(l) - T_back(l) + tau/R_c = 0 at the joint; along both arcs abs(dT/dalpha) <= mu T, and the wire
    slips where they are equal; stretch = integral of T/(E A_s) over l', l'' and the third one, l - l' - l''.

    In full slip w = T l/(E A_s R_c) (c+ - c-)/(c+ + c-), theta += c+ c-/(c+ + c-) l/(E A_s R_c^2) tau, with
    c+- the mean over the wire of exp(+-mu alpha) between a place and the joint; once a wire is slack, twice
    that. What other effects add to the dead band acts before the pair.
    """

    id = "distributed_wire"
    stage, place, regime = "wire", 100, "reversal"
    signature = (
        "Backlash in proportion to the pretension; under load the joint sags late, in loops, "
        "and past some load more."
    )
    source = (
        "Euler-Eytelwein along the arcs, T(alpha) = T exp(+-mu alpha); "
        "Palli et al. (2012), Mechatronics 22(6): partial slip."
    )
    parameters = (
        Parameter("pretension", "N", (0.0, 1e3), "tension of both wires at rest", typical=8.0),
        Parameter(
            "friction",
            "1",
            (0.0, 20.0),
            "friction coefficients over nominal",
            typical=1.0,
            null=1.0,
            optional=True,
        ),
    )
    tried = False
    needs = ("load",)
    replaces = ("load_elasticity", "wire_slack", "wire_stiffening", "presliding_hysteresis")
    confused_with = (
        ("tension_error", "load the joint: the paper's dead band is a matter of tension alone"),
        ("load_elasticity", "load and unload slowly: only friction makes a loop of it"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        if not np.any(self["pretension"] > 0.0):
            return
        if core.wire is None:
            raise ModelError("effects.distributed_wire wants the wire's formula: wire.shaft_radius and so on")
        soft, grip = self._pieces(core.wire)
        pair = WirePair(
            self["pretension"], core.wire.cylinder_radius, soft, grip, core.nominal_width, now.load
        )
        core.rounding = beside(core.rounding, pair, self["pretension"] > 0.0)

    def _pieces(self, wire: Wire) -> tuple[Array, Array]:
        """The wire's stretches, worked out once."""
        if self._known is None or self._known[0] is not wire:
            self._known = (wire, pieces_of(wire, self["friction"]))
        return self._known[1]

    _known: tuple[Wire, tuple[Array, Array]] | None = None


def pieces_of(wire: Wire, friction: Array) -> tuple[Array, Array]:
    """Softness (joints, k) m/N of the stretches from wheel to joint, mu d_alpha (joints, k - 1) between them.

    The arcs lie at the ends of l' and l'', on the radius of the grooved wheel.
    """
    columns: list[Array] = []
    grips: list[Array] = []
    for angle, mu, straight in ((wire.a1, wire.mu1, wire.length1), (wire.a2, wire.mu2, wire.length2)):
        piece = angle * wire.shaft_radius / PIECES
        start = np.maximum(straight - PIECES * piece, 0.0) + piece / 2
        if columns:
            start = start + columns.pop()
        columns += [start, *[piece] * (PIECES - 1), piece / 2]
        grips += [friction * mu * angle / PIECES] * PIECES
    columns[-1] = columns[-1] + np.maximum(wire.length - wire.length1 - wire.length2, 1e-4)
    soft = np.column_stack(columns) / (wire.modulus * wire.section)
    return np.ascontiguousarray(soft), np.column_stack(grips)
