"""Managed nodes, and what every node declares."""

from test.nodes.graph import needs_ros, running
from trunk_ros.model import declared_parameters

pytestmark = needs_ros


def test_without_autostart_a_node_waits_for_its_manager(domain, peer):
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState

    from trunk_ros.nodes.ros import JointState

    states = peer.listen(JointState, "trunk/gearbox_states")
    change = peer.node.create_client(ChangeState, "servo_driver/change_state")

    def ask(transition):
        done = change.call_async(ChangeState.Request(transition=Transition(id=transition)))
        peer.until(done.done)
        assert done.result().success

    with running("servo_driver", "--ros-args", "-p", "autostart:=false", domain=domain):
        peer.until(change.service_is_ready)
        ask(Transition.TRANSITION_CONFIGURE)
        peer.spin(0.5)
        assert not states
        ask(Transition.TRANSITION_ACTIVATE)
        peer.until(lambda: len(states) > 10)
        ask(Transition.TRANSITION_DEACTIVATE)
        peer.spin(0.2)
        silent = len(states)
        peer.spin(0.3)
        assert len(states) == silent
        ask(Transition.TRANSITION_CLEANUP)
        ask(Transition.TRANSITION_CONFIGURE)
        ask(Transition.TRANSITION_ACTIVATE)
        peer.until(lambda: len(states) > silent + 10)


def test_every_parameter_has_unit_bounds_and_description_from_its_declaration(domain, peer):
    from rcl_interfaces.srv import DescribeParameters

    describe = peer.node.create_client(DescribeParameters, "wire_elasticity/describe_parameters")
    with running("wire_elasticity", domain=domain):
        peer.until(describe.service_is_ready)
        declared = declared_parameters()
        done = describe.call_async(DescribeParameters.Request(names=[d.name for d in declared]))
        peer.until(done.done)
    for declaration, described in zip(declared, done.result().descriptors, strict=True):
        assert declaration.meaning in described.description
        assert declaration.unit in described.description
        assert bool(described.additional_constraints) == (declaration.bounds is not None)
