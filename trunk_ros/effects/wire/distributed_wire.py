"""The wire beyond the paper's two lumps: friction spread over the arcs of an antagonistic pair under pretension."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from trunk_ros.arm import Wire
from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.effects.wire.pair import pair_step
from trunk_ros.effects.wire.play import JITTER
from trunk_ros.errors import ModelError
from trunk_ros.parameter import Parameter

PIECES = 6  # of each arc


class DistributedWire(Effect):
    """In place of the play: the joint stands where the tensions of both wires carry its load,
    T_forward(l) - T_back(l) + tau/R_c = 0, with dT/dalpha between -mu T and mu T along both arcs,
    stretch = integral of T/(E A_s) over l', l'' and the third stretch l - l' - l'', and T = pretension at rest.

    In full slip the half-width is w = T l/(E A_s R_c) (c+ - c-)/(c+ + c-), c+- the means of exp(+-mu alpha) between a
    place and the joint over the wire; under load the joint gives way by c+ c-/(c+ + c-) l/(E A_s R_c^2) until a wire is
    slack, then twice that. What other effects add to the dead band acts before the pair.
    """

    id = "distributed_wire"
    stage, place, regime = "wire", 100, "reversal"
    signature = "A dead band in proportion to the pretension; under load the joint sags late, in loops, and past some load more."
    source = "Euler-Eytelwein along the arcs, T(alpha) = T exp(+-mu alpha); Palli et al. (2012), Mechatronics 22(6): partial slip."
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
            raise ModelError(
                "effects.distributed_wire wants the wire's formula in the model: wire.shaft_radius and the like"
            )
        core.rounding = WirePair(self, core.wire, core.nominal_width, now.load)

    @cached_property
    def geometry(self) -> dict[int, tuple[Array, Array]]:
        """Stretches and grips by the identity of a wire: filled by ``pieces_of``."""
        return {}


def pieces_of(wire: Wire, friction: Array) -> tuple[Array, Array]:
    """Softness (joints, k) m/N of the stretches from the wheel to the joint, and mu d_alpha (joints, k - 1) between them.

    The arcs lie at the ends of l' and l'', on the radius of the grooved wheel.
    """
    columns, grips = [], []
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


class WirePair:
    """A friction element: the pair's tensions are its memory."""

    def __init__(self, effect: DistributedWire, wire: Wire, nominal: Array, load: Array):
        self.soft, self.grip = pieces_of(wire, effect["friction"])
        self.tension, self.radius = effect["pretension"], wire.cylinder_radius
        self.nominal, self.load = nominal, load

    def run(self, u: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.run; state: the play before the pair, input and output (3, columns), tensions, slack."""
        memory = self._memory(u, state)
        out = np.empty_like(u)
        added = np.maximum(width - self.nominal, 0.0)
        run_pair(
            u, added, self.load, self.tension > 0.0, width, self.radius, self.soft, self.grip, *memory, out
        )
        return out, memory

    def _memory(self, u: Array, state: Any) -> tuple[Array, Array, Array]:
        if state is not None:
            return tuple(part.copy() for part in state)
        columns, stretches = self.soft.shape
        tension = np.broadcast_to(self.tension[:, None, None], (columns, 2, stretches)).copy()
        return np.tile(u[0], (3, 1)), tension, np.zeros((columns, 2))
