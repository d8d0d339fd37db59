"""Arms by their URDF: load, inertia and tip beside MuJoCo's, and what is said of a URDF that will not do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trunk_ros.arm import Arm
from trunk_ros.arm.description import Description
from trunk_ros.arm.frames import Frames
from trunk_ros.arm.urdf import urdf
from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model, save_model

mujoco = pytest.importorskip("mujoco")
URDFS = {path.stem: path for path in (Path(__file__).parent / "concealed" / "arms").glob("*.urdf")}
PULL = (0.7, -1.1, -9.3)
MOUNTING = (2.5, 0.3, -0.8)


def arm_of(name: str, **changes: Any) -> Arm:
    text = URDFS[name].read_text()
    joints = tuple(joint.name for joint in Description(text).arm_joints)
    return replace(load_model("direct").with_urdf(text, joints).arm, **changes)


def postures(arm: Arm, count: int = 50) -> Array:
    rng = np.random.default_rng(len(arm.joints))
    return rng.uniform(arm.lower, arm.upper, (count, len(arm.joints)))


class Engine:
    """MuJoCo's reading of the same URDF, a payload at the tip."""

    def __init__(self, name: str, payload: float, gravity: Array):
        spec = mujoco.MjSpec.from_string(
            URDFS[name]
            .read_text()
            .replace(
                "<link", '<mujoco><compiler fusestatic="false" balanceinertia="true"/></mujoco>\n<link', 1
            )
        )
        spec.option.gravity = gravity
        tip = spec.body("tool0")
        if payload:
            tip.mass, tip.inertia, tip.ipos, tip.explicitinertial = payload, [1e-12] * 3, np.zeros(3), True
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.tip = self.model.body("tool0").id

    def at(self, q: Array, v: Array) -> tuple[Array, Array, Array]:
        """Moments of weight and motion, tip place and rotation."""
        self.data.qpos[:], self.data.qvel[:] = q, v
        mujoco.mj_forward(self.model, self.data)
        bias = np.array(self.data.qfrc_bias)
        return -bias, np.array(self.data.xpos[self.tip]), np.array(self.data.xmat[self.tip]).reshape(3, 3)

    def mass(self, q: Array) -> Array:
        self.at(q, 0.0 * q)
        full = np.zeros((len(q), len(q)))
        mujoco.mj_fullM(self.model, self.data, full)
        return full


def turned(angles: tuple[float, float, float]) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_euler("xyz", angles).as_matrix())


@pytest.mark.parametrize("name", sorted(URDFS))
def test_load_and_tip_are_those_of_another_engine(name: str) -> None:
    arm = arm_of(name, payload=0.3, gravity=PULL, mounting=MOUNTING)
    engine, theta = Engine(name, 0.3, turned(MOUNTING).T @ PULL), postures(arm_of(name))
    load, tip = arm.load(theta), arm.tip(theta)
    for k, q in enumerate(theta):
        moment, place, turn = engine.at(q, 0.0 * q)
        assert load[k] == pytest.approx(moment, rel=1e-9, abs=1e-9 * np.abs(load).max())
        assert tip[k, :3] == pytest.approx(place, abs=1e-9)
        x, y, z, w = tip[k, 3:]
        assert 2 * np.array([x * x + w * w - 0.5, x * y + z * w, x * z - y * w]) == pytest.approx(
            turn[:, 0], abs=1e-9
        )


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("name", sorted(URDFS))
def test_weight_is_that_of_the_library(name: str, links: bool) -> None:
    body, theta = arm_of(name).body, postures(arm_of(name))
    still = np.zeros_like(theta)
    weight = body.moments(theta, PULL, 0.3, links=links)
    known = body.moments(theta, PULL, 0.3, still, still, links=links)
    assert weight == pytest.approx(known, rel=1e-9, abs=1e-12 * max(np.abs(known).max(), 1.0))


@pytest.mark.parametrize("name", sorted(URDFS))
def test_inertia_and_mass_matrix_are_those_of_another_engine(name: str) -> None:
    arm, engine = arm_of(name), Engine(name, 0.0, np.zeros(3))
    theta, rng = postures(arm, 20), np.random.default_rng(1)
    speed = rng.normal(size=theta.shape)
    moment, mass = arm.inertia(theta, speed, 0.0 * speed), arm.mass_matrix(theta)
    for k, q in enumerate(theta):
        assert moment[k] == pytest.approx(engine.at(q, speed[k])[0], rel=1e-8, abs=1e-10)
        assert mass[k] == pytest.approx(engine.mass(q), rel=1e-9, abs=1e-11)


