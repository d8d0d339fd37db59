"""Launch files: what can be checked where launch is not installed."""

import ast
from importlib.util import find_spec, module_from_spec, spec_from_file_location

import pytest

from test.nodes.graph import ROOT
from trunk_ros.__main__ import COMMANDS

FILES = sorted((ROOT / "launch").glob("*.launch.py"))


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


@pytest.mark.skipif(find_spec("launch_ros") is None, reason="launch is not installed here")
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_launch_itself_reads_the_arguments_and_what_they_mean(path):
    spec = spec_from_file_location("launched", path)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    declared = module.generate_launch_description().get_launch_arguments()
    assert {each.name: each.description for each in declared} == {
        name: description for name, (_, description) in module.ARGUMENTS.items()
    }
