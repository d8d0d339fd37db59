"""Parameters of nodes: what is set holds at once or is refused, and a dump can be loaded again."""

import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import yaml

from test.nodes.graph import JOINTS, PATIENCE, environment, needs_ros, running
from trunk_ros.model import Model, declared_parameters, load_model, save_model
from trunk_ros.nodes.parameters import COMMON, PARAMETERS

pytestmark = needs_ros
NODES = ("servo_driver", "wire_elasticity", "compensator", "recorder")


@pytest.fixture
def made(peer):
    """made(name, parameter=value, ...) -> the node, in this process."""
    from trunk_ros.nodes.graph.ros import Parameter

    nodes = []

    def made(name, **values):
        given = [Parameter(key.replace("__", "."), value=value) for key, value in values.items()]
        nodes.append(kind(name)(context=peer.context, parameter_overrides=given))
        return nodes[-1]

    yield made
    for node in nodes:
        node.destroy_node()


def kind(name):
    from trunk_ros.nodes.compensator import Compensator
    from trunk_ros.nodes.recorder import Recorder
    from trunk_ros.nodes.servo_driver import ServoDriver
    from trunk_ros.nodes.wire_elasticity import WireElasticity

    return {each.NAME: each for each in (ServoDriver, WireElasticity, Compensator, Recorder)}[name]


def names(node):
    return node.list_parameters([], 0).names


def asked(node, name, value):
    """The reason why a parameter was refused, "" where it was taken."""
    from trunk_ros.nodes.graph.ros import Parameter

    result = node.set_parameters_atomically([Parameter(name, value=value)])  # as its service does
    return "" if result.successful else result.reason


def dumped(node):
    """What ``ros2 param dump`` writes: a tree, as its insert_dict grows it."""
    tree = {}
    for name in sorted(names(node)):
        branch, parts = tree, name.split(".")
        for part in parts[:-1]:
            branch = branch.setdefault(part, {})
        value = node.get_parameter(name).value
        branch[parts[-1]] = value if isinstance(value, (str, float, int)) else list(value)
    return yaml.safe_load(yaml.safe_dump(tree))


def flat(tree, prefix=""):
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


@pytest.mark.parametrize("name", NODES)
def test_a_dump_is_a_tree_and_can_be_loaded_into_the_running_node(made, name):
    node = made(name, output="bag") if name == "recorder" else made(name)
    before = dumped(node)
    for key, value in flat(before):
        assert asked(node, key, value) == "", key
    assert dumped(node) == before
    assert len(names(node)) < 60


def test_no_parameter_is_the_group_of_another():
    every = {d.name for own in (declared_parameters(), COMMON, *PARAMETERS.values()) for d in own}
    every |= {"use_sim_time"}
    groups = {name.rsplit(".", count)[0] for name in every for count in range(1, name.count(".") + 1)}
    assert every & groups == set()


def test_an_edited_dump_with_effects_holds_after_it_is_loaded(made):
    node = made("compensator", effects__backlash__half_width=[0.001])
    tree = dumped(node)
    tree["effects"]["backlash"]["half_width"] = [0.002] * 5
    for key, value in flat(tree):  # model comes after effects, and is no order to forget them
        assert asked(node, key, value) == ""
    assert node.model.effects["backlash"]["half_width"].tolist() == [0.002] * 5


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [
        ("servo_driver", "rate", 50.0),
        ("servo_driver", "bus", "other:Bus"),
        ("servo_driver", "model", "direct"),
        ("servo_driver", "effects.servo_delay.delay", 0.1),
        ("wire_elasticity", "arm.joints", ["a", "b", "c", "d", "e"]),
        ("wire_elasticity", "use_sim_time", True),
        ("recorder", "compression", "lz4"),
        ("recorder", "output", "elsewhere"),
        ("recorder", "depth", 5),
    ],
)
def test_what_holds_from_the_start_is_refused_later(made, name, parameter, value):
    node = made(name, output="bag") if name == "recorder" else made(name)
    assert asked(node, parameter, value)
    if node.has_parameter(parameter):
        assert node.get_parameter(parameter).value != value


