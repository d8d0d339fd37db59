"""Nodes among strangers: other qualities of service, other types, other arms; at rest as in motion."""

import numpy as np
import pytest

from test.nodes.graph import JOINTS, Peer, needs_ros, running, words
from trunk_ros.model import load_model

pytestmark = needs_ros
FIVE = np.array([0.1, -0.2, 0.3, 0.0, 0.25])


@pytest.fixture
def beside(peer):
    """beside(name, parameter=value, ...) -> the node, active, served with the peer."""
    from trunk_ros.nodes.compensator import Compensator
    from trunk_ros.nodes.graph.managed import end, start
    from trunk_ros.nodes.graph.ros import Parameter
    from trunk_ros.nodes.recorder import Recorder
    from trunk_ros.nodes.servo_driver import ServoDriver
    from trunk_ros.nodes.wire_elasticity import WireElasticity

    kinds = {each.NAME: each for each in (ServoDriver, WireElasticity, Compensator, Recorder)}
    nodes = []

    def beside(name, namespace="", **values):
        given = [Parameter(key, value=value) for key, value in values.items()]
        node = kinds[name](context=peer.context, namespace=namespace, parameter_overrides=given)
        nodes.append(node)
        start(node)
        peer.executor.add_node(node)
        return node

    yield beside
    for node in nodes:
        peer.executor.remove_node(node)
        end(node, 0.0)
        node.destroy_node()


def careless():
    from trunk_ros.nodes.graph.ros import QoSProfile, ReliabilityPolicy

    return QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


def state(peer, position, names=JOINTS):
    from trunk_ros.nodes.graph.messages import joint_state, nanoseconds

    return joint_state(nanoseconds(peer.now()), list(names), np.asarray(position, dtype=float))


def test_a_sensor_with_best_effort_is_heard(peer, beside):
    from trunk_ros.nodes.graph.ros import JointState

    shown = peer.listen(JointState, "joint_states")
    sensor = peer.node.create_publisher(JointState, "trunk/gearbox_states", careless())
    beside("wire_elasticity")
    peer.answered(lambda: sensor.publish(state(peer, FIVE)), lambda: shown)
    np.testing.assert_allclose(shown[-1].position, FIVE * load_model("trunk").arm.ratio, atol=1e-9)


def test_commands_with_best_effort_are_an_error_as_long_as_they_last(peer, beside):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    said = peer.listen(DiagnosticArray, "diagnostics")
    unheard = peer.node.create_publisher(JointState, "trunk/setpoints", careless())
    node = beside("servo_driver")
    told = "/trunk/setpoints of test_peer is not heard"
    peer.until(lambda: told in words(said, "servo_driver"))
    assert said[-1].status[0].level == b"\2"
    peer.node.destroy_publisher(unheard)
    peer.until(lambda: said[-1].status[0].message == "ok")
    assert node.health.troubles == {}


def test_at_rest_the_compensator_holds_the_arm_where_it_stands_and_shows_it(peer, beside):
    from trunk_ros.nodes.graph.ros import JointState

    setpoints, references = (peer.listen(JointState, f"trunk/{name}") for name in ("setpoints", "reference"))
    sensor = peer.publisher(JointState, "trunk/gearbox_states")
    node = beside("compensator", timeout=60.0)
    assert node.controller is not None
    peer.answered(lambda: sensor.publish(state(peer, FIVE)), lambda: len(setpoints) > 5)
    assert {tuple(each.position) for each in setpoints} == {tuple(FIVE)}
    start = FIVE * load_model("trunk").arm.ratio
    np.testing.assert_allclose([each.position for each in references[:5]], [start] * 5, atol=1e-9)
    assert node.shown.last is not None
    assert not node.controller.settled


