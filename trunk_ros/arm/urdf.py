"""URDF of an arm: simple shapes, so that any viewer shows it."""

from __future__ import annotations

import sys
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from trunk_ros.arm.arm import Arm
from trunk_ros.arm.description import limits, tree
from trunk_ros.arm.parameters import ANY_JOINTS
from trunk_ros.errors import ModelError, TrunkError

RADIUS = 0.012  # m, of the links as drawn
DRAWN_LENGTH = 0.05  # m of a link whose length is not known
DRAWN_MASS = 0.05  # kg
COLOURS = ("0.25 0.45 0.70 1", "0.85 0.85 0.80 1")


def urdf(arm: Arm, name: str = "trunk") -> str:
    """The arm as URDF text: its own where it has one, else base upright, z up, axes along X, a link on each
    joint, ``tip`` at the end.

    Raises ModelError for a model of any joints.
    """
    if arm.description is not None:
        return arm.description.text
    if arm.joints == (ANY_JOINTS,):
        raise ModelError("the model is for any joints: a URDF needs their names, in arm.joints")
    robot = Element("robot", name=name)
    for number, colour in enumerate(COLOURS):
        SubElement(SubElement(robot, "material", name=f"colour_{number}"), "color", rgba=colour)
    lengths = arm.link_length if arm.has_geometry else np.full(len(arm.joints), DRAWN_LENGTH)
    masses = arm.link_mass if arm.has_load else np.full(len(arm.joints), DRAWN_MASS)
    SubElement(robot, "link", name="base_link")
    parent, height = "base_link", 0.0
    for j, joint in enumerate(arm.joints):
        child = f"link_{j + 1}"
        _link(robot, child, float(lengths[j]), float(masses[j]), j % len(COLOURS))
        _joint(robot, arm, j, joint, parent, child, height)
        parent, height = child, float(lengths[j])
    SubElement(robot, "link", name="tip")
    _connect(robot, "tip_fixed", "fixed", parent, "tip", height)
    ElementTree.indent(robot)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(robot, encoding="unicode") + "\n"


def joint_limits(text: str) -> dict[str, tuple[float, float]]:
    """Lower and upper limit [rad or m] of each joint that moves in a URDF; without limits infinite.

    Raises ModelError where the text is no URDF.
    """
    try:
        moving = [joint for joint in tree(text).findall("joint") if joint.get("type") != "fixed"]
        return {
            str(joint.get("name")): limits(joint.find("limit"), str(joint.get("type"))) for joint in moving
        }
    except (ModelError, ValueError) as error:
        raise ModelError(f"robot_description is not URDF: {error}") from None


def _link(robot: Element, name: str, length: float, mass: float, colour: int) -> None:
    link = SubElement(robot, "link", name=name)
    middle = f"0 0 {length / 2!r}"
    for part in ("visual", "collision"):
        shape = SubElement(link, part)
        SubElement(shape, "origin", xyz=middle, rpy="0 0 0")
        SubElement(SubElement(shape, "geometry"), "cylinder", radius=f"{RADIUS!r}", length=f"{length!r}")
        if part == "visual":
            SubElement(shape, "material", name=f"colour_{colour}")
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "origin", xyz=middle, rpy="0 0 0")
    SubElement(inertial, "mass", value=f"{mass!r}")
    across = mass * (3 * RADIUS**2 + length**2) / 12
    about = {"ixx": across, "iyy": across, "izz": mass * RADIUS**2 / 2, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    SubElement(inertial, "inertia", {key: repr(float(value)) for key, value in about.items()})


def _joint(robot: Element, arm: Arm, j: int, name: str, parent: str, child: str, height: float) -> None:
    joint = _connect(robot, name, "revolute", parent, child, height)
    SubElement(joint, "axis", xyz="1 0 0")
    top = arm.top_speed[j]
    ends = {"lower": arm.lower[j], "upper": arm.upper[j], "velocity": top, "effort": 10.0}
    SubElement(joint, "limit", {key: repr(float(value)) for key, value in ends.items()})


def _connect(robot: Element, name: str, kind: str, parent: str, child: str, height: float) -> Element:
    joint = SubElement(robot, "joint", name=name, type=kind)
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    SubElement(joint, "origin", xyz=f"0 0 {height!r}", rpy="0 0 0")
    return joint


def main(argv: list[str] | None = None) -> int:
    """Print the URDF of a model: ``python -m trunk_ros.arm.urdf [MODEL]``, by default the nominal arm."""
    from trunk_ros.model import load_model

    names = sys.argv[1:] if argv is None else argv
    try:
        print(urdf(load_model(names[0] if names else "trunk").arm), end="")
    except TrunkError as error:
        print(f"urdf: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
