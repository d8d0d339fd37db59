"""Viewer layouts show what the nodes publish: every path in them leads to a number."""

import json
import re
from xml.etree import ElementTree

import pytest
from rosbags.typesys import Stores, get_typestore

from test.nodes.graph import JOINTS, ROOT
from trunk_ros.model import load_model

TYPES = get_typestore(Stores.ROS2_JAZZY).fielddefs
ARM = load_model("trunk").arm
NAMES = {"/trunk/wire_states": [f"wire_{number}" for number in range(1, 6)]}
FUNCTION = re.compile(r"\.@(mul|div)\(([0-9.]+)\)$")


def topics():
    """Topics and their types, from the table of docs/nodes.md."""
    page = (ROOT / "docs" / "nodes.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([a-z_/]+)` \| (\w+)/(\w+) \|", page, re.MULTILINE)
    return {f"/{topic}": f"{package}/msg/{name}" for topic, package, name in rows}


def leads_to_a_number(kind, fields):
    """Whether a path of fields, with or without an index, ends at a number or an array of them."""
    for field in fields:
        name, index = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", field).groups()
        found = dict(TYPES[kind][1])
        assert name in found, f"{kind} has no {name}"
        node, detail = found[name]
        if node.name == "NAME":
            kind = detail
        elif node.name in ("SEQUENCE", "ARRAY"):
            assert index is None or int(index) < len(JOINTS)
            return index is not None and detail[0][1][0].startswith("float")
        else:
            return detail[0].startswith("float")
    return False


def foxglove():
    return json.loads((ROOT / "config" / "foxglove.json").read_text())


def foxglove_paths():
    panels = foxglove()["configById"].values()
    return [path["value"] for panel in panels for path in panel.get("paths", [])]


def plotjuggler():
    return ElementTree.parse(ROOT / "config" / "plotjuggler.xml").getroot()


def made_there(root):
    return {snippet.get("name") for snippet in root.iter("snippet")}


def plotjuggler_series():
    root = plotjuggler()
    sources = [each.text for each in root.iter("linked_source")] + [each.text for each in root.iter("v1")]
    return sorted({curve.get("name") for curve in root.iter("curve")} - made_there(root) | set(sources))


@pytest.mark.parametrize("path", foxglove_paths())
def test_every_path_of_foxglove_leads_to_a_number(path):
    topic, *fields = FUNCTION.sub("", path).split(".")
    assert leads_to_a_number(topics()[topic], fields)


def test_foxglove_shows_the_arm_in_3d_with_its_measured_joints():
    panels = foxglove()["configById"]
    layers = panels["3D!arm"]["layers"]
    assert layers["arm"]["topic"] == "/robot_description"
    assert layers["arm"]["jointStatesTopic"] == "/joint_states"
    assert {"/robot_description", "/joint_states", *panels["3D!arm"]["topics"]} <= topics().keys()
    assert panels["DiagnosticSummary!health"]["topicToRender"] in topics()


def test_foxglove_places_every_panel_once():
    def leaves(node):
        return [node] if isinstance(node, str) else leaves(node["first"]) + leaves(node["second"])

    assert sorted(leaves(foxglove()["layout"])) == sorted(foxglove()["configById"])


@pytest.mark.parametrize("series", plotjuggler_series())
def test_every_series_of_plotjuggler_is_one_that_it_makes_of_our_messages(series):
    topic = next(topic for topic in topics() if series.startswith(f"{topic}/"))
    fields = series.removeprefix(f"{topic}/").split("/")
    if topics()[topic] == "sensor_msgs/msg/JointState":
        joint, field = fields
        assert joint in NAMES.get(topic, JOINTS)
        assert field in ("position", "velocity", "effort")
    else:
        assert leads_to_a_number(topics()[topic], fields)


def test_plotjuggler_draws_all_that_it_computes():
    root = plotjuggler()
    assert made_there(root) <= {curve.get("name") for curve in root.iter("curve")}


def test_ratio_and_radius_in_the_layouts_are_the_arms():
    given = {match.groups() for path in foxglove_paths() if (match := FUNCTION.search(path))}
    assert given == {("mul", f"{ARM.ratio[0]:g}"), ("div", f"{ARM.wire.cylinder_radius:g}")}
    computed = [each.text for each in plotjuggler().iter("function")]
    assert all(f"{ARM.ratio[0]:g} * value" in text for text in computed)
