"""The base stands tilted."""

from typing import ClassVar

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.geometric import FrameError
from trunk_ros.parameter import Parameter

ABOUT = {"angle": 3, "angle_y": 4, "angle_z": 5}


class BaseTilt(FrameError):
    """The tip turns about the base's X axis by ``angle``; out of the plane, also about Y and Z."""

    id = "base_tilt"
    stage, place, regime = "arm", 200, "always"
    signature = "The whole arm's picture is turned about the base, the roll is off by a constant."
    source = (
        "Mooring, Roth & Driels, Fundamentals of Manipulator Calibration (1991), ch. 3: base frame error."
    )
    parameters = tuple(
        Parameter(
            name, "rad", (-1.0, 1.0), f"turn about +{axis}", typical=2e-3, shared=True, optional=axis != "X"
        )
        for name, axis in zip(ABOUT, "XYZ", strict=True)
    )
    rows: ClassVar = ABOUT
    in_plane = True

    def frame(self, core: Core) -> Array:
        return core.geometry.base