def test_where_others_move_the_arm_the_compensator_keeps_still_until_it_is_asked(peer, beside):
    from trunk_ros.nodes.graph.ros import JointState

    setpoints = peer.listen(JointState, "trunk/setpoints")
    other = peer.publisher(JointState, "trunk/setpoints")
    sensor = peer.publisher(JointState, "trunk/gearbox_states")
    node = beside("compensator", timeout=60.0)
    peer.answered(
        lambda: sensor.publish(state(peer, FIVE)),
        lambda: node.controller.observation.stands(node.now()) is not None,
    )
    for _ in range(20):
        peer.spin_once()
    assert not setpoints
    peer.node.destroy_publisher(other)
    peer.until(lambda: setpoints)
    np.testing.assert_allclose(setpoints[0].position, FIVE, atol=1e-12)


def test_bytes_that_are_no_message_and_angles_that_are_none_are_left_out(peer, beside):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState, JointTrajectory

    said, out = peer.listen(DiagnosticArray, "diagnostics"), []
    for topic in ("trunk/gearbox_states", "joint_states", "trunk/setpoints", "trunk/reference"):
        peer.node.create_subscription(JointState, topic, out.append, 100)
    names = ("servo_driver", "wire_elasticity", "compensator")
    nodes = [beside(name) for name in names]
    rng = np.random.default_rng(7)
    topics = [(JointState, f"trunk/{name}") for name in ("setpoints", "reference")]
    topics += [(JointTrajectory, "trunk/joint_trajectory"), (JointState, "joint_states")]
    publishers = [peer.publisher(kind, topic) for kind, topic in topics]
    sensor = peer.publisher(JointState, "trunk/gearbox_states")
    for publisher in [*publishers, sensor]:
        peer.until(lambda publisher=publisher: publisher.get_subscription_count() > 0)
    for size in (4, 12, 40, 300):
        for publisher in [*publishers, sensor]:
            for begin in (b"", b"\0\1\0\0"):
                publisher.publish(begin + rng.integers(0, 256, size, dtype=np.uint8).tobytes())
    for value in (1e308, -1e308, 1e7):
        sensor.publish(state(peer, [value] + [0.0] * 4))
    for name in names:
        peer.until(lambda name=name: "were left out" in words(said, name))
    peer.until(lambda: "is no angle" in words(said, "wire_elasticity"))
    assert all(node.active for node in nodes)
    ours = [each for each in out if not np.abs(np.append(each.position, 0.0)).max() > 1e6]
    assert np.isfinite([value for each in ours for value in (*each.velocity, *each.effort)]).all()


def test_a_recorder_of_a_namespace_keeps_to_it(peer, beside, tmp_path):
    node = beside("recorder", namespace="/left", output=str(tmp_path / "left"))
    wanted = {
        "/left/joint_states": True,
        "/left/trunk/setpoints": True,
        "/clock": True,
        "/tf": True,
        "/right/joint_states": False,
        "/joint_states": False,
        "/left/_hidden": False,
    }
    assert {topic: node.is_wanted(topic) for topic in wanted} == wanted
    every = beside("recorder", namespace="/right", output=str(tmp_path / "all"), all_namespaces=True)
    assert every.is_wanted("/left/joint_states")
    assert not every.is_wanted("/left/_hidden")


def test_a_topic_of_two_types_is_recorded_as_one_and_that_is_said(domain, peer, tmp_path):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState, String

    said = peer.listen(DiagnosticArray, "diagnostics")
    recorder = running("recorder", "--ros-args", "-p", f"output:={tmp_path / 'bag'}", domain=domain)
    with Peer(domain) as other, recorder as process:
        outs = [peer.publisher(JointState, "shared"), other.publisher(String, "shared")]
        told = "/shared is recorded as "
        peer.until(lambda: told in words(said, "recorder"))
        assert [array.status[0].level for array in said if told in array.status[0].message][-1] == b"\2"
        process.send_signal(2)
        out, _ = process.communicate(timeout=60)
    assert "none lost" not in out
    assert "/shared: also published as " in out
    assert len(outs) == 2
