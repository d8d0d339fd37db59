"""Launch files: what can be checked where launch is not installed."""

import ast
import os
import shlex
import subprocess
import sys
import time
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from unittest.mock import MagicMock

import numpy as np
import pytest
import yaml

from test.nodes.graph import JOINTS, ROOT, environment, needs_ros, running
from trunk_ros.__main__ import COMMANDS
from trunk_ros.arm.urdf import urdf
from trunk_ros.model import load_model, save_model

FILES = sorted((ROOT / "launch").glob("*.launch.py"))
TRUNK, REPLAY = (ROOT / "launch" / f"{name}.launch.py" for name in ("trunk", "replay"))
VIEWING = {"rviz2", "static_transform_publisher"}
LAUNCH = (
    "launch",
    "launch.actions",
    "launch.conditions",
    "launch.launch_description_sources",
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
    assert set(named) <= {*COMMANDS, "robot_state_publisher", "ros2_control_node", "spawner", *VIEWING}


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

    def described(path, **given):
        for name in LAUNCH:
            monkeypatch.setitem(sys.modules, name, MagicMock())
        module = executed(path)
        module.generate_launch_description()
        if hasattr(module, "nodes"):
            said = {name: default for name, (default, _) in module.ARGUMENTS.items()}
            said |= {"state_publisher": "false"} | given
            module.LaunchConfiguration.side_effect = lambda name: MagicMock(
                perform=lambda _: said[name], argument=name
            )
            module.nodes(MagicMock())
        return module

    return described


def parameters(module):
    """Parameters of each node, by its executable."""
    calls = [call.kwargs for call in module.Node.call_args_list if "parameters" in call.kwargs]
    return {
        each["executable"]: {key: value for given in each["parameters"] for key, value in given.items()}
        for each in calls
    }


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_no_argument_is_left_to_yaml_on_its_way_to_a_parameter(path, described):
    module = described(path, record="20260101")
    given = [value for node in parameters(module).values() for value in node.values()]
    assert given
    wrapped = module.ParameterValue.return_value
    assert all(value is wrapped or isinstance(value, bool) for value in given)
    assert all("value_type" in call.kwargs for call in module.ParameterValue.call_args_list)


def test_the_description_is_that_of_a_model_whose_path_has_spaces_and_quotes(described, tmp_path):
    model = tmp_path / "it's my arm.yaml"
    save_model(load_model("trunk"), model)
    module = described(TRUNK, plant_model=str(model), state_publisher="true")
    words = shlex.split(module.Command.call_args.args[0])  # as launch does
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.stdout == urdf(load_model("trunk").arm)


@pytest.mark.parametrize("publisher", ["true", "false"])
def test_one_source_describes_the_arm(described, publisher):
    module = described(TRUNK, state_publisher=publisher)
    started = parameters(module)
    assert started["wire_elasticity"]["publish_description"] == (publisher == "false")
    assert ("robot_state_publisher" in started) == (publisher == "true")


def test_two_arms_have_frames_of_their_own(described):
    module = described(TRUNK)
    spaces = {"": "", "left": "left/", "/left/": "left/"}
    for space, frames in spaces.items():
        assert module.frame_prefix({"namespace": space, "frame_prefix": "auto"}) == frames
    assert module.frame_prefix({"namespace": "left", "frame_prefix": "a_"}) == "a_"


def test_composed_they_are_one_process_with_the_same_parameters(described):
    from trunk_ros.nodes.compose import split

    module = described(TRUNK, composed="true", record="20260101", model="it's mine.yaml")
    (started,) = [call.kwargs for call in module.Node.call_args_list if call.kwargs["package"] == "trunk_ros"]
    assert started["executable"] == "compose"
    assert started["parameters"][0].keys() == {"rate", "use_sim_time"}
    words = started["arguments"]
    names = words[: words.index("--ros-args")]
    assert names == ["servo_driver", "wire_elasticity", "compensator", "recorder"]
    own, common = split(names, words[len(names) :])
    assert common == ["--ros-args"]
    given = {name: dict(rule.split(":=", 1) for rule in rules[2::3]) for name, rules in own.items()}
    read = {name: {key: yaml.safe_load(text) for key, text in each.items()} for name, each in given.items()}
    assert read["recorder"] == {"output": "20260101"}
    assert read["compensator"] == {"model": "it's mine.yaml"}
    assert read["wire_elasticity"].keys() == {"model", "publish_description", "frame_prefix"}
    assert started["on_exit"] is module.Shutdown.return_value


def test_topics_have_the_names_that_were_given_and_no_rule_where_they_are_ours(described):
    module = described(TRUNK, simulate="false", gearbox_states="motor/state", state_publisher="true")
    rules = [call.kwargs["remappings"] for call in module.Node.call_args_list]
    assert rules == [[("trunk/gearbox_states", "motor/state")]] * 2
    assert all(call.kwargs["remappings"] == [] for call in described(TRUNK).Node.call_args_list)


def test_where_a_node_of_ours_ends_all_end(described):
    module = described(TRUNK, record="bag")
    started = [call.kwargs for call in module.Node.call_args_list]
    assert {each["executable"] for each in started} >= {"servo_driver", "compensator", "recorder"}
    for each in started:
        assert each["package"] != "trunk_ros" or each["on_exit"] is module.Shutdown.return_value
        assert each["package"] != "trunk_ros" or float(each["sigterm_timeout"]) >= 15


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


needs_launch = pytest.mark.skipif(find_spec("launch_ros") is None, reason="launch is not installed here")


@needs_launch
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_launch_itself_reads_the_arguments_and_what_they_mean(path):
    module = executed(path)
    declared = module.generate_launch_description().get_launch_arguments()
    said = {each.name: each.description for each in declared}
    for name, (_, description) in module.ARGUMENTS.items():
        assert said[name].startswith(description)  # launch adds what there is to choose from


@needs_launch
@needs_ros
@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ("record", "exists: give another output"),
        ("plant_model:=direct", "a live node has to know its joints"),
    ],
)
def test_launch_ends_where_a_node_cannot_start_with_its_reason(given, reason, domain, tmp_path):
    there = tmp_path / "there"
    there.mkdir()
    argument = f"record:={there}" if given == "record" else given
    done = launched(tmp_path, domain, argument)
    assert reason in done.stdout + done.stderr
    assert "process has finished cleanly" in done.stdout + done.stderr
    assert "exit code -" not in done.stdout + done.stderr


