"""/tf of an arm, where tf2_msgs is installed."""

from __future__ import annotations

from typing import Any

from trunk_ros.arm import Arm
from trunk_ros.arm.frames import Frames
from trunk_ros.nodes.graph.messages import time_message
from trunk_ros.nodes.graph.ros import TFMessage, TransformStamped
from trunk_ros.trajectory import Array


class FrameStream:
    """Publishes all links' transforms; nothing where the message is not there."""

    def __init__(self, streams: Any, arm: Arm):
        self._send = None if TFMessage is None else streams.publish(TFMessage, "/tf")
        self._frames = None if TFMessage is None else Frames(arm)

    def publish(self, ns: int, theta: Array, prefix: str = "") -> None:
        """The transforms of joint angles (joints,) at ``ns``."""
        if self._frames is None or self._send is None:
            return
        message = TFMessage()
        for (parent, child), values in zip(
            self._frames.pairs, self._frames.transforms(theta).tolist(), strict=True
        ):
            one = TransformStamped(child_frame_id=prefix + child)
            one.header.frame_id, one.header.stamp = prefix + parent, time_message(ns)
            move, turn = one.transform.translation, one.transform.rotation
            move.x, move.y, move.z, turn.x, turn.y, turn.z, turn.w = values
            message.transforms.append(one)
        self._send(message)