@pytest.mark.parametrize(
    ("parameter", "value", "words"),
    [
        ("effects.backlash.half_width", [5e3], "must be 0 ..."),
        ("effects.backlash.half_width", [0.001] * 3, "3 values for 5 joints"),
        ("effects.backlash.half_width", ["wide"], "must be a number"),
        ("effects.backlash.half_widht", [0.001], "did you mean 'effects.backlash.half_width'?"),
        ("arm.lower", [-0.1] * 5, "lower is not that of the running arm"),
        ("model", "x" * 300, "no model 'xxx"),
        ("model", "/tmp/" + "x" * 300, "File name too long"),
        ("model", "nul\0", "no model"),
        ("timeoutt", 1.0, "did you mean 'timeout'?"),
    ],
)
@pytest.mark.parametrize("name", ["wire_elasticity", "compensator"])
def test_what_makes_no_sense_is_refused_with_the_reason(made, name, parameter, value, words):
    node = made(name)
    before = dumped(node)
    assert words in asked(node, parameter, value)
    assert dumped(node) == before


def test_a_node_without_a_model_refuses_one_and_goes_on(made):
    node = made("recorder", output="bag")
    for name, value in (("model", "direct"), ("effects.backlash.half_width", [0.001])):
        assert "unknown parameter" in asked(node, name, value)
    assert asked(node, "rate", node.value("rate")) == ""


def test_numbers_that_ros2_param_takes_for_words_are_numbers(made):
    node = made("compensator", effects__backlash__half_width=[0.001])
    assert asked(node, "reversal", "5e-05") == ""
    assert node.value("reversal") == 5e-5
    assert asked(node, "effects.backlash.half_width", str([5e-05, 1.0e-3, 0.0, 0.0, 2.0e-3])) == ""
    assert node.model.effects["backlash"]["half_width"].tolist() == [5e-5, 1e-3, 0.0, 0.0, 2e-3]
    assert "Wrong parameter type" in asked(node, "reversal", "small")


def test_an_effect_that_is_set_acts_at_once_and_is_shown_as_long_as_it_is_there(made):
    from trunk_ros.nodes.arm.wire import Wire

    node = made("wire_elasticity")
    node.wire = Wire(node.model)
    phi = np.full(5, 0.3)
    for stamp in (1, 2):
        node.wire.update(stamp * 10**9, phi * stamp / 2)
    first = node.wire.update(3 * 10**9, phi).joints
    assert asked(node, "effects.backlash.half_width", [0.01]) == ""
    assert list(node.get_parameter("effects.backlash.half_width").value) == [0.01] * 5
    np.testing.assert_allclose(node.wire.update(4 * 10**9, phi).joints, first, atol=1e-12)  # no jump
    back = node.wire.update(5 * 10**9, phi - 0.005).joints
    np.testing.assert_allclose(back, first, atol=1e-12)  # within the new play
    assert asked(node, "effects.backlash.half_width", [0.0] * 5) == ""
    assert not node.has_parameter("effects.backlash.half_width")


def test_a_timeout_and_the_control_settings_apply_at_once(made, peer):
    node = made("compensator")
    node.configure()
    for name, value in (("timeout", 3.0), ("reversal", 1e-3), ("max_acceleration", 7.0), ("state_rate", 1.0)):
        assert asked(node, name, value) == ""
    assert node.motors.stream.timeout == node.measured.stream.timeout == 3.0
    assert node.controller.settings.reversal == 1e-3
    assert node.controller.settings.max_acceleration == 7.0
    assert node.shown.rate == 1.0
    node.let_go()


