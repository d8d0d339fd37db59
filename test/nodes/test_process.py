"""Nodes as processes: help, and machines without ROS 2."""

import os
import subprocess
import sys

import pytest

from test.nodes.graph import ROOT, needs_ros
from trunk_ros.__main__ import main
from trunk_ros.nodes.parameters import PARAMETERS
from trunk_ros.nodes.usage import usage

NODES = ("servo_driver", "wire_elasticity", "compensator", "recorder")


@pytest.mark.parametrize("name", [*NODES, "replay", "bringup"])
def test_without_ros_one_sentence_says_what_to_install(name, tmp_path):
    blocked = (
        "import sys; sys.modules['rclpy'] = None; from trunk_ros.__main__ import main; sys.exit(main({}))"
    )
    script = blocked.format([name, *extra(name, tmp_path)])
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert "pip install '.[ros]'" in done.stderr
    assert not list(tmp_path.iterdir())


def extra(name, folder):
    """What a command needs to get as far as ROS."""
    return ["--output", str(folder / "bag"), "--seconds", "1"] if name == "bringup" else []


@needs_ros
@pytest.mark.parametrize("name", [*NODES, "replay", "bringup"])
def test_help_says_what_it_does_and_takes(command, name):
    done = command(name, "--help")
    assert done.returncode == 0
    assert name in done.stdout
    if name in NODES:
        assert "rate" in done.stdout
        assert "1 to 2000 Hz" in done.stdout


@needs_ros
def test_what_moves_the_arm_starts_without_scipy_and_numba():
    """Importing them takes longer than all else; numba comes with the first loop that runs."""
    modules = ["bringup", "bus", "replay", "tip_error", *NODES]
    look = "\n".join(f"import trunk_ros.nodes.{name}" for name in modules)
    look += "\nimport sys\nfrom trunk_ros.effects import registry\nregistry()"
    look += "\nprint({'scipy', 'numba'} & {*sys.modules})"
    done = subprocess.run([sys.executable, "-c", look], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout == "set()\n", done.stderr


@needs_ros
@pytest.mark.parametrize("name", PARAMETERS)
def test_help_lists_what_the_node_has_and_is_the_same_once_ros_is_there(name, peer, capsys):
    from trunk_ros.nodes.compose import kind_of
    from trunk_ros.nodes.graph.parameters import FOREIGN
    from trunk_ros.nodes.graph.process import run_node

    node = kind_of(name)(context=peer.context)
    own = node.settings.own - {*FOREIGN}
    assert usage(name).count("; default ") == len(own)
    assert [each for each in own if f"\n  {each}" not in usage(name) or not node.has_parameter(each)] == []
    assert node.needs_model == ("parameter of a model" in usage(name)) == hasattr(node, "model")
    assert run_node(type(node), ["--help"]) == main([name, "--help"]) == 0
    assert capsys.readouterr().out == 2 * f"{usage(name)}\n"
    node.destroy_node()


@needs_ros
def test_a_file_of_parameters_that_is_not_there_is_one_line(command):
    done = command("compensator", "--ros-args", "--params-file", "nowhere.yaml")
    assert (done.returncode, done.stderr) == (
        2, "trunk_ros: --params-file nowhere.yaml: there is no such file\n",
    )  # fmt: skip


def test_a_file_of_parameters_may_be_a_pipe_and_is_no_folder(tmp_path):
    from trunk_ros.errors import TrunkError
    from trunk_ros.nodes.graph.process import look_for_files

    read, write = os.pipe()
    try:
        look_for_files(["--ros-args", "--params-file", f"/dev/fd/{read}"])
    finally:
        os.close(read)
        os.close(write)
    with pytest.raises(TrunkError, match="it is a folder"):
        look_for_files(["--ros-args", "--params-file", str(tmp_path)])


@needs_ros
def test_a_parameter_that_a_node_does_not_have_is_said_with_the_nearest_name(command):
    done = command("recorder", "--ros-args", "-p", "outptu:=bag", "-p", "wire.ratio:=[0.5]")
    assert "unknown parameter 'outptu': did you mean 'output'?" in done.stderr
    assert "wire.ratio" not in done.stderr
