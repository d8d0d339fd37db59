"""All that the nodes take from ROS 2, in one place, so that a machine without it gets one clear sentence."""

import os
import sys
from pathlib import Path

from trunk_ros.errors import TrunkError


def find_wheels() -> None:
    """Let the ament index see ROS packages that pip put into this environment.

    The wheels do not set AMENT_PREFIX_PATH, and a colcon overlay sets it without them.
    """
    index = Path(sys.prefix, "share", "ament_index", "resource_index", "packages", "rclpy")
    known = [entry for entry in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if entry]
    if index.exists() and sys.prefix not in known:
        os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join([*known, sys.prefix])


find_wheels()

try:
    import rclpy
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
    from builtin_interfaces.msg import Time
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
    from geometry_msgs.msg import PoseStamped
    from rcl_interfaces.msg import (
        FloatingPointRange,
        IntegerRange,
        ParameterDescriptor,
        SetParametersResult,
    )
    from rclpy.action import ActionServer, CancelResponse, GoalResponse
    from rclpy.clock import Clock as SteadyClock
    from rclpy.clock import ClockType
    from rclpy.event_handler import SubscriptionEventCallbacks
    from rclpy.exceptions import InvalidTopicNameException, ParameterException
    from rclpy.experimental import EventsExecutor
    from rclpy.impl.implementation_singleton import rclpy_implementation
    from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
    from rclpy.logging import LoggingSeverity
    from rclpy.node import Node
    from rclpy.parameter import Parameter
    from rclpy.qos import (
        DurabilityPolicy,
        HistoryPolicy,
        QoSCompatibility,
        QoSProfile,
        ReliabilityPolicy,
        qos_check_compatible,
    )
    from rclpy.serialization import deserialize_message
    from rclpy.signals import SignalHandlerOptions
    from rclpy.task import Future
    from rclpy.validate_full_topic_name import validate_full_topic_name
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import JointState, PointCloud2, PointField
    from std_msgs.msg import String
    from std_srvs.srv import SetBool, Trigger
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
except ImportError as error:
    raise TrunkError(
        f"this command needs ROS 2 ({error}): "
        "pip install '.[ros]' in this environment, or source a ROS 2 installation"
    ) from None

INFO, WARNING = LoggingSeverity.INFO, LoggingSeverity.WARN
RCLError, RMWError = rclpy_implementation.RCLError, rclpy_implementation.RMWError

try:
    from control_msgs.action import FollowJointTrajectory
    from control_msgs.msg import JointTrajectoryControllerState
except ImportError:  # not among the packages that PyPI has
    FollowJointTrajectory = JointTrajectoryControllerState = None

try:
    from geometry_msgs.msg import TransformStamped
    from tf2_msgs.msg import TFMessage
except ImportError:  # likewise
    TFMessage = TransformStamped = None

__all__ = [
    "INFO",
    "WARNING",
    "ActionServer",
    "CancelResponse",
    "Clock",
    "ClockType",
    "DiagnosticArray",
    "DiagnosticStatus",
    "DurabilityPolicy",
    "EventsExecutor",
    "FloatingPointRange",
    "FollowJointTrajectory",
    "Future",
    "GoalResponse",
    "HistoryPolicy",
    "IntegerRange",
    "InvalidTopicNameException",
    "JointState",
    "JointTrajectory",
    "JointTrajectoryControllerState",
    "JointTrajectoryPoint",
    "KeyValue",
    "LifecycleNode",
    "LifecycleState",
    "Node",
    "PackageNotFoundError",
    "Parameter",
    "ParameterDescriptor",
    "ParameterException",
    "PointCloud2",
    "PointField",
    "PoseStamped",
    "QoSCompatibility",
    "QoSProfile",
    "RCLError",
    "RMWError",
    "ReliabilityPolicy",
    "SetBool",
    "SetParametersResult",
    "SignalHandlerOptions",
    "SteadyClock",
    "String",
    "SubscriptionEventCallbacks",
    "TFMessage",
    "Time",
    "TransformStamped",
    "TransitionCallbackReturn",
    "Trigger",
    "deserialize_message",
    "get_package_share_directory",
    "qos_check_compatible",
    "rclpy",
    "validate_full_topic_name",
]
