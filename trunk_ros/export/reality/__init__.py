"""What a simulator lacks, laid around it: commands on their way in, joint states on their way out."""

from trunk_ros.export.reality.layer import RealityLayer
from trunk_ros.export.reality.plant import Plant

__all__ = ["Plant", "RealityLayer"]
