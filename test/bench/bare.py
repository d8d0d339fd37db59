"""Bare rclpy in one process: a timer that publishes a JointState of five joints, and one subscriber.

What the graph of nodes is measured against: python -m test.bench.bare RATE SECONDS prints figures as JSON.
"""

from __future__ import annotations

import json
import sys
import time
from array import array

from trunk_ros.nodes.graph.process import serve_for
from trunk_ros.nodes.graph.ros import EventsExecutor, JointState, rclpy

NAMES = [f"joint_{number}" for number in range(1, 6)]
WARM = 1.0  # s before counting begins


def run(rate: float, seconds: float) -> dict[str, list[float] | float]:
    """CPU [s], messages, and for each message when it was sent and how long it took [s]."""
    node = rclpy.create_node("bare")
    sent: list[float] = []
    took: list[float] = []

    def publish() -> None:
        message = JointState(name=NAMES, position=array("d", [0.1] * 5))
        now = node.get_clock().now()
        message.header.stamp = now.to_msg()
        sent.append(now.nanoseconds * 1e-9)
        publisher.publish(message)

    def heard(message: JointState) -> None:
        stamp = message.header.stamp
        took.append(time.time() - stamp.sec - stamp.nanosec * 1e-9)

    publisher = node.create_publisher(JointState, "bare", 200)
    node.create_subscription(JointState, "bare", heard, 200)
    node.create_timer(1 / rate, publish)
    executor = EventsExecutor()
    executor.add_node(node)
    serve_for(WARM, executor, node)
    sent.clear()
    took.clear()
    begin = time.process_time()
    serve_for(seconds, executor, node)
    return {"cpu": time.process_time() - begin, "seconds": seconds, "sent": sent, "took": took}


if __name__ == "__main__":
    rclpy.init()
    print(json.dumps(run(float(sys.argv[1]), float(sys.argv[2]))))
    rclpy.try_shutdown()
