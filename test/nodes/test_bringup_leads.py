"""A bringup on an arm of somebody else's that stands elsewhere than the motion begins."""

from __future__ import annotations

from pathlib import Path

import pytest

from test.nodes.graph import Peer, needs_ros, running

pytestmark = needs_ros

MODEL = "/**: {ros__parameters: {arm: {joints: [arm, wrist], lower: [-1.0], upper: [1.0]}}}"
MOTION = (
    "{joint_names: [arm, wrist], points: [{positions: [0.0, 0.0], time_from_start: 0.2}, "
    "{positions: [0.1, 0.1], time_from_start: 1.0}]}"
)


@pytest.mark.parametrize("every", [0.02, 0.4], ids=["often", "rarely"])
def test_it_is_led_there_however_rarely_it_says_where_it_stands(
    every: float, tmp_path: Path, domain: int, peer: Peer
) -> None:
    """Sent before anybody knew where the arm stands, the motion was refused as too fast."""
    from trunk_ros.nodes.graph.ros import JointState

    (tmp_path / "arm.yaml").write_text(MODEL)
    (tmp_path / "motion.yaml").write_text(MOTION)
    publishers = [peer.publisher(JointState, each) for each in ("trunk/gearbox_states", "joint_states")]
    asked = peer.listen(JointState, "trunk/setpoints")
    arguments = ("-m", tmp_path / "arm.yaml", "--trajectory", tmp_path / "motion.yaml", "--seconds", 1.2)
    without = ("--without", "servo_driver", "wire_elasticity", "recorder")

    def drive() -> None:
        stands = list(asked[-1].position) if asked else [-0.9, 0.0]
        for publisher in publishers:
            state = JointState(name=["arm", "wrist"], position=stands)
            state.header.stamp = peer.now()
            publisher.publish(state)

    timer = peer.node.create_timer(every, drive)
    with running("bringup", *arguments, *without, domain=domain) as process:
        peer.until(lambda: process.poll() is not None)
        error = process.stderr.read()
    timer.cancel()
    assert process.returncode == 0, error
    assert "the arm stands elsewhere than the motion begins" in error
    assert asked[0].position[0] == pytest.approx(-0.9)
    assert list(asked[-1].position) == pytest.approx([0.1, 0.1], abs=1e-2)
