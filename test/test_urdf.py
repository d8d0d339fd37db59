"""The arm as URDF."""

from xml.etree import ElementTree

import numpy as np
import pytest

from test.effects.example import in_plane
from trunk_ros.arm.description import Description
from trunk_ros.arm.frames import Links
from trunk_ros.arm.urdf import main, urdf
from trunk_ros.model import load_model

ARM = load_model("trunk").arm


def tip(robot, angles):
    """Forward kinematics from the text alone: rotations about x, translations along z."""
    children = {joint.find("parent").get("link"): joint for joint in robot.findall("joint")}
    link, y, z, heading = "base_link", 0.0, 0.0, 0.0
    while link in children:
        joint = children[link]
        height = float(joint.find("origin").get("xyz").split()[2])
        y, z = y - height * np.sin(heading), z + height * np.cos(heading)
        heading += angles.get(joint.get("name"), 0.0)
        link = joint.find("child").get("link")
    assert link == "tip"
    return [y, z, heading]


def test_its_chain_ends_where_the_arm_does():
    theta = np.array([0.1, -0.3, 0.2, 0.35, -0.05])
    robot = ElementTree.fromstring(urdf(ARM))
    found = tip(robot, dict(zip(ARM.joints, theta, strict=True)))
    np.testing.assert_allclose(found, in_plane(ARM.tip(theta[None]))[0], atol=1e-9)


def test_limits_are_those_of_the_arm():
    joint = ElementTree.fromstring(urdf(ARM)).find("joint[@name='joint_3']")
    assert float(joint.find("limit").get("upper")) == pytest.approx(ARM.upper[2])
    assert float(joint.find("limit").get("velocity")) == pytest.approx(1.5 * 0.625)
    assert joint.find("axis").get("xyz") == "1 0 0"


def test_an_unknown_model_is_refused_in_one_line(capsys):
    assert main(["nowhere"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_joint_may_have_the_name_of_a_link():
    theta, text = np.array([[0.1, -0.3, 0.2, 0.35, -0.05]]), urdf(ARM)
    same = text.replace('"tip"', '"joint_5"')
    assert same != text
    found = Description(same, tip="joint_5").body(ARM.joints).poses(theta)
    np.testing.assert_array_equal(found, Description(text, tip="tip").body(ARM.joints).poses(theta))
    links = Links(same, ARM.joints)
    assert links.transforms(theta[0]).shape == (len(links.pairs), 7)
