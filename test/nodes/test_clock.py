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


@needs_ros
def test_a_trajectory_under_way_is_given_up_when_time_jumps(domain, peer):
    from trunk_ros.nodes.messages import joint_state, time_message, trajectory_message
    from trunk_ros.nodes.ros import Clock, DiagnosticArray, JointState, JointTrajectory
    from trunk_ros.trajectory import Trajectory

    clock, gearbox = peer.publisher(Clock, "/clock"), peer.publisher(JointState, "trunk/gearbox_states")
    trajectory = peer.publisher(JointTrajectory, "trunk/joint_trajectory")
    references = peer.listen(JointState, "trunk/reference")
    said = peer.listen(DiagnosticArray, "diagnostics")

    def run(first, seconds):
        for step in range(int(seconds * 100)):
            now = first * SECOND + step * SECOND // 100
            gearbox.publish(joint_state(now, JOINTS, np.zeros(5)))
            clock.publish(Clock(clock=time_message(now)))
            peer.spin(0.002)
        peer.until(lambda: references and references[-1].header.stamp == time_message(now))

    def go(angle):
        path = Trajectory(tuple(JOINTS), np.array([5.0]), np.full((1, 5), angle))
        trajectory.publish(trajectory_message(path))
        peer.spin(0.2)

    with running("compensator", "--ros-args", "-p", "use_sim_time:=true", domain=domain):
        peer.until(lambda: clock.get_subscription_count() >= 2 and trajectory.get_subscription_count())
        go(0.3)
        for begin, jump in ((1001, 500), (502, 90_000)):
            run(begin, 1.0)
            before = references[-1].position[0]
            run(jump, 1.5)
            assert {m.position[0] for m in references if jump <= m.header.stamp.sec <= jump + 1} == {before}
            go(0.0)
    assert 0.0 < before < 0.3
    told = words(said, "compensator")
    assert "time jumped back" in told
    assert "time jumped ahead" in told
