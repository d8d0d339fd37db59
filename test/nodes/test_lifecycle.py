"""Managed nodes, and what every node declares."""

import signal

from test.nodes.graph import ended, needs_ros, running, seconds
from trunk_ros.model import declared_parameters, load_model

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
    with running(
        "wire_elasticity", "--ros-args", "-p", "effects.backlash.half_width:=[0.001]", domain=domain
    ):
        there = {*load_model("trunk").parameters(), "effects.backlash.half_width"}
        declared = [d for d in declared_parameters() if d.name in there]
        done = peer.call(describe, DescribeParameters.Request(names=[d.name for d in declared]))
    for declaration, described in zip(declared, done.descriptors, strict=True):
        assert declaration.meaning in described.description
        assert declaration.unit in described.description
        assert bool(described.additional_constraints) == (declaration.bounds is not None)


def test_a_node_that_cannot_be_configured_stays_and_ends_in_good_order_from_any_state(domain, peer):
    from lifecycle_msgs.msg import State, Transition
    from lifecycle_msgs.srv import ChangeState, GetState

    change = peer.node.create_client(ChangeState, "servo_driver/change_state")
    get = peer.node.create_client(GetState, "servo_driver/get_state")

    def asked(transition):
        return peer.call(change, ChangeState.Request(transition=Transition(id=transition))).success

    given = ("-p", "autostart:=false", "-p", "bus:=nosuch:Bus")
    with running("servo_driver", "--ros-args", *given, domain=domain) as process:
        assert not asked(Transition.TRANSITION_CONFIGURE)
        assert not asked(Transition.TRANSITION_ACTIVATE)  # which that state does not have
        assert not asked(Transition.TRANSITION_CONFIGURE)
        state = peer.call(get, GetState.Request()).current_state
        assert state.id == State.PRIMARY_STATE_UNCONFIGURED
        assert asked(Transition.TRANSITION_UNCONFIGURED_SHUTDOWN)
        code, _, error = ended(process, signal.SIGINT)
    assert code == 0
    assert error.count("bus 'nosuch:Bus' is neither simulated nor MODULE:CLASS") == 2
    assert "Traceback" not in error
