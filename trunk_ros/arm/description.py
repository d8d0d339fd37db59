"""An arm in a URDF: the branch from a base link to a tip."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from trunk_ros.arm.body import Body
from trunk_ros.arm.pinocchio import library
from trunk_ros.errors import ModelError

LINK = "link "  # before the name of each in Pinocchio: a joint may have the same
MOVING = ("revolute", "continuous", "prismatic")
TIPS = ("tip", "tcp", "tool0", "tool", "ee_link", "ee", "end_effector", "flange")
"""Names by which a tip is known, where several links are as far from the base."""


@dataclass(frozen=True)
class Joint:
    """One joint of a URDF; the source and factors of one that mimics another."""

    name: str
    kind: str
    parent: str
    child: str
    lower: float
    upper: float
    source: str = ""
    multiplier: float = 1.0
    offset: float = 0.0

    @property
    def moves(self) -> bool:
        """Whether it has a value of its own."""
        return self.kind in MOVING and not self.source


@dataclass(frozen=True)
class Description:
    """A URDF and the two links between which the arm lies; the links may be left to be found.

    Raises ModelError, when read, for what is no URDF or has no such links.
    """

    text: str
    base: str = ""
    tip: str = ""

    @property
    def arm_joints(self) -> tuple[Joint, ...]:
        """Joints with a value of their own that move the tip, from the base on."""
        return arm_joints(self)

    def body(self, joints: tuple[str, ...]) -> Body:
        """The links, moved by these joints; all others stay at 0 or follow those that they mimic."""
        return body_of(self, joints)

    def found(self, recorded: tuple[str, ...] = ()) -> Description:
        """The same with base and tip by name; of several tips the one that most of ``recorded`` move."""
        return Description(self.text, *_ends(tuple(read(self.text)), self.base, self.tip, recorded))


@lru_cache(maxsize=16)
def read(text: str) -> tuple[Joint, ...]:
    """All joints of a URDF, in its order. Raises ModelError where the text is none."""
    robot = tree(text)
    joints = tuple(_joint(element) for element in robot.findall("joint"))
    links = [str(link.get("name")) for link in robot.findall("link")]
    names = [joint.name for joint in joints]
    for kind, several in (("link", links), ("joint", names)):
        if twice := {name for name in several if several.count(name) > 1}:
            raise ModelError(f"the URDF has two {kind}s of the name {min(twice)}")
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in links:
                raise ModelError(f"the URDF's joint {joint.name} has a link {end!r} that is not there")
        if joint.source and joint.source not in names:
            raise ModelError(f"the URDF's joint {joint.name} mimics {joint.source!r}, which is not there")
    if not joints:
        raise ModelError("the URDF has no joints")
    return joints


def tree(text: str) -> Element:
    """The robot of a URDF. Raises ModelError where the text is none, or xacro."""
    try:
        robot = ElementTree.fromstring(text.strip())
    except ElementTree.ParseError as error:
        raise ModelError(f"not a URDF: {error}") from None
    if robot.tag != "robot":
        raise ModelError(f"not a URDF: <{robot.tag}> where <robot> should be")
    if "xacro" in text and any("xacro" in str(element.tag) for element in robot.iter()):
        raise ModelError("the URDF still has xacro macros: run xacro on it first")
    return robot


def _joint(element: Element) -> Joint:
    name, kind = str(element.get("name")), str(element.get("type"))
    mimic = element.find("mimic")
    try:
        parent, child = (str(_child(element, end, name).get("link")) for end in ("parent", "child"))
        lower, upper = limits(element.find("limit"), kind)
        if mimic is None:
            return Joint(name, kind, parent, child, lower, upper)
        factors = float(mimic.get("multiplier", 1.0)), float(mimic.get("offset", 0.0))
        return Joint(name, kind, parent, child, lower, upper, str(mimic.get("joint")), *factors)
    except ValueError as error:
        raise ModelError(f"the URDF's joint {name}: {error}") from None


def _child(element: Element, tag: str, name: str) -> Element:
    found = element.find(tag)
    if found is None:
        raise ModelError(f"the URDF's joint {name} has no <{tag}>")
    return found


def limits(limit: Element | None, kind: str = "") -> tuple[float, float]:
    """Lower and upper end [rad or m] of a joint, infinite where a URDF has none."""
    if kind == "continuous" or limit is None or limit.get("lower") is None or limit.get("upper") is None:
        return -np.inf, np.inf
    return float(str(limit.get("lower"))), float(str(limit.get("upper")))


def way(joints: tuple[Joint, ...], base: str, tip: str) -> tuple[Joint, ...]:
    """Joints from the base link to the tip. Raises ModelError where the tip is not beyond the base."""
    above = {joint.child: joint for joint in joints}
    links = {end for joint in joints for end in (joint.parent, joint.child)}
    for link in (base, tip):
        if link not in links:
            raise ModelError(f"the URDF has no link {link!r}, but {', '.join(sorted(links))}")
    out: list[Joint] = []
    link = tip
    while link != base:
        if link not in above or len(out) > len(joints):
            raise ModelError(f"the URDF has no way from link {base!r} out to {tip!r}: give another arm.tip")
        out.append(above[link])
        link = above[link].parent
    return tuple(out[::-1])


def _ends(joints: tuple[Joint, ...], base: str, tip: str, recorded: tuple[str, ...]) -> tuple[str, str]:
    children = {joint.child for joint in joints}
    roots = [joint.parent for joint in joints if joint.parent not in children]
    base = base or ("base_link" if "base_link" in _links(joints) else roots[0])
    if tip:
        way(joints, base, tip)
        return base, tip
    reached = {base: ()} | {link: _way_or_none(joints, base, link) for link in _links(joints) - {base}}
    counts = {link: _moving(path, recorded) for link, path in reached.items() if path is not None}
    most = max(counts.values())
    best = [link for link in counts if counts[link] == most]
    known = [name for name in TIPS for link in best if link == name or link.endswith(f"_{name}")]
    if known:
        return base, next(link for link in best if link == known[0] or link.endswith(f"_{known[0]}"))
    ends = [link for link in best if not any(joint.parent == link for joint in joints)]
    shortest = min(best, key=lambda link: (len(reached[link] or ()), link))
    return base, ends[0] if len(ends) == 1 else shortest


def _way_or_none(joints: tuple[Joint, ...], base: str, link: str) -> tuple[Joint, ...] | None:
    try:
        return way(joints, base, link)
    except ModelError:
        return None


def _moving(path: tuple[Joint, ...], recorded: tuple[str, ...]) -> int:
    return sum(joint.moves and (not recorded or joint.name in recorded) for joint in path)


def _links(joints: tuple[Joint, ...]) -> set[str]:
    return {end for joint in joints for end in (joint.parent, joint.child)}


@lru_cache(maxsize=16)
def arm_joints(description: Description) -> tuple[Joint, ...]:
    """Joints with a value of their own that move the tip, from the base on. Raises ModelError for none."""
    joints = read(description.text)
    found = description.found()
    named = {joint.name: joint for joint in joints}
    out: list[Joint] = []
    for joint in way(joints, found.base, found.tip):
        if joint.kind not in (*MOVING, "fixed"):
            raise ModelError(f"the URDF's joint {joint.name} is {joint.kind}: only {', '.join(MOVING)} move")
        own = named[joint.source] if joint.source else joint
        if joint.kind != "fixed" and own not in out:
            out.append(own)
    if not out:
        raise ModelError(f"no joint of the URDF moves between {found.base} and {found.tip}")
    return tuple(out)


@lru_cache(maxsize=32)
def body_of(description: Description, joints: tuple[str, ...]) -> Body:
    """The body of a description, moved by ``joints``. Raises ModelError for a joint that is not its own."""
    pin, known = library(), read(description.text)
    found = description.found()
    path = way(known, found.base, found.tip)
    named = {joint.name: joint for joint in known}
    for joint in joints:
        if joint not in named or not named[joint].moves:
            moving = ", ".join(each.name for each in known if each.moves)
            raise ModelError(f"the URDF has no joint {joint!r} that moves: it has {moving}")
    followers = {each.name: each for each in known if each.source in joints}
    free = set(joints) | set(followers)
    whole = _parsed(description.text)
    locked = [i for i in range(1, whole.njoints) if whole.names[i] not in free]
    model = pin.buildReducedModel(whole, locked, pin.neutral(whole))
    spread, offset = np.zeros((model.nv, len(joints))), np.zeros(model.nv)
    for i in range(1, model.njoints):
        name, row = model.names[i], model.joints[i].idx_v
        told = followers.get(name)
        spread[row, joints.index(told.source if told else name)] = told.multiplier if told else 1.0
        offset[row] = told.offset if told else 0.0
    base, tip = model.frames[frame_of(model, found.base)], frame_of(model, found.tip)
    if base.parentJoint != 0:
        raise ModelError(f"a joint of the arm moves its base {found.base}: give another arm.base")
    ids = tuple(model.getJointId(joint.name) for joint in path if joint.name in free)
    return Body(model, tip, base.placement, spread, offset, ids)


def frame_of(model: Any, link: str) -> int:
    """Pinocchio's number of a link's frame."""
    return int(model.getFrameId(LINK + link))


@lru_cache(maxsize=8)
def _parsed(text: str) -> Any:
    """Pinocchio's model of a URDF, in which every joint that turns has one number."""
    robot = tree(text)
    named = [(link, "name") for link in robot.findall("link")]
    named += [(end, "link") for end in chain(robot.findall("joint/parent"), robot.findall("joint/child"))]
    for element, attribute in named:
        if attribute in element.attrib:
            element.set(attribute, LINK + element.attrib[attribute])
    for joint in robot.findall("joint"):
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            for limit in joint.findall("limit"):
                joint.remove(limit)
            ElementTree.SubElement(joint, "limit", lower="-1e9", upper="1e9", effort="0", velocity="0")
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)
    try:
        return library().buildModelFromXML(ElementTree.tostring(robot, encoding="unicode"))
    except (ValueError, RuntimeError) as error:
        said = " ".join(str(error).split()).replace(LINK, "")
        raise ModelError(f"Pinocchio cannot read the URDF: {said}") from None
