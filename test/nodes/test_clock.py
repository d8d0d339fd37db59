"""Simulated time that pauses, jumps, and runs back."""

import numpy as np

from test.nodes.graph import JOINTS, needs_ros, running, words
from trunk_ros.nodes.elapsed import Elapsed

SECOND = 10**9


def test_time_only_goes_on():
    elapsed = Elapsed()
    at = [
        elapsed.at(stamp) for stamp in (100 * SECOND, 101 * SECOND, 50 * SECOND, 51 * SECOND, 10**6 * SECOND)
    ]
    np.testing.assert_allclose(at, [0.0, 1.0, 1.001, 2.001, 2.002])


@needs_ros
def test_the_arm_holds_when_time_jumps(domain, peer):
    from trunk_ros.nodes.messages import joint_state, time_message
    from trunk_ros.nodes.ros import Clock, DiagnosticArray, JointState

    clock, out = peer.publisher(Clock, "/clock"), peer.publisher(JointState, "trunk/setpoints")
    states, said = (
        peer.listen(JointState, "trunk/gearbox_states"),
        peer.listen(DiagnosticArray, "diagnostics"),
    )

    def run(first, seconds):
        for step in range(int(seconds * 100)):
            clock.publish(Clock(clock=time_message(first * SECOND + step * SECOND // 100)))
            peer.spin(0.002)

    with running("servo_driver", "--ros-args", "-p", "use_sim_time:=true", domain=domain):
        peer.until(lambda: clock.get_subscription_count() >= 2 and out.get_subscription_count())
        run(1000, 0.2)
        out.publish(joint_state(1000 * SECOND + SECOND // 5, JOINTS, np.full(5, 0.1)))
        peer.spin(0.1)
        run(1001, 1.0)
        peer.until(lambda: abs(states[-1].position[0] - 0.1) < 1e-4)
        before = len(states)
        run(500, 1.5)
        run(90_000, 0.5)
        peer.until(lambda: states[-1].header.stamp.sec == 90_000)
    moved = np.array([message.position for message in states[before:]])
    assert np.abs(moved - 0.1).max() < 1e-3
    assert {message.header.stamp.sec for message in states[before:]} >= {500, 501, 90_000}
    assert "time jumped back" in words(said, "servo_driver")
