"""References of others among the compensator's own, which come back on the same topic."""

import numpy as np

from test.nodes.graph import JOINTS, needs_ros, running

SECOND = 10**9

pytestmark = needs_ros


def test_a_message_is_our_own_by_stamp_and_angles():
    from rclpy.serialization import serialize_message

    from trunk_ros.model import load_model
    from trunk_ros.nodes.control.foreign import ForeignReference
    from trunk_ros.nodes.graph.messages import joint_state

    at, angles, other = 12 * SECOND + 5, np.linspace(-0.1, 0.1, 5), np.full(5, 0.2)
    references = ForeignReference(load_model("trunk").arm)
    references.sent(at, angles)

    def heard(ns, position):
        return references.message(serialize_message(joint_state(ns, JOINTS, position, np.zeros(5))))

    assert heard(at, angles) is None
    assert list(heard(at, other).position) == list(other)
    assert list(heard(at + 1, angles).position) == list(angles)


def test_in_simulated_time_a_foreign_reference_of_the_same_stamp_has_precedence(domain, peer):
    from trunk_ros.nodes.graph.messages import joint_state, nanoseconds, time_message, trajectory_message
    from trunk_ros.nodes.graph.ros import Clock, JointState, JointTrajectory
    from trunk_ros.trajectory import Trajectory

    clock, gearbox = peer.publisher(Clock, "/clock"), peer.publisher(JointState, "trunk/gearbox_states")
    trajectory = peer.publisher(JointTrajectory, "trunk/joint_trajectory")
    foreign = peer.publisher(JointState, "trunk/reference")
    heard, setpoints = peer.listen(JointState, "trunk/reference"), peer.listen(JointState, "trunk/setpoints")
    now = 1000 * SECOND

    def came(messages):
        return nanoseconds(messages[-1].header.stamp) == now

    def step():
        gearbox.publish(joint_state(now, JOINTS, np.zeros(5)))
        clock.publish(Clock(clock=time_message(now)))

    with running("compensator", "--ros-args", "-p", "use_sim_time:=true", domain=domain):
        peer.meets(clock, gearbox, trajectory, foreign, node="compensator")
        path = Trajectory(tuple(JOINTS), np.array([60.0]), np.full((1, 5), 0.3))
        trajectory.publish(trajectory_message(path))
        while not setpoints:  # nothing answers before the trajectory has arrived
            now += SECOND // 100
            step()
            peer.spin_once()
        for tick in range(400):
            now += SECOND // 100
            peer.answered(step, lambda: came(setpoints))
            if tick == 200:
                peer.until(lambda: came(heard))
                own = heard[-1].position[0]
                foreign.publish(joint_state(now, JOINTS, np.full(5, -0.1)))
            if setpoints[-1].position[0] < 0.0:
                break
    assert own > 0.0  # until then it went its own way, though it heard itself
    assert tick > 200
    assert setpoints[-1].position[0] < 0.0
