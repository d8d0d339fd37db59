"""reality over DDS: commands on their way to a simulator, joint states on their way back."""

import itertools

import numpy as np
import pytest

from test.nodes.graph import JOINTS, needs_ros, running, seconds, words
from trunk_ros.export.reality import RealityLayer
from trunk_ros.model import Model, load_model, save_model

pytestmark = needs_ros

START = 1_700_000_000 * 10**9
LATE = 3  # states of 10 ms


def test_commands_get_the_play_and_joint_states_the_delay(domain, peer, tmp_path):
    from trunk_ros.nodes.graph.messages import joint_state
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    arm = load_model("trunk").arm
    effects = {"backlash": {"half_width": np.full(5, 5e-3)}, "sensor_delay": {"delay": LATE * 0.01}}
    save_model(Model(arm, effects), tmp_path / "model.yaml")
    play = RealityLayer(Model(arm, effects)).model.effects["backlash"]["half_width"] / arm.ratio
    asked, states = (peer.publisher(JointState, t) for t in ("trunk/setpoints", "simulator/joint_states"))
    sent, shown = (peer.listen(JointState, t) for t in ("simulator/setpoints", "joint_states"))
    said = peer.listen(DiagnosticArray, "diagnostics")
    stamps, first, second = itertools.count(START, 10**7), np.full(5, 0.1), np.full(5, 0.2)

    def tell(command, state):
        now = next(stamps)
        asked.publish(joint_state(now, JOINTS, command))
        states.publish(joint_state(now, JOINTS, state))

    with running("reality", "--ros-args", "--params-file", tmp_path / "model.yaml", domain=domain):
        peer.meets(asked, states, node="reality")
        peer.answered(lambda: tell(first, 0.0 * first), lambda: sent)
        moved = 0.01 * np.arange(20.0)[:, None] * np.linspace(0.5, 1.0, 5)
        told = [next(stamps) for _ in moved]
        for now, state in zip(told, moved, strict=True):
            states.publish(joint_state(now, JOINTS, state))
        peer.until(lambda: shown and seconds(shown[-1].header.stamp) >= told[-1] / 1e9 - 1e-6)
        late = [m.position for m in shown if seconds(m.header.stamp) >= told[LATE] / 1e9 - 1e-6]
        peer.answered(
            lambda: tell(second, moved[-1]), lambda: np.allclose(sent[-1].position, second - play, atol=1e-9)
        )
        states.publish(joint_state(START, JOINTS, moved[-1]))
        tell([0.1, float("nan"), 0.1, 0.1, 0.1], moved[-1])
        peer.until(lambda: "no number" in words(said, "reality"))
        assert "jumped" in words(said, "reality") or "out of order" in words(said, "reality")

    assert np.allclose(sent[0].position, first)
    assert late == [pytest.approx(list(state), abs=1e-9) for state in moved[: len(late)]]
