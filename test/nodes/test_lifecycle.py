"""Managed nodes, and what every node declares."""

from test.nodes.graph import needs_ros, running, seconds
from trunk_ros.model import declared_parameters

pytestmark = needs_ros


def test_without_autostart_a_node_waits_for_its_manager(domain, peer):
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState

    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    said = peer.listen(DiagnosticArray, "diagnostics")
    states = peer.listen(JointState, "trunk/gearbox_states")
    change = peer.node.create_client(ChangeState, "servo_driver/change_state")

    def ask(transition):
        assert peer.call(change, ChangeState.Request(transition=Transition(id=transition))).success

    with running("servo_driver", "--ros-args", "-p", "autostart:=false", domain=domain):
        ask(Transition.TRANSITION_CONFIGURE)
        peer.more(said, 2)  # a second of its own
        assert not states
        ask(Transition.TRANSITION_ACTIVATE)
        peer.more(states, 10)
        ask(Transition.TRANSITION_DEACTIVATE)
        silent = seconds(peer.now())
        peer.more(said, 2)
        assert all(seconds(state.header.stamp) < silent for state in states)
        ask(Transition.TRANSITION_CLEANUP)
        ask(Transition.TRANSITION_CONFIGURE)
        ask(Transition.TRANSITION_ACTIVATE)
        peer.until(lambda: seconds(states[-1].header.stamp) > silent)
        peer.more(states, 10)


def test_every_parameter_has_unit_bounds_and_description_from_its_declaration(domain, peer):
    from rcl_interfaces.srv import DescribeParameters

    describe = peer.node.create_client(DescribeParameters, "wire_elasticity/describe_parameters")
    with running("wire_elasticity", domain=domain):
        declared = declared_parameters()
        done = peer.call(describe, DescribeParameters.Request(names=[d.name for d in declared]))
    for declaration, described in zip(declared, done.descriptors, strict=True):
        assert declaration.meaning in described.description
        assert declaration.unit in described.description
        assert bool(described.additional_constraints) == (declaration.bounds is not None)
