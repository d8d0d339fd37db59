"""servo_driver over DDS: what it refuses, and that it holds."""

import numpy as np
import pytest

from test.nodes.graph import JOINTS, needs_ros, running, values, words

pytestmark = needs_ros


@pytest.fixture
def driver(domain, peer):
    """A running driver, what it publishes, and a way to ask it for angles."""
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    out = peer.publisher(JointState, "trunk/setpoints")
    states, said = (
        peer.listen(JointState, "trunk/gearbox_states"),
        peer.listen(DiagnosticArray, "diagnostics"),
    )

    def ask(position, joints=JOINTS):
        message = JointState(name=list(joints), position=[float(angle) for angle in position])
        message.header.stamp = peer.now()
        out.publish(message)

    with running("servo_driver", domain=domain):
        peer.meets(out, node="servo_driver")
        peer.until(lambda: states)
        yield peer, ask, states, said


def stands_at(states, wanted):
    """Whether all joints stand where they were wanted, by name."""
    return dict(zip(states[-1].name, states[-1].position, strict=True)) == pytest.approx(wanted, abs=1e-4)


def test_it_goes_where_it_is_asked_and_refuses_what_is_unsafe(driver):
    peer, ask, states, said = driver
    ask([0.1, 0.2, -0.1, 0.0, 0.05])
    first = dict(zip(JOINTS, [0.1, 0.2, -0.1, 0.0, 0.05], strict=True))
    peer.until(lambda: stands_at(states, first))

    ask([0.1, 0.7, -0.1, 0.0, 0.05])
    ask([0.1, float("nan"), -0.1, 0.0, 0.05])
    ask([0.1, 0.2], joints=["joint_1", "joint_1"])
    ask([0.4], joints=["elbow"])
    peer.until(lambda: "elbow" in words(said, "servo_driver"))
    told = words(said, "servo_driver")
    assert "joint_2 at 0.7000 rad is outside -0.6430 ... 0.6430; holding the last safe one" in told
    assert "joint_2 is not a number" in told
    assert "joint_1, joint_1" in told
    peer.more(states)
    assert stands_at(states, first)

    ask([-0.05, 0.3], joints=["joint_5", "joint_1"])
    peer.until(lambda: stands_at(states, first | {"joint_5": -0.05, "joint_1": 0.3}))
    peer.until(lambda: "joint joint_2 missing" in words(said, "servo_driver"))


def test_it_holds_and_says_so_when_setpoints_dry_up(driver):
    peer, ask, states, said = driver
    for step in range(20):
        ask([0.01 * step] * 5)
    peer.until(lambda: stands_at(states, dict.fromkeys(JOINTS, 0.19)))
    said.clear()
    peer.until(lambda: "no trunk/setpoints for" in words(said, "servo_driver"))
    assert stands_at(states, dict.fromkeys(JOINTS, 0.19))
    shown = values(said, "servo_driver")
    assert float(shown["rate [Hz]"]) > 0
    assert len(shown["model"]) == 12


def test_before_it_is_known_where_the_shafts_stand_a_setpoint_has_to_name_all_joints():
    from trunk_ros.model import load_model
    from trunk_ros.nodes.arm.servo import Servo
    from trunk_ros.nodes.bus import SimulatedBus
    from trunk_ros.nodes.graph.joints import MessageError

    model = load_model("trunk")
    servo = Servo(model.arm, SimulatedBus(model))
    with pytest.raises(MessageError, match="leaves out joints whose position is unknown"):
        servo.ask(["joint_1"], [0.1], 0)
    assert servo.ask(JOINTS, [0.1] * 5, 1) == []
    assert "joint joint_2 missing" in servo.ask(["joint_1"], [0.2], 2)
    np.testing.assert_array_equal(servo.asked, [0.2, 0.1, 0.1, 0.1, 0.1])
