"""colcon builds the package, and what it installs runs."""

import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_prefix, get_package_share_directory
from sensor_msgs.msg import JointState

from test.nodes.domains import own_domain
from test.nodes.graph import Peer
from test.packaging.imports import ROOT
from trunk_ros.__main__ import COMMANDS

pytestmark = pytest.mark.timeout(180)


@pytest.fixture(scope="module", params=[[], ["--symlink-install"]], ids=["copied", "symlinked"])
def workspace(request, source, run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("workspace")
    (folder / "src").mkdir()
    (folder / "src/trunk_ros").symlink_to(source)
    run(sys.executable, "-m", "colcon", "build", *request.param, cwd=folder)
    return folder


@pytest.fixture
def sourced(workspace):
    """sourced(*words) -> words for a shell that has the workspace sourced and becomes that program."""

    def words(*command):
        return ["bash", "-c", f"source install/setup.bash && exec {shlex.join(map(str, command))}"]

    return words


@pytest.fixture
def executables(workspace):
    return workspace / "install/trunk_ros/lib/trunk_ros"


def test_the_ament_index_knows_the_package(workspace, monkeypatch):
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(workspace / "install/trunk_ros"))
    assert Path(get_package_prefix("trunk_ros")) == workspace / "install/trunk_ros"
    share = Path(get_package_share_directory("trunk_ros"))
    assert (share / "package.xml").is_file()
    assert (share / "config/trunk.yaml").is_file()


def test_every_command_is_an_executable(executables):
    assert sorted(path.name for path in executables.iterdir()) == sorted(COMMANDS)
    assert all(os.access(path, os.X_OK) for path in executables.iterdir())


def test_an_installed_tool_runs_from_the_workspace(workspace, executables, sourced, run):
    assert "usage" in run(*sourced(executables / "simulate", "--help"), cwd=workspace).stdout.lower()
    code = "from trunk_ros import share; print(share.__file__, share.config_path('trunk'))"
    places = run(*sourced(sys.executable, "-c", code), cwd=workspace).stdout.split()
    assert [place for place in places if Path(place).is_relative_to(ROOT)] == []


@pytest.fixture
def peer():
    with own_domain() as domain, Peer(domain) as peer:
        yield peer


@pytest.fixture
def driver(workspace, executables, sourced, bare, peer):
    domain = str(peer.context.get_domain_id())
    env = bare | {"ROS_DOMAIN_ID": domain, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = sourced(executables / "servo_driver")
    with subprocess.Popen(command, cwd=workspace, env=env, stderr=subprocess.PIPE, text=True) as process:
        yield process
        process.kill()  # in case the test failed before it ended


def test_an_installed_node_publishes_and_ends_well_on_sigint(driver, peer):
    heard = peer.listen(JointState, "trunk/gearbox_states")
    peer.until(lambda: heard, timeout=60)
    driver.send_signal(signal.SIGINT)
    said = driver.communicate(timeout=30)[1]
    assert list(heard[0].name) == [f"joint_{i}" for i in range(1, 6)]
    assert driver.returncode == 0, said
