"""Launch files: what can be checked where launch is not installed."""

import ast
import shlex
import subprocess
import sys
import time
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from unittest.mock import MagicMock

import numpy as np
import pytest

from test.nodes.graph import JOINTS, ROOT, needs_ros, running
from trunk_ros.__main__ import COMMANDS
from trunk_ros.arm.urdf import urdf
from trunk_ros.model import load_model, save_model

FILES = sorted((ROOT / "launch").glob("*.launch.py"))
TRUNK, REPLAY = (ROOT / "launch" / f"{name}.launch.py" for name in ("trunk", "replay"))
LAUNCH = (
    "launch",
    "launch.actions",
    "launch.conditions",
    "launch.substitutions",
    "launch_ros",
    "launch_ros.actions",
    "launch_ros.parameter_descriptions",
)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_it_compiles_and_describes_every_argument(path):
    tree = ast.parse(path.read_text())
    compile(tree, str(path), "exec")
    arguments = next(
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and node.targets[0].id == "ARGUMENTS"
    )
    assert arguments
    assert all(len(description) > 10 for _, description in arguments.values())
    used = {
        node.args[0].value
        for node in calls(tree, "LaunchConfiguration")
        if isinstance(node.args[0], ast.Constant)
    }
    assert used <= arguments.keys()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_it_starts_executables_that_there_are(path):
    tree = ast.parse(path.read_text())
    named = [
        k.value.value
        for call in calls(tree, "Node")
        for k in call.keywords
        if k.arg == "executable" and isinstance(k.value, ast.Constant)
    ]
    assert named
    assert set(named) <= {*COMMANDS, "robot_state_publisher"}


def calls(tree, name):
    """Calls of a function or class."""
    return [
        node for node in ast.walk(tree) if isinstance(node, ast.Call) and getattr(node.func, "id", "") == name
    ]


def executed(path):
    """A launch file's module."""
    spec = spec_from_file_location("launched", path)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def described(monkeypatch):
    """described(path) -> the module after it described its nodes to a stand-in that notes calls."""

    def described(path):
        for name in LAUNCH:
            monkeypatch.setitem(sys.modules, name, MagicMock())
        module = executed(path)
        module.generate_launch_description()
        return module

    return described


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_no_argument_is_left_to_yaml_on_its_way_to_a_parameter(path, described):
    module = described(path)
    bare = module.LaunchConfiguration.return_value
    given = [each for node in module.Node.call_args_list for each in node.kwargs.get("parameters", [])]
    assert given
    assert not any(value is bare for each in given for value in each.values())
    assert all("value_type" in call.kwargs for call in module.ParameterValue.call_args_list)


def test_the_description_is_that_of_a_model_whose_path_has_spaces_and_quotes(described, tmp_path):
    model = tmp_path / "it's my arm.yaml"
    save_model(load_model("trunk"), model)
    module = described(TRUNK)
    module.LaunchConfiguration.return_value.perform.return_value = str(model)
    module.state_publisher(MagicMock())
    words = shlex.split(module.Command.call_args.args[0])  # as launch does
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.stdout == urdf(load_model("trunk").arm)


@needs_ros
def test_the_wire_beside_a_replayed_bag_publishes_on_none_of_the_bags_topics(described, domain, peer):
    from trunk_ros.nodes.graph.messages import joint_state
    from trunk_ros.nodes.graph.ros import JointState

    (wire,) = [
        call.kwargs
        for call in described(REPLAY).Node.call_args_list
        if call.kwargs["executable"] == "wire_elasticity"
    ]
    rules = [("__ns", f"/{wire['namespace']}"), *wire["remappings"]]
    words = [word for old, new in rules for word in ("-r", f"{old}:={new}")]
    gearbox = peer.publisher(JointState, "/trunk/gearbox_states")
    shown = peer.listen(JointState, f"/{wire['namespace']}/joint_states")
    with running("wire_elasticity", "--ros-args", *words, domain=domain):
        peer.meets(gearbox, node="wire_elasticity")
        peer.answered(
            lambda: gearbox.publish(joint_state(time.time_ns(), JOINTS, np.zeros(5))), lambda: shown
        )
        said = peer.node.get_publisher_names_and_types_by_node("wire_elasticity", f"/{wire['namespace']}")
    bag = {f"/{name}" for name in ("joint_states", "robot_description", "diagnostics")}
    bag |= {f"/trunk/{name}" for name in ("wire_states", "tip_pose")}
    assert bag & {name for name, _ in said} == set()


@pytest.mark.skipif(find_spec("launch_ros") is None, reason="launch is not installed here")
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_launch_itself_reads_the_arguments_and_what_they_mean(path):
    module = executed(path)
    declared = module.generate_launch_description().get_launch_arguments()
    assert {each.name: each.description for each in declared} == {
        name: description for name, (_, description) in module.ARGUMENTS.items()
    }
