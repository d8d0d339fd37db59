"""What was hidden in an arm comes back from its motors' torque; what a motion does not show is left out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from test.bodies.arms import (
    ARMATURE,
    DAMPING,
    FRICTION,
    HIDDEN_CENTRE,
    HIDDEN_MASS,
    JOINTS,
    MASS,
    OFFSET,
    RATE,
    RATIO,
    model_of,
    recorded,
)  # fmt: skip
from trunk_ros.__main__ import main
from trunk_ros.arm.description import Description
from trunk_ros.arm.pinocchio import library
from trunk_ros.bodies.found import Bodies, load_bodies, save_bodies
from trunk_ros.bodies.run import bodies_of
from trunk_ros.compiled import Array
from trunk_ros.derivatives import smooth
from trunk_ros.errors import ModelError, TrunkError
from trunk_ros.model import load_model, save_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.write import write_recording


@pytest.fixture(scope="module")
def run() -> Recording:
    return recorded()


@pytest.fixture(scope="module")
def found(run: Recording) -> Bodies:
    return bodies_of([run], model_of())


def with_effort(recording: Recording, effort: Any, **others: Any) -> Recording:
    """The same with another effort on its motors."""
    motors = replace(recording.series["gearbox_states"], effort=effort, **others)
    return replace(recording, series={"gearbox_states": motors})


def test_what_was_hidden_comes_back_within_three_deviations_and_a_tenth(found: Bodies) -> None:
    for name, hidden in (("friction", FRICTION), ("damping", DAMPING), ("armature", ARMATURE)):
        for joint, true in zip(JOINTS, hidden, strict=True):
            got = found.joints[joint][name]
            assert got.value == pytest.approx(true, abs=min(3.0 * got.std, 0.1 * true)), (joint, name)
    assert found.last == "elbow"
    assert found.mass is not None
    assert found.mass.value == pytest.approx(HIDDEN_MASS, abs=min(3.0 * found.mass.std, 0.1 * HIDDEN_MASS))
    assert found.centre is not None
    for got_at, std, true in zip(found.centre.value, found.centre.std, HIDDEN_CENTRE, strict=True):
        assert std is not None
        assert got_at == pytest.approx(true, abs=min(3.0 * std, 0.1 * abs(true)))
    assert found.not_seen == ()


def test_the_torque_of_unseen_blocks_is_met_down_to_its_noise(found: Bodies) -> None:
    for left in found.held_out.values():
        assert left["after"] < 0.03 * left["before"]
        assert left["after"] < 0.05


def test_deviations_are_no_smaller_than_the_errors_of_other_runs() -> None:
    off = []
    for seed in range(1, 5):
        got = bodies_of([recorded(seconds=45.0, seed=seed, noise=4.0)], model_of())
        for name, hidden in (("friction", FRICTION), ("damping", DAMPING), ("armature", ARMATURE)):
            for joint, true in zip(JOINTS, hidden, strict=True):
                if name in got.joints[joint]:
                    off.append((got.joints[joint][name].value - true) / got.joints[joint][name].std)
    assert len(off) > 30
    assert 0.4 < np.sqrt(np.mean(np.square(off))) < 1.5
    assert np.abs(off).max() < 4.0


def test_deviations_know_of_residuals_that_go_on_for_a_second(run: Recording) -> None:
    """Torque that wanders: formulas for white noise would have it several deviations off."""
    motors, off = run.series["gearbox_states"], []
    assert motors.effort is not None
    slow, most = np.exp(-1.0 / (RATE * 0.7)), 0.1
    for seed in range(8):
        rough = np.random.default_rng(seed).normal(size=motors.effort.shape)
        wander = most * np.sqrt(1.0 - slow**2) * lfilter([1.0], [1.0, -slow], rough, axis=0)
        got = bodies_of([with_effort(run, motors.effort + wander * RATIO)], model_of())
        for joint, true in zip(JOINTS, OFFSET, strict=True):
            off.append((got.joints[joint]["offset"].value - true) / got.joints[joint]["offset"].std)
    assert np.sqrt(np.mean(np.square(off))) < 1.4


def test_a_motion_without_accelerations_leaves_the_armature_out() -> None:
    slow = bodies_of([recorded(seconds=120.0, speed=0.05)], model_of())
    for joint, true in zip(JOINTS, FRICTION, strict=True):
        assert "armature" not in slow.joints[joint]
        assert f"{joint}: armature not seen in this motion" in slow.not_seen
        assert slow.joints[joint]["friction"].value == pytest.approx(true, rel=0.05)
    assert slow.mass is not None
    assert slow.mass.value == pytest.approx(HIDDEN_MASS, rel=0.05)


def test_a_centre_along_upright_axes_is_not_seen_and_stays_the_models() -> None:
    flat = bodies_of([recorded(flat=True)], model_of(flat=True))
    assert flat.centre is not None
    assert flat.centre.value[2] == pytest.approx(0.1)
    assert flat.centre.std[2] is None
    assert flat.centre.value[:2] == pytest.approx(HIDDEN_CENTRE[:2], rel=0.1)
    assert "elbow: centre z not seen in this motion" in flat.not_seen


def test_an_arm_of_one_upright_joint_shows_no_mass(run: Recording) -> None:
    """The waist alone: its torque has no weight, and its inertia is its rotor's as well as the link's."""
    text = (
        '<robot name="arm"><link name="base"/><link name="link"><inertial><origin xyz="0.1 0 0"/>'
        '<mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
        '</link><joint name="waist" type="revolute"><parent link="base"/><child link="link"/>'
        '<axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="9" effort="9"/></joint></robot>'
    )
    known = load_model("direct").with_urdf(text, ("waist",))
    got = bodies_of([run], replace(known, arm=replace(known.arm, ratio=RATIO[:1])))
    assert got.mass is None
    assert got.centre is None
    assert "waist: mass not seen in this motion" in got.not_seen
    assert got.joints["waist"]["friction"].value == pytest.approx(FRICTION[0], rel=0.1)


@pytest.mark.parametrize("name", ["scara", "six", "wrist"])
def test_arms_that_move_in_space_or_slide_give_back_what_was_added(name: str) -> None:
    """Torque by Pinocchio's inverse dynamics of the URDF with a last link of another mass and centre."""
    text = (Path(__file__).parents[1] / "concealed" / "arms" / f"{name}.urdf").read_text()
    joints = tuple(joint.name for joint in Description(text).arm_joints)
    model = load_model("direct").with_urdf(text, joints)
    body, (stamp, *motion) = model.arm.body, sines(len(joints))
    link, moved = body.last_link, np.array([0.01, 0.01, 0.02])
    centre = np.array(link.lever) + moved
    mass = 1.4 * link.mass
    other = library().Inertia(mass, centre, np.array(link.inertia))
    change = other.toDynamicParameters() - link.toDynamicParameters()
    torque = body.last_link_shares(*motion, model.arm.pull) @ change
    torque -= body.moments(motion[0], model.arm.pull, 0.0, motion[1], motion[2])
    size = torque.std(axis=0).clip(0.01)
    torque += size * (0.1 * np.sign(motion[1]) + 0.05 * motion[1] + 0.02 * motion[2])
    rng = np.random.default_rng(2)
    torque += 0.01 * size * rng.normal(size=torque.shape)
    shown = motion[0] + 2e-5 * rng.normal(size=torque.shape)
    motors = JointSeries(stamp, joints, shown, None, torque)
    got = bodies_of([Recording(name, 0, float(stamp[-1]), {"gearbox_states": motors})], model)
    for joint, own in zip(joints, size, strict=True):
        for what, share in (("friction", 0.1), ("damping", 0.05), ("armature", 0.02)):
            assert got.joints[joint][what].value == pytest.approx(share * own, rel=0.05)
        slides = joint in model.arm.units
        assert got.joints[joint]["armature"].unit == ("kg" if slides else "kg m^2")
    assert got.mass is not None
    assert got.mass.value == pytest.approx(mass, rel=0.02)
    assert got.centre is not None
    for value, std, true in zip(got.centre.value, got.centre.std, centre, strict=True):
        assert std is None or value == pytest.approx(true, abs=5e-4)
    assert (got.centre.std[2] is None) == (name == "scara")


