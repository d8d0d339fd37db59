"""Another joint's posture changes this joint's ratio."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.sources import STANDS, check_sources
from trunk_ros.parameter import Parameter

LEAST = 0.05  # of its ratio that a joint keeps: past that the first term of the expansion says nothing


class PostureRatio(Effect):
    """u *= 1 + gain s with s the angle of another joint.

    The length of wire between two guides is a smooth function of all joints that it passes. Ratio and
    coupling are its terms of first order in their angles; this is the mixed one of second order.
    """

    id = "posture_ratio"
    sizes = ("gain",)
    stage, place, regime = "wire", 35, "posture"
    exact = True
    signature = "The residual grows in proportion to the joint's angle, at a rate that another joint sets."
    source = (
        "The mixed term of the wire's length over two angles; wires that pass through bending sections: "
        "Camarillo, Milne, Carlson, Zinn & Salisbury (2008), IEEE Trans. Robotics 24(6)."
    )
    parameters = (
        Parameter(
            "gain", "1/rad", (-2.0, 2.0), "relative change of the ratio per angle of the source", typical=0.02
        ),
    )
    texts = ("source",)
    needs = ("several",)
    confused_with = (
        ("joint_coupling", "move the source while this joint stands at zero: only a coupling shows"),
        ("load_elasticity", "turn both joints so that the arm's reach stays the same"),
    )

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x * self._ratio(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y / self._ratio(now), None

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Both joints move: where one stands it is a coupling, or a ratio."""
        moved, own = np.ptp(now.wires, axis=0), np.ptp(now.gearbox * now.ratio, axis=0)
        sources = moved[[now.joints.index(s) for s in self.words.get("source", ()) if s]]
        return bool(min(*sources, *own) > STANDS * moved.max())

    def check(self, joints: tuple[str, ...]) -> None:
        super().check(joints)
        check_sources(self.id, [("gain", "source")], self.values, self.words, joints)

    def _ratio(self, now: Now) -> Array:
        """(n, columns) the ratio over its nominal one."""
        out = np.ones((len(now.stamp), len(now.ratio)))
        for column, source in enumerate(self.words.get("source", ())):
            if source and self["gain"][column] != 0.0:
                out[:, column] += self["gain"][column] * now.angles[:, now.joints.index(source)]
        return np.maximum(out, LEAST)