def launched(folder, domain, *arguments):
    """What a launch says that ends by itself; the package is one that only knows its executables."""
    prefix = folder / "prefix"
    (prefix / "lib" / "trunk_ros").mkdir(parents=True)
    index = prefix / "share" / "ament_index" / "resource_index" / "packages"
    index.mkdir(parents=True)
    (index / "trunk_ros").touch()
    for name in ("servo_driver", "wire_elasticity", "compensator", "recorder"):
        script = prefix / "lib" / "trunk_ros" / name
        script.write_text(f'#!/bin/sh\ncd {ROOT}\nexec {sys.executable} -m trunk_ros {name} "$@"\n')
        script.chmod(0o755)
    code = (
        "import launch, sys\n"
        "from launch.launch_description_sources import PythonLaunchDescriptionSource as Source\n"
        "given = [each.split(':=', 1) for each in sys.argv[2:]]\n"
        "there = launch.actions.IncludeLaunchDescription(Source(sys.argv[1]), launch_arguments=given)\n"
        "service = launch.LaunchService(noninteractive=True)\n"
        "service.include_launch_description(launch.LaunchDescription([there]))\n"
        "sys.exit(service.run())\n"
    )
    env = environment(domain)
    env["AMENT_PREFIX_PATH"] = os.pathsep.join([str(prefix), sys.prefix])
    command = [sys.executable, "-c", code, str(TRUNK), *arguments]
    return subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, timeout=240)