def sines(joints: int, seconds: float = 60.0) -> tuple[Array, Array, Array, Array]:
    """Stamps (n,) and sums of sines (n, joints) with their speeds and accelerations."""
    rng, stamp = np.random.default_rng(1), np.arange(0.0, seconds, 0.005)
    rate, phase, size = (rng.uniform(*ends, (5, joints)) for ends in ((0.6, 5.6), (0.0, 6.0), (0.05, 0.2)))
    turn = stamp[:, None, None] * rate + phase
    angle, speed = (size * np.sin(turn)).sum(axis=1), (size * rate * np.cos(turn)).sum(axis=1)
    return stamp, angle, speed, -(size * rate**2 * np.sin(turn)).sum(axis=1)


def test_what_is_found_is_in_the_file_and_comes_back(found: Bodies, tmp_path: Path) -> None:
    assert found.mass is not None
    save_bodies(found, tmp_path / "bodies.yaml")
    assert load_bodies(tmp_path / "bodies.yaml") == found
    text = (tmp_path / "bodies.yaml").read_text()
    assert "schema: trunk_ros/bodies/1" in text
    assert "torque there is the motor's effort over the ratio" in text
    (tmp_path / "bodies.yaml").write_text(text.replace("unit: kg\n", "units: kg\n"))
    with pytest.raises(ModelError, match=r"bodies.yaml is not as `trunk_ros bodies` writes it: 'unit'"):
        load_bodies(tmp_path / "bodies.yaml")
    (tmp_path / "bodies.yaml").write_text(text.replace(f"value: {found.mass.value}", "value: .nan"))
    with pytest.raises(ModelError, match="nan is no number"):
        load_bodies(tmp_path / "bodies.yaml")


