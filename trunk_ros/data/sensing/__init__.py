"""Clocks and sensors before physics: what they do to a recording is looked for first, put right where that is
certain, and said.
"""

from trunk_ros.data.sensing.clocks import clocks_put_right
from trunk_ros.data.sensing.readings import readings_put_right, turns_counted_on

__all__ = ["clocks_put_right", "readings_put_right", "turns_counted_on"]
