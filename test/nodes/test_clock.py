"""Simulated time that pauses, jumps, and runs back."""

import numpy as np

from test.nodes.graph import JOINTS, needs_ros, running, words
from trunk_ros.nodes.graph.elapsed import Elapsed

SECOND = 10**9


def test_time_only_goes_on():
    elapsed = Elapsed()
    at = [
        elapsed.at(stamp) for stamp in (100 * SECOND, 101 * SECOND, 50 * SECOND, 51 * SECOND, 10**6 * SECOND)
    ]
    np.testing.assert_allclose(at, [0.0, 1.0, 1.001, 2.001, 2.002])


@needs_ros
def test_the_arm_holds_when_time_jumps(domain, peer):
    from trunk_ros.nodes.graph.messages import joint_state, time_message
    from trunk_ros.nodes.graph.ros import Clock, DiagnosticArray, JointState

    clock, out = peer.publisher(Clock, "/clock"), peer.publisher(JointState, "trunk/setpoints")
    states, said = (
        peer.listen(JointState, "trunk/gearbox_states"),
        peer.listen(DiagnosticArray, "diagnostics"),
    )

    def run(first, steps):
        """Each step waits for its answer."""
        for step in range(steps):
            now = Clock(clock=time_message(first * SECOND + step * SECOND // 100))
            peer.answered(
                lambda now=now: clock.publish(now),
                lambda now=now: states and states[-1].header.stamp == now.clock,
            )

    with running("servo_driver", "--ros-args", "-p", "use_sim_time:=true", domain=domain):
        peer.meets(clock, out, node="servo_driver")
        run(1000, 20)
        out.publish(joint_state(1000 * SECOND + SECOND // 5, JOINTS, np.full(5, 0.1)))
        first = 1001
        while abs(states[-1].position[0] - 0.1) > 1e-4:
            run(first, 100)
            first += 1
            assert first < 1100
        before = len(states)
        run(500, 150)
        run(90_000, 50)
        peer.until(lambda: "time jumped back" in words(said, "servo_driver"))
    moved = np.array([message.position for message in states[before:]])
    assert np.abs(moved - 0.1).max() < 1e-3
    assert {message.header.stamp.sec for message in states[before:]} == {500, 501, 90_000}


@needs_ros
def test_a_trajectory_under_way_is_given_up_when_time_jumps(domain, peer):
    from trunk_ros.nodes.graph.messages import joint_state, time_message, trajectory_message
    from trunk_ros.nodes.graph.ros import Clock, DiagnosticArray, JointState, JointTrajectory
    from trunk_ros.trajectory import Trajectory

    clock, gearbox = peer.publisher(Clock, "/clock"), peer.publisher(JointState, "trunk/gearbox_states")
    trajectory = peer.publisher(JointTrajectory, "trunk/joint_trajectory")
    references = peer.listen(JointState, "trunk/reference")
    said = peer.listen(DiagnosticArray, "diagnostics")

    def step(now):
        gearbox.publish(joint_state(now, JOINTS, np.zeros(5)))
        clock.publish(Clock(clock=time_message(now)))

    def run(first, steps):
        """Each step waits for its answer."""
        for number in range(steps):
            now = first * SECOND + number * SECOND // 100
            peer.answered(
                lambda now=now: step(now),
                lambda now=now: references[-1].header.stamp == time_message(now),
            )

    def go(angle):
        path = Trajectory(tuple(JOINTS), np.array([60.0]), np.full((1, 5), angle))
        trajectory.publish(trajectory_message(path))

    with running("compensator", "--ros-args", "-p", "use_sim_time:=true", domain=domain):
        peer.meets(clock, gearbox, trajectory, node="compensator")
        go(0.3)
        first = 1000 * SECOND
        while not references:  # nothing answers before the trajectory has arrived
            step(first := first + SECOND // 100)
            peer.spin_once()
        for begin, jump in ((first // SECOND + 1, 500), (502, 90_000)):
            still, second = references[-1].position[0], begin
            while references[-1].position[0] == still:
                run(second, 100)
                second += 1
                assert second < begin + 100
            before = references[-1].position[0]
            run(jump, 150)
            assert {m.position[0] for m in references if jump <= m.header.stamp.sec <= jump + 1} == {before}
            go(0.0)
        told = ("time jumped back", "time jumped ahead")
        peer.until(lambda: all(each in words(said, "compensator") for each in told))
    assert 0.0 < before < 0.3