def test_the_command_writes_the_file_and_says_what_is_in_it(
    run: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_recording(tmp_path / "run", run)
    save_model(model_of(), tmp_path / "model.yaml")
    words = ["bodies", str(tmp_path / "run"), "-m", str(tmp_path / "model.yaml")]
    out = str(tmp_path / "bodies.yaml")
    assert main([*words, "-o", out]) == 0
    said = capsys.readouterr().out
    assert "last link (elbow): mass 1.1" in said
    assert main([*words, "-o", out]) == 2
    assert "exists" in capsys.readouterr().err
    assert main([*words, "-o", out, "--overwrite", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["joints"]["elbow"]["armature"]["value"] == load_bodies(out).of("elbow", "armature")


def test_a_recording_without_effort_is_refused_by_the_command(
    run: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_recording(tmp_path / "run", with_effort(run, None))
    save_model(model_of(), tmp_path / "model.yaml")
    words = ["bodies", str(tmp_path / "run"), "-m", str(tmp_path / "model.yaml")]
    assert main([*words, "-o", str(tmp_path / "bodies.yaml")]) == 2
    line = capsys.readouterr().err
    assert "gearbox_states has no effort: the motors' torque is what bodies are fitted to" in line
    assert line.count("\n") == 1
    assert not (tmp_path / "bodies.yaml").exists()


def test_torque_that_cannot_be_fitted_is_refused_in_one_line(run: Recording) -> None:
    motors = run.series["gearbox_states"]
    assert motors.effort is not None
    renamed = replace(motors, joints=("waist", "shoulder", "wrist"))
    unknown = np.where(np.arange(3) == 1, np.nan, motors.effort)
    cases = [
        (with_effort(run, 0.0 * motors.effort), model_of(), "effort of waist is 0 throughout"),
        (with_effort(run, unknown), model_of(), "effort of shoulder is not a number for most"),
        (with_effort(run, 1000.0 * motors.effort), model_of(), "times what the model's masses ask for"),
        (with_effort(run, -motors.effort), model_of(), "has the sign of the load"),
        (replace(run, series={"gearbox_states": renamed}), model_of(), "has no elbow, but waist, shoulder"),
        (run, load_model("direct"), "wants a model with joints and masses"),
        (run.part(0.0, 12.0), model_of(), "too short: bodies want 16 blocks"),
        (with_effort(run, motors.effort, position=0.0 * motors.position), model_of(), "no joint moves"),
    ]
    for recording, model, said in cases:
        with pytest.raises(TrunkError, match=said):
            bodies_of([recording], model)
    bare = replace(model_of().arm, description=None, link_length=np.ones(3), link_mass=np.empty(0))
    with pytest.raises(ModelError, match="the model has no bodies"):
        bodies_of([run], replace(model_of(), arm=bare))


def test_two_runs_say_more_than_one(run: Recording, found: Bodies) -> None:
    both = bodies_of([run, recorded(seed=1)], model_of())
    assert both.recordings == ("run0", "run1")
    assert found.mass is not None
    assert both.mass is not None
    assert both.mass.value == pytest.approx(HIDDEN_MASS, rel=0.02)
    assert both.joints["waist"]["friction"].std < found.joints["waist"]["friction"].std


def test_an_arm_as_its_model_has_it_keeps_its_mass(run: Recording) -> None:
    """Torque by the model itself, with friction and noise."""
    model = model_of()
    motors = run.series["gearbox_states"]
    stamp, angle = motors.stamp, motors.position * RATIO
    theta, speed, acceleration = smooth(stamp, angle)
    asked = -model.arm.body.moments(theta, model.arm.pull, 0.0, speed, acceleration)
    torque = asked + FRICTION * np.sign(speed) + 0.05 * np.random.default_rng(5).normal(size=asked.shape)
    got = bodies_of([with_effort(run, torque * RATIO)], model)
    if got.mass is not None:
        assert got.mass.value == pytest.approx(MASS[2], abs=4.0 * got.mass.std)
    assert "armature" not in got.joints["shoulder"]
    assert "damping" not in got.joints["shoulder"]