@pytest.mark.parametrize("name", sorted(URDFS))
def test_the_jacobian_is_the_slope_of_the_tip(name: str) -> None:
    arm, step = arm_of(name), 1e-6
    theta = postures(arm, 5)
    for j in range(len(arm.joints)):
        more = theta + step * np.eye(len(arm.joints))[j]
        slope = (arm.tip(more) - arm.tip(theta))[:, :3] / step
        assert arm.body.jacobian(theta)[:, :3, j] == pytest.approx(slope, abs=1e-5)


@pytest.mark.parametrize("name", sorted(URDFS))
def test_places_of_joints_and_tip_are_those_of_the_library(name: str) -> None:
    arm = arm_of(name)
    body, theta = arm.body, postures(arm, 20)
    place, turn = body.places(theta)
    np.testing.assert_allclose(place[:, -1], body.poses(theta)[:, :3], atol=1e-12)
    np.testing.assert_array_equal(body.ends(theta), place[:, -1])
    for k, one in enumerate(theta):
        frames = body.frames(one, [body.model.getFrameId(body.model.names[i]) for i in body.own])
        seen = [body.base.inverse() * frame for frame in [*frames, *body.frames(one, [body.tip])]]
        np.testing.assert_allclose(place[k], [frame.translation for frame in seen], atol=1e-12)
        np.testing.assert_allclose(turn[k], [frame.rotation for frame in seen], atol=1e-12)


def test_the_weight_is_a_sum_of_its_shares() -> None:
    """So that torque tells the load whatever the masses are."""
    arm = arm_of("six")
    theta = postures(arm)
    shares = arm.body.weight_shares(theta, arm.pull)
    for j in range(len(arm.joints)):
        load = arm.load(theta)[:, j]
        found, *_ = np.linalg.lstsq(shares[:, j], load, rcond=1e-10)
        assert shares[:, j] @ found == pytest.approx(load, abs=1e-9)


def test_a_joint_that_mimics_another_moves_with_it() -> None:
    text = (
        URDFS["three"]
        .read_text()
        .replace(
            '<parent link="fore"/>',
            '<parent link="fore"/><mimic joint="lift" multiplier="-0.5" offset="0.4"/>',
        )
    )
    arm = load_model("direct").with_urdf(text, ("pan", "lift")).arm
    assert arm.joints == ("pan", "lift")
    whole, theta = arm_of("three"), np.array([[0.3, 0.5], [-0.4, -0.2]])
    own = np.column_stack([theta, 0.4 - 0.5 * theta[:, 1]])
    assert arm.tip(theta) == pytest.approx(whole.tip(own), abs=1e-12)
    load = whole.load(own)
    assert arm.load(theta) == pytest.approx(np.column_stack([load[:, 0], load[:, 1] - 0.5 * load[:, 2]]))


def test_the_nominal_arm_reads_its_own_urdf_back() -> None:
    arm = load_model("trunk").arm
    again = load_model("direct").with_urdf(urdf(arm), arm.joints).arm
    theta = np.random.default_rng(0).uniform(-1.0, 1.0, (50, 5))
    assert again.load(theta) == pytest.approx(arm.load(theta), rel=1e-9, abs=1e-12)
    assert again.tip(theta) == pytest.approx(arm.tip(theta), abs=1e-12)
    assert again.lower == pytest.approx(arm.lower)


def test_a_model_file_names_the_urdf_beside_it_and_holds_its_text_when_saved(tmp_path: Path) -> None:
    (tmp_path / "my.urdf").write_text(URDFS["six"].read_text())
    (tmp_path / "my.yaml").write_text(
        "/**: {ros__parameters: {arm: {urdf: my.urdf, tip: link_4, payload: 0.2, gravity: [0.0, 0.0, -1.6],"
        " mounting: [0.1, 0.2, 0.3]}, wire: {ratio: [0.5], dead_band: [0.001]}}}"
    )
    model = load_model(tmp_path / "my.yaml")
    assert model.arm.joints == ("j1", "j2", "j3", "j4")
    assert model.arm.description is not None
    assert model.arm.description.base == "base_link"
    save_model(model, tmp_path / "saved.yaml")
    (tmp_path / "my.urdf").unlink()
    again = load_model(tmp_path / "saved.yaml")
    assert again.hash() == model.hash()
    theta = postures(model.arm, 5)
    assert again.arm.load(theta) == pytest.approx(model.arm.load(theta))


def test_joints_that_were_not_recorded_stand_at_0() -> None:
    text = URDFS["six"].read_text()
    arm = load_model("direct").with_urdf(text, ("j2", "j3", "gripper")).arm
    assert arm.joints == ("j2", "j3")
    theta = np.array([[0.4, -0.7]])
    whole = arm_of("six").load(np.array([[0.0, 0.4, -0.7, 0.0, 0.0, 0.0]]))
    assert arm.load(theta) == pytest.approx(whole[:, 1:3])


