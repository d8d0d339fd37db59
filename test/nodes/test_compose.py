"""compose: several nodes in one process."""

import signal

import numpy as np
import pytest

from test.nodes.graph import JOINTS, ended, hears, needs_ros, running

pytestmark = needs_ros
ARM = ("servo_driver", "wire_elasticity", "compensator")


def test_nodes_in_one_process_move_the_arm_record_it_and_end_together(domain, peer, tmp_path):
    from trunk_ros.nodes.graph.messages import trajectory_message
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState, JointTrajectory
    from trunk_ros.recording.read import read_recording
    from trunk_ros.trajectory import Trajectory

    go = peer.publisher(JointTrajectory, "left/trunk/joint_trajectory")
    joints = peer.listen(JointState, "left/joint_states")
    said = peer.listen(DiagnosticArray, "left/diagnostics")
    bag = tmp_path / "bag"
    given = ("-r", "__ns:=/left", "-p", f"recorder:output:={bag}", "-p", "compensator:timeout:=10.0")
    with running("compose", "recorder", *ARM, "--ros-args", *given, domain=domain) as process:
        peer.meets(go, node="compensator")
        spoken = ("trunk/gearbox_states", "joint_states")
        peer.until(lambda: hears(said, "left/compensator", *spoken))
        assert {*ARM, "recorder"} <= {*peer.node.get_node_names()}
        go.publish(trajectory_message(Trajectory(tuple(JOINTS), np.array([0.5]), np.full((1, 5), 0.1))))
        peer.until(lambda: np.allclose(joints[-1].position, 0.1, atol=0.01))
        code, out, error = ended(process, signal.SIGINT)
    assert code == 0, error
    assert "none lost" in out
    series = read_recording(bag).series
    assert {"setpoints", "gearbox_states", "joint_states"} <= series.keys()
    assert np.ptp(series["joint_states"].position, axis=0).min() > 0.05


def test_where_one_cannot_start_none_stays_and_its_reason_is_said(command):
    done = command("compose", *ARM, "--ros-args", "-p", "wire_elasticity:model:=direct")
    assert done.returncode == 2
    assert "a live node has to know its joints" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_parameter_with_a_nodes_name_is_that_nodes():
    from trunk_ros.nodes.compose import split

    argv = ["--ros-args", "-p", "rate:=50.0", "-p", "compensator:lead:=false", "-r", "recorder:a:=b"]
    own, common = split(["compensator", "recorder"], argv)
    assert own == {"compensator": ["--ros-args", "-p", "lead:=false"], "recorder": []}
    assert common == ["--ros-args", "-p", "rate:=50.0", "-r", "recorder:a:=b"]


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ([], "name the nodes"),
        (["servo_drive"], "did you mean servo_driver?"),
        (["compensator", "compensator"], "each node once"),
    ],
)
def test_names_that_make_no_sense_are_refused_in_one_line(names, words):
    from trunk_ros.errors import ArgumentError
    from trunk_ros.nodes.compose import main

    with pytest.raises(ArgumentError, match=words.replace("?", r"\?")):
        main(names)
