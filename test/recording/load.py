"""Publishes serialised messages at a steady rate, for benches: `python -m test.recording.load --rate 10000`.

Prints how many it has sent, and in how many seconds, as JSON.
"""

from __future__ import annotations

import argparse
import json
import os
import struct
import sys
import time
from typing import Any

PAUSE = 0.0005  # s between two looks at the clock
MEET, SETTLE = 30.0, 1.0  # s for the recorder to come, and for both to know each other


def joint_states(count: int = 5000) -> list[bytearray]:
    """More JointStates than a chunk holds, in CDR: five joints of a motion, with noise."""
    import numpy as np

    from test.recording.bags import KIND, STORE, joint_state

    names = [f"joint_{number}" for number in range(1, 6)]
    angle = np.linspace(0, 2 * np.pi, count)[:, None, None] + np.arange(15.0).reshape(3, 5)
    values = np.sin(angle) + np.random.default_rng(1).normal(0, 1e-4, (count, 3, 5))
    made = (joint_state(0, names, *each) for each in values)
    return [bytearray(STORE.serialize_cdr(each, KIND)) for each in made]


def byte_array(size: int) -> bytearray:
    """A UInt8MultiArray in CDR of so many bytes that cannot be compressed."""
    return bytearray(struct.pack("<IIII", 0x0100, 0, 0, size) + os.urandom(size))


def send(publisher: Any, messages: list[bytearray], rate: float, seconds: float) -> dict[str, float]:
    """Publish at `rate` per s, messages by turns; what is late is made up for. Several get stamps."""
    count, sent, begun = round(rate * seconds), 0, time.perf_counter()
    while sent < count:
        due = min(count, int((time.perf_counter() - begun) * rate) + 1)
        for number in range(sent, due):
            data = messages[number % len(messages)]
            if len(messages) > 1:
                struct.pack_into("<II", data, 4, *divmod(time.time_ns(), 10**9))
            publisher.publish(bytes(data))
        sent = due
        time.sleep(PAUSE)
    return {"sent": sent, "seconds": time.perf_counter() - begun}


def main(argv: list[str] | None = None) -> int:
    """Wait for a subscriber, publish, and stay until all is delivered."""
    from trunk_ros.nodes.graph.ros import JointState, QoSProfile, rclpy

    asked = argparse.ArgumentParser(prog="python -m test.recording.load", description=__doc__)
    asked.add_argument("--rate", type=float, default=1000.0, help="messages per s")
    asked.add_argument("--seconds", type=float, default=5.0)
    asked.add_argument("--size", type=int, default=0, help="bytes; 0: a five-joint JointState")
    given = asked.parse_args(argv)
    from std_msgs.msg import UInt8MultiArray

    rclpy.init()
    node = rclpy.create_node("load")
    kind = UInt8MultiArray if given.size else JointState
    depth = 1000 if not given.size else 20
    publisher = node.create_publisher(kind, "load", QoSProfile(depth=depth))
    until = time.monotonic() + MEET
    while not publisher.get_subscription_count() and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(SETTLE)
    messages = [byte_array(given.size)] if given.size else joint_states()
    print(json.dumps(send(publisher, messages, given.rate, given.seconds)), flush=True)
    sys.stdin.read()  # until the bench has seen the end of the recorder
    node.destroy_node()
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
