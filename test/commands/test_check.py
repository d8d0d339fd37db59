"""``check``: how a file is understood, and what it leaves to others."""

from __future__ import annotations

from pathlib import Path

import pytest

from trunk_ros.__main__ import main

ARM = """/**:
  ros__parameters:
    arm:
      {arm}
    wire:
      ratio: {ratio}
"""


def check(folder: Path, capsys: pytest.CaptureFixture[str], arm: str, ratio: str = "[0.5]") -> str:
    """What is said of a model file that is right."""
    (folder / "arm.yaml").write_text(ARM.format(arm=arm, ratio=ratio))
    assert main(["check", str(folder / "arm.yaml")]) == 0
    return capsys.readouterr().out


def test_the_tip_of_an_arm_with_a_urdf_is_known(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    urdf = Path(__file__).parents[1] / "concealed" / "arms" / "three.urdf"
    assert "tip: tool0, seen from base_link, by the URDF" in check(tmp_path, capsys, f"urdf: {urdf}")
    assert "tip: not known: neither link lengths nor a URDF" in check(tmp_path, capsys, "joints: [a, b]")


def test_numbers_of_the_servo_that_a_file_does_not_give_are_said_to_be_trunks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = check(tmp_path, capsys, "joints: [a]", "[0.5]\n    servo:\n      kp: 31.0")
    assert "kp 31 1/s, tau_v 0.02 s, v_max 1.5 rad/s (not given, taken from trunk: tau_v, v_max)" in said
    late = check(tmp_path, capsys, "joints: [a, b]", "[0.5]\n    servo:\n      delay: [0.0, 0.02]")
    assert "v_max 1.5 rad/s, delay 0/0.02 s (not given, taken from trunk: kp, tau_v, v_max)" in late
    encoder = check(tmp_path, capsys, "joints: [a]", "[0.5]\n    servo:\n      counts_per_rev: 4096.0")
    assert "servo: not given: a diagnosis finds it in the recording" in encoder
    faster = check(tmp_path, capsys, "joints: [a]", "[0.5]\n    servo:\n      kp: 31.0\n      step: 0.001")
    assert "v_max 1.5 rad/s, step 0.001 s (not given, taken from trunk: tau_v, v_max)" in faster
    assert main(["check", "trunk"]) == 0
    assert "not given" not in capsys.readouterr().out


def test_of_joints_that_several_motors_move_it_is_said_which_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wrist = ARM.replace("ratio: {ratio}", "coupling: [0.5, 0.25, 0.0, -1.5]")
    (tmp_path / "arm.yaml").write_text(wrist.format(arm="joints: [pitch, yaw]"))
    (tmp_path / "named.yaml").write_text(
        wrist.format(arm="joints: [pitch, yaw]") + "      motors: [m1, m2]\n"
    )
    assert main(["check", str(tmp_path / "arm.yaml")]) == 0
    assert "pitch  0.5 pitch + 0.25 yaw" in capsys.readouterr().out
    assert main(["check", str(tmp_path / "named.yaml")]) == 0
    said = capsys.readouterr().out
    assert "pitch  0.5 m1 + 0.25 m2" in said
    assert "yaw    -1.5 m2 " in said


def test_limits_beyond_a_turn_are_asked_about(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = "limits of a are beyond a turn: are these rad, not degrees?"
    arm = "joints: [a, b]\n      lower: [-3.0, -3.0]\n      upper: "
    assert asked in check(tmp_path, capsys, arm + "[90.0, 2.0]")
    assert "beyond a turn" not in check(tmp_path, capsys, arm + "[3.0, 2.0]")
    assert "beyond a turn" not in check(tmp_path, capsys, "joints: [a, b]")


def test_recorded_effort_is_a_load_of_an_arm_without_masses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = check(tmp_path, capsys, "joints: [a]\n      load: effort")
    assert "load: from recorded effort; without any, unknown: effects of load are not tried" in said
    masses = "joints: [a]\n      link_length: [0.1]\n      link_mass: [0.1]"
    said = check(tmp_path, capsys, f"{masses}\n      load: effort")
    assert "load: from recorded effort; without any, the computed weight" in said
    assert "load: known, from weight" in check(tmp_path, capsys, masses)
    assert "load: unknown" in check(tmp_path, capsys, "joints: [a]")


SLIDE = """<robot name="g"><link name="base"/><link name="palm"/><link name="finger"/>
<joint name="wrist" type="revolute"><parent link="base"/><child link="palm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="grip" type="prismatic"><parent link="palm"/><child link="finger"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.1" effort="1" velocity="1"/></joint></robot>"""


def test_limits_and_backlash_are_in_the_units_of_each_joint(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "arm.urdf").write_text(SLIDE)
    said = check(tmp_path, capsys, "urdf: arm.urdf", "[1.0, 1.0]\n      dead_band: [0.001, 0.002]")
    wrist, grip = (line.split() for line in said.splitlines()[2:4])
    assert wrist == ["wrist", "1", "1", "mrad", "-1.000", "…", "+1.000", "rad"]
    assert grip == ["grip", "1", "2", "mm", "+0.000", "…", "+0.100", "m"]


@pytest.mark.parametrize(("ratio", "refused"), [("[0.5, 1]", True), ("[1, 1]", False), ("[1.0, 0.5]", False)])
def test_a_list_that_ros_2_cannot_read_is_said(
    ratio: str, refused: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = check(tmp_path, capsys, "joints: [a, b]", ratio)
    first, second, *_ = said.splitlines()
    assert first.endswith("a model, and right for all but nodes" if refused else "a model, and right")
    assert ("wire.ratio = [0.5, 1]: nodes refuse this file as --params-file" in second) is refused
    assert ("write 1.0, not 1" in said) is refused
