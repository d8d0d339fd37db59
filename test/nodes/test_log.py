"""What nodes say in their log, and that they say less where less is asked for."""

import signal

import pytest

from test.nodes.graph import JOINTS, ended, needs_ros, running, words

pytestmark = needs_ros


@pytest.mark.parametrize("level", ["info", "warn"])
def test_a_node_logs_its_states_as_information_and_what_it_refuses_as_a_warning(level, domain, peer):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    out = peer.publisher(JointState, "trunk/setpoints")
    said = peer.listen(DiagnosticArray, "diagnostics")
    states = peer.listen(JointState, "trunk/gearbox_states")

    def too_far() -> None:
        message = JointState(name=JOINTS, position=[1e4] * 5)
        message.header.stamp = peer.now()
        out.publish(message)

    with running("servo_driver", "--ros-args", "--log-level", level, domain=domain) as process:
        peer.meets(out, node="servo_driver")
        peer.until(lambda: states)
        peer.answered(too_far, lambda: "refused" in words(said, "servo_driver"))
        code, _, log = ended(process, signal.SIGINT)
    assert code == 0
    assert any("WARN" in line and "refused" in line for line in log.splitlines())
    assert all(("INFO" in log and state in log) == (level == "info") for state in ("configured", "active"))
