"""Mix-ups that no physics explains: degrees for radians, encoder counts, swapped joints, motors for joints,
turned signs, clocks that are seconds apart, joints that a hand guides, readings that are stuck or given
twice, effort that is no torque. They are reported, never repaired: what is mixed up is not diagnosed.
"""

from trunk_ros.data.mix_ups.doubtful import doubtful
from trunk_ros.data.mix_ups.find import as_if_standing, mix_ups, without_mix_ups
from trunk_ros.data.mix_ups.no_torque import without_torque
from trunk_ros.data.mix_ups.pair import MixUp

__all__ = ["MixUp", "as_if_standing", "doubtful", "mix_ups", "without_mix_ups", "without_torque"]
