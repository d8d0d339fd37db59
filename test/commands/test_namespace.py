"""Bags of several arms: each command that reads one takes the arm's namespace, and asks for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from test.recording.bags import START_NS, Message, joint_state, write_bag
from trunk_ros.__main__ import main
from trunk_ros.errors import ForeignError
from trunk_ros.recording.namespace import choose
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.topics import JOINT_STATE

JOINTS = [f"joint_{number}" for number in range(1, 6)]
SECONDS = 6.0


def of(arm: str, swing: float) -> list[Message]:
    """Gearbox and joints of an arm that goes to and fro as far as that [rad]."""
    messages = []
    for k in range(int(50 * SECONDS)):
        ns, angle = START_NS + k * 20_000_000, swing * (abs((k % 100) - 50) / 50 - 0.5)
        messages.append((f"{arm}/trunk/gearbox_states", ns, joint_state(ns, JOINTS, [angle] * 5)))
        messages.append((f"{arm}/joint_states", ns, joint_state(ns, JOINTS, [0.6 * angle] * 5)))
    return messages


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("arms")
    return write_bag(folder / "both", [*of("/left", 0.4), *of("/right", 0.2)])


@pytest.mark.parametrize(
    "command",
    [
        ["info", "BAG"],
        ["simulate", "BAG", "--model", "trunk", "--output", "OUT"],
        ["evaluate", "BAG", "--model", "trunk"],
        ["diagnose", "BAG", "--output", "OUT"],
    ],
    ids=lambda words: words[0],
)
def test_one_of_two_arms_is_asked_for_and_taken(
    command: list[str], bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [{"BAG": str(bag), "OUT": str(tmp_path / "out")}.get(word, word) for word in command]
    assert main(words) == 2
    assert "of several arms (/left, /right): give --namespace" in capsys.readouterr().err
    assert main([*words, "--namespace", "middle"]) == 2
    assert "no topic of an arm" in capsys.readouterr().err
    if command[0] != "diagnose":  # which takes long
        assert main([*words, "--namespace", "/right"]) == 0


def test_topics_of_another_name_are_looked_for_in_the_namespace_alone() -> None:
    both = {
        "/left/trunk/reference": JOINT_STATE,
        "/left/motor": JOINT_STATE,
        "/right/trunk/reference": JOINT_STATE,
    }
    with pytest.raises(ForeignError, match="gives the mapping"):
        choose("bag", both, "left")
    assert choose("bag", both, "right") == ({"reference": "/right/trunk/reference"}, [])


def test_setpoints_are_taken_beside_a_gripper() -> None:
    chosen, (said,) = choose("bag", {"/trunk/setpoints": JOINT_STATE, "/gripper": JOINT_STATE})
    assert chosen == {"setpoints": "/trunk/setpoints"}
    assert "but /gripper" in said


def test_what_is_simulated_is_that_arm(bag: Path, tmp_path: Path) -> None:
    for arm, swing in (("left", 0.4), ("right", 0.2)):
        out = str(tmp_path / arm)
        assert main(["simulate", str(bag), "--model", "direct", "--output", out, "--namespace", arm]) == 0
        said = read_recording(out).series["joint_states"].position
        assert float(said.max() - said.min()) == pytest.approx(swing, rel=0.02)