def test_frames_lead_from_the_base_to_the_tip() -> None:
    arm, theta = arm_of("six"), np.array([0.3, -0.4, 0.5, 0.1, -0.2, 0.6])
    frames = Frames(arm)
    assert frames.pairs[0] == ("base_link", "link_1")
    assert frames.pairs[-1] == ("link_6", "tool0")
    from scipy.spatial.transform import Rotation

    place, turn = np.zeros(3), Rotation.identity()
    for values in frames.transforms(theta):
        place, turn = place + turn.apply(values[:3]), turn * Rotation.from_quat(values[3:])
    assert place == pytest.approx(arm.tip(theta[None])[0, :3])


GRIPPER = """<robot name="g"><link name="world"/><link name="arm"/><link name="palm"/><link name="left"/>
<link name="right"/><joint name="stand" type="fixed"><parent link="world"/><child link="arm"/></joint>
<joint name="wrist" type="continuous"><parent link="arm"/><child link="palm"/><axis xyz="0 0 1"/></joint>
<joint name="l" type="prismatic"><parent link="palm"/><child link="left"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
<joint name="r" type="prismatic"><parent link="palm"/><child link="right"/><axis xyz="-1 0 0"/>
<limit lower="0" upper="0.1" effort="1" velocity="1"/></joint></robot>"""


def test_the_tip_is_where_the_recorded_joints_lead() -> None:
    found = Description(GRIPPER).found(("wrist",))
    assert found.tip == "palm"
    assert [joint.name for joint in found.arm_joints] == ["wrist"]
    assert Description(GRIPPER, tip="left").arm_joints[1].kind == "prismatic"


BAD = {
    "no xml": ("hello", "not a URDF"),
    "no robot": ("<sdf/>", "<sdf> where <robot> should be"),
    "no joints": ("<robot><link name='a'/></robot>", "no joints"),
    "no tip": (GRIPPER.replace('child link="left"', 'child link="gone"'), "'gone' that is not there"),
    "xacro": (
        "<robot xmlns:xacro='http://ros.org/wiki/xacro'><xacro:property name='a' value='1'/></robot>",
        "run xacro on it first",
    ),
    "a limit in words": (GRIPPER.replace('upper="0.1"', 'upper="ten"'), "joint l: could not convert"),
}


@pytest.mark.parametrize("what", BAD)
def test_a_urdf_that_will_not_do_is_refused_in_one_line(what: str) -> None:
    text, message = BAD[what]
    with pytest.raises(ModelError, match=message) as error:
        load_model("direct").with_urdf(text, ("wrist",))
    assert "\n" not in str(error.value)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no file": ({"arm.urdf": "gone.urdf"}, "cannot read the URDF gone.urdf: No such file"),
    "no package": ({"arm.urdf": "package://gone/a.urdf"}, "in a package 'gone'"),
    "no link": ({"arm.urdf": GRIPPER, "arm.tip": "hand"}, "no link 'hand', but arm, left"),
    "wrong way": ({"arm.urdf": GRIPPER, "arm.base": "left", "arm.tip": "right"}, "no way from link 'left'"),
    "another joint": ({"arm.urdf": GRIPPER, "arm.joints": ["elbow"], "arm.tip": "palm"}, "'elbow', the URDF"),
    "lengths as well": ({"arm.urdf": GRIPPER, "arm.link_length": [0.1]}, "the place of arm.link_length"),
    "a tip alone": ({"arm.tip": "hand"}, "give arm.urdf as well"),
    "two values of gravity": ({"arm.gravity": [0.0, -9.8]}, "give three values"),
    "gravity upward": ({"arm.gravity": -9.8}, r"0 or more, or give \[x, y, z\]"),
    "half a coupling": ({"arm.joints": ["a", "b"], "wire.coupling": [1.0, 0.0]}, "2 values for 2 joints"),
    "a coupling without inverse": (
        {"arm.joints": ["a", "b"], "wire.coupling": [1.0, 1.0, 1.0, 1.0]}, "cannot be inverted"
    ),
    "coupling and ratio": (
        {"arm.joints": ["a"], "wire.coupling": [1.0], "wire.ratio": [1.0]}, "leave one of them out"
    ),
    "too few motors": (
        {"arm.joints": ["a", "b"], "wire.motors": ["m"]}, "must be 2 different names"
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_parameters_that_do_not_go_together_are_refused(what: str) -> None:
    flat, message = WRONG[what]
    with pytest.raises(ModelError, match=message) as error:
        Model.from_parameters(flat)
    assert "\n" not in str(error.value)
