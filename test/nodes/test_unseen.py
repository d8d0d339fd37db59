"""When the motors fall silent: a driver that was started anew is not sent to where the arm was."""

import time

import numpy as np
import pytest

from test.nodes.graph import JOINTS, hears, needs_ros, running, words

pytestmark = needs_ros


@pytest.fixture
def motors(peer):
    """A driver that is played, and all that it has to do with."""
    from trunk_ros.nodes.graph.messages import joint_state
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    class Motors:
        states = peer.publisher(JointState, "trunk/gearbox_states")
        reference = peer.publisher(JointState, "trunk/reference")
        setpoints = peer.listen(JointState, "trunk/setpoints")
        said = peer.listen(DiagnosticArray, "diagnostics")

        @staticmethod
        def stand(at):
            Motors.states.publish(joint_state(time.time_ns(), JOINTS, np.full(5, float(at))))

        @staticmethod
        def obey():
            Motors.stand(Motors.setpoints[-1].position[0] if Motors.setpoints else 0.0)

        @staticmethod
        def are_led_away_and_fall_silent():
            """To a reference of 0.3 rad; returns the setpoint that is held."""
            peer.meets(Motors.states, Motors.reference, node="compensator")
            peer.answered(
                lambda: Motors.stand(0.0), lambda: hears(Motors.said, "compensator", "trunk/gearbox_states")
            )

            def led():
                Motors.obey()
                Motors.reference.publish(joint_state(time.time_ns(), JOINTS, np.full(5, 0.3)))
                return Motors.setpoints[-1].position[0] > 0.45

            peer.until(led)
            peer.until(lambda: "no trunk/gearbox_states" in words(Motors.said[-1:], "compensator"))
            peer.more(Motors.said, 2)  # its own seconds: by now nothing goes out
            held = Motors.setpoints[-1].position[0]
            Motors.setpoints.clear()
            peer.more(Motors.said, 2)
            assert not Motors.setpoints
            return held

    return Motors


def test_a_driver_that_starts_with_the_arm_elsewhere_is_asked_to_hold_it_there(domain, peer, motors):
    with running("compensator", domain=domain):
        motors.are_led_away_and_fall_silent()
        peer.until(lambda: motors.stand(-0.6) or len(motors.setpoints) > 50)
        peer.until(lambda: "starting anew from there" in words(motors.said, "compensator"))
    np.testing.assert_array_equal([each.position for each in motors.setpoints], -0.6)


def test_a_driver_that_was_only_unheard_goes_on_to_be_asked_for_the_same(domain, peer, motors):
    with running("compensator", domain=domain):
        held = motors.are_led_away_and_fall_silent()
        peer.until(lambda: motors.stand(held) or len(motors.setpoints) > 5)
        assert "starting anew" not in words(motors.said, "compensator")
    np.testing.assert_allclose(motors.setpoints[0].position, held, atol=0.02)
