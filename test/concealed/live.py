"""``python -m test.concealed.live --seed N``: the concealed arm as a node, in place of servo_driver and
wire_elasticity.

Runs in simulated time (/clock at 100 Hz): at each tick it says where it stands and goes on under the setpoint
of that tick as soon as it has heard it.
"""

from __future__ import annotations

import argparse
import signal
import sys
from array import array
from pathlib import Path
from typing import Any

import numpy as np

from test.concealed.hide import NOISE, hide
from test.concealed.live_arm import LiveArm, Sample
from test.concealed.nominal import COUNT, COUNTS_PER_REV, JOINTS, RATIO, Array

DEPTH = 200
SECOND = 10**9
SHAFT_FRICTION, TORQUE_NOISE, SPEED_NOISE = 0.01, 2e-4, 1e-3  # N m, N m, rad/s


class LivePlant:
    """Two publishers and two subscriptions on a node; ``truth`` is told to nobody but a file."""

    def __init__(self, node: Any, arm: LiveArm, seed: int):
        from trunk_ros.nodes.graph.ros import Clock, JointState

        self.arm, self.kind = arm, JointState
        self.rng = np.random.default_rng(seed)
        self.gearbox = node.create_publisher(JointState, "trunk/gearbox_states", DEPTH)
        self.joints = node.create_publisher(JointState, "joint_states", DEPTH)
        node.create_subscription(Clock, "/clock", self.on_clock, DEPTH)
        node.create_subscription(JointState, "trunk/setpoints", self.on_setpoints, DEPTH)
        self.now: int | None = None
        self.due: list[int] = []
        self.setpoints: dict[int, Array] = {}
        self.held = np.zeros(COUNT)
        self.truth: list[tuple[int, Array]] = []

    def on_setpoints(self, message: Any) -> None:
        """Keep a setpoint for the tick of its stamp."""
        position = [message.position[list(message.name).index(joint)] for joint in JOINTS]
        self.setpoints[_nanoseconds(message.header.stamp)] = np.array(position)
        self.catch_up()

    def on_clock(self, message: Any) -> None:
        """A tick; one that is said again means that nothing more is coming for the one before."""
        now = _nanoseconds(message.clock)
        if self.due and self.due[-1] == now:
            self.setpoints.setdefault(self.now or 0, self.held)
        elif self.now is None or now > max([self.now, *self.due]):
            self.due.append(now)
        self.catch_up()

    def catch_up(self) -> None:
        """Go through the ticks that are due, as far as their setpoints are known."""
        while self.due:
            if self.now is not None:
                if self.now not in self.setpoints and self.begun():
                    return
                self.held = self.setpoints.pop(self.now, self.held)
                self.arm.tick(self.held)
            self.now = self.due.pop(0)
            self.tell(self.now, self.arm.sample())

    def begun(self) -> bool:
        """Whether setpoints have begun to come."""
        return bool(self.setpoints) or bool(self.held.any())

    def tell(self, now: int, at: Sample) -> None:
        """Publish what encoder and joint sensors show."""

        def noise(rms: float) -> Array:
            return self.rng.normal(0.0, rms, COUNT)

        count = 2 * np.pi / COUNTS_PER_REV
        torque = SHAFT_FRICTION * np.sign(at.v) - RATIO * at.tau + noise(TORQUE_NOISE)
        shaft = (np.round(at.phi / count) * count, at.v + noise(SPEED_NOISE), torque)
        self.gearbox.publish(self._state(now, *shaft))
        self.joints.publish(self._state(now, at.shown + noise(NOISE)))
        self.truth.append((now, at.theta))

    def _state(self, now: int, *values: Array) -> Any:
        message = self.kind(name=list(JOINTS))
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, SECOND)
        for name, each in zip(("position", "velocity", "effort"), values, strict=False):
            setattr(message, name, array("d", each.tolist()))
        return message


def _nanoseconds(stamp: Any) -> int:
    return int(stamp.sec) * SECOND + int(stamp.nanosec)


def main(argv: list[str] | None = None) -> int:
    """Serve until asked to end; then write the true joint angles where that is asked for."""
    parser = argparse.ArgumentParser(prog="python -m test.concealed.live", description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--effects", default="", help="comma separated; drawn by default")
    parser.add_argument("--noise-seed", type=int, default=0)
    parser.add_argument("--truth", type=Path, help=".npz for stamp (n,) ns and theta (n, 5) rad")
    asked = parser.parse_args(argv)
    plant = serve(
        LiveArm(hide(asked.seed, asked.effects.split(",") if asked.effects else ())), asked.noise_seed
    )
    if asked.truth and plant.truth:
        stamp, theta = zip(*plant.truth, strict=True)
        np.savez(asked.truth, stamp=np.array(stamp), theta=np.array(theta))
    return 0


def serve(arm: LiveArm, seed: int) -> LivePlant:
    """Run the node until SIGINT or SIGTERM."""
    from trunk_ros.nodes.graph.ros import EventsExecutor, SignalHandlerOptions, rclpy

    stop: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda n, _: stop.append(n))
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("concealed_arm")
    plant = LivePlant(node, arm, seed)
    executor = EventsExecutor()
    executor.add_node(node)
    while not stop:
        executor.spin_once(timeout_sec=0.1)
    rclpy.try_shutdown()
    return plant


if __name__ == "__main__":
    sys.exit(main())