def test_a_file_is_read_again_where_it_says_something_else(made, tmp_path):
    path = tmp_path / "found.yaml"
    node = made("compensator")
    for width in (1e-3, 2e-3):
        effects = {"backlash": {"half_width": np.full(5, width)}}
        save_model(replace(load_model("trunk"), effects=effects), path)
        assert asked(node, "model", str(path)) == ""
        assert node.model.effects["backlash"]["half_width"][0] == width
    assert asked(node, "model", "trunk") == ""
    assert not [name for name in names(node) if name.startswith("effects.")]


def test_files_of_earlier_versions_are_taken(made, tmp_path):
    path = tmp_path / "old.yaml"
    save_model(replace(load_model("trunk"), duration=7.0), path)
    path.write_text(path.read_text().replace("recording:", "model:"))
    assert load_model(path).duration == 7.0
    assert Model.from_parameters({"model.duration": 7.0}).duration == 7.0
    node = made("compensator", arm__joints=JOINTS, wire__ratio=[0.6], model__duration=7.0)
    assert node.model.duration == 7.0
    assert asked(node, "model.duration", 8.0) == ""
    assert node.model.duration == node.get_parameter("recording.duration").value == 8.0
    assert "model.duration" not in names(node)


needs_cli = pytest.mark.skipif(find_spec("ros2param") is None, reason="ros2cli is not installed here")


def ros2_param(verb, domain, *arguments):
    """What a verb of ``ros2 param`` says; its name is that of its class."""
    code = (
        "import argparse, importlib, sys\n"
        "kind = importlib.import_module('ros2param.verb.' + sys.argv[1])\n"
        "verb = getattr(kind, sys.argv[1].title() + 'Verb')()\n"
        "parser = argparse.ArgumentParser()\n"
        "verb.add_arguments(parser, 'ros2 param')\n"
        "sys.exit(verb.main(args=parser.parse_args(sys.argv[2:])))\n"
    )
    command = [sys.executable, "-c", code, verb, *map(str, arguments), "--no-daemon", "--spin-time", "10"]
    return subprocess.run(command, env=environment(domain), capture_output=True, text=True, timeout=100)


@needs_cli
@pytest.mark.parametrize("name", ["servo_driver", "compensator"])
def test_ros2_param_itself_dumps_and_loads(name, domain, tmp_path):
    with running(name, domain=domain):
        dumped = ros2_param("dump", domain, f"/{name}", "--timeout", 30)
        assert dumped.returncode == 0, dumped.stderr
        tree = yaml.safe_load(dumped.stdout)[f"/{name}"]["ros__parameters"]
        assert tree["recording"]["duration"] == 0.0
        assert tree["model"] == "trunk"
        tree["timeout"] = 7.0
        path = tmp_path / "edited.yaml"
        path.write_text(yaml.safe_dump({f"/{name}": {"ros__parameters": tree}}))
        loaded = ros2_param("load", domain, f"/{name}", path, "--timeout", 30)
        assert "failed" not in loaded.stdout + loaded.stderr
        again = yaml.safe_load(ros2_param("dump", domain, f"/{name}", "--timeout", 30).stdout)
        assert again[f"/{name}"]["ros__parameters"]["timeout"] == 7.0


def test_the_page_sets_a_parameter_without_ros2(domain, peer, tmp_path):
    from rcl_interfaces.srv import GetParameters

    page = (Path(__file__).parents[2] / "docs" / "nodes.md").read_text(encoding="utf-8")
    script = tmp_path / "setter.py"
    script.write_text(page.partition("```python\n")[2].partition("```")[0])
    service = peer.node.create_client(GetParameters, "wire_elasticity/get_parameters")
    with running("wire_elasticity", domain=domain):
        done = subprocess.run(
            [sys.executable, str(script)],
            env=environment(domain),
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        assert "successful=True" in done.stdout, done.stderr
        asked = GetParameters.Request(names=["effects.backlash.half_width"])
        assert list(peer.call(service, asked).values[0].double_array_value) == [0.002] * len(JOINTS)
