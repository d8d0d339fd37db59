"""The arm: joints and transmission, and its rigid links by Pinocchio, from a URDF or as a planar chain."""

from trunk_ros.arm.arm import GRAVITY, LOADS, Arm, check_length
from trunk_ros.arm.wire import Wire

__all__ = ["GRAVITY", "LOADS", "Arm", "Wire", "check_length"]
