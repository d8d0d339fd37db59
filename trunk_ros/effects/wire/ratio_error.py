"""The ratio of the radii is not the nominal one."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class RatioError(Effect):
    """u = r (1 + relative) phi."""

    id = "ratio_error"
    sizes = ("relative",)
    stage, place, regime = "wire", 10, "posture"
    exact = True
    begins = of_every_joint = in_coupling = True
    changes = "ratio"
    signature = "The residual grows in proportion to the joint angle."
    source = "Ciofu & Stan, sect. 2: transmission ratio R_s/R_c; wear and tolerance of the grooved wheels."
    parameters = (
        Parameter(
            "relative", "1", (-100.0, 100.0), "relative error of the ratio", typical=0.005, relative=True
        ),
    )
    confused_with = (("load_elasticity", "move the other joints while this one stands: only a load changes"),)

    @classmethod
    def changed(cls, number: Any, values: Mapping[str, Any]) -> Any:
        return number * (1.0 + values.get("relative", 0.0))

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x * (1.0 + self["relative"]), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        ratio = 1.0 + self["relative"]
        return y / np.where(ratio == 0.0, np.inf, ratio), None  # a wire that moves nothing is left alone
