"""A bringup on an arm that cannot be moved as it is asked to ends with 2, and says why."""

from __future__ import annotations

from pathlib import Path

import pytest

from test.nodes.graph import Peer, needs_ros, running

pytestmark = needs_ros

MODEL = "/**: {ros__parameters: {arm: {joints: [arm, wrist], lower: [-1.0], upper: [1.0]}}}"
MOTION = "{joint_names: [arm, wrist], points: [{positions: [0.3, 0.1], time_from_start: 0.5}]}"


@pytest.mark.parametrize(
    ("topic", "names", "stands", "said"),
    [
        (
            "trunk/gearbox_states",
            ["arm", "hand"],
            0.0,
            "do not say where all joints stand: wrist is missing, hand is unknown",
        ),
        ("trunk/gearbox_states", ["arm", "wrist"], -0.9, "trajectory refused: arm would move at 2.4 rad/s"),
        (
            "trunk/gearbox_state",
            ["arm", "wrist"],
            0.0,
            "nobody publishes /trunk/gearbox_states (there is /trunk/gearbox_state)",
        ),
    ],
)
def test_what_the_arm_cannot_do_ends_the_run_with_2(
    topic: str, names: list[str], stands: float, said: str, tmp_path: Path, domain: int, peer: Peer
) -> None:
    from trunk_ros.nodes.graph.messages import nanoseconds
    from trunk_ros.nodes.graph.ros import JointState

    (tmp_path / "arm.yaml").write_text(MODEL)
    (tmp_path / "motion.yaml").write_text(MOTION)
    gearbox, joints = (peer.publisher(JointState, each) for each in (topic, "joint_states"))
    asked = peer.listen(JointState, "trunk/setpoints")
    arguments = ("-m", tmp_path / "arm.yaml", "--trajectory", tmp_path / "motion.yaml", "--seconds", 1000)
    without = ("--without", "servo_driver", "wire_elasticity", "recorder")

    def drive() -> None:
        for publisher in (gearbox, joints):
            state = JointState(name=names, position=[stands, 0.0])
            state.header.stamp = peer.now()
            publisher.publish(state)

    timer = peer.node.create_timer(0.02, drive)
    with running("bringup", *arguments, *without, domain=domain) as process:
        peer.until(lambda: process.poll() is not None)
        error = process.stderr.read()
    timer.cancel()
    assert process.returncode == 2, error
    assert said in error.splitlines()[-1]
    assert all(nanoseconds(each.header.stamp) and each.position[0] == stands for each in asked)
