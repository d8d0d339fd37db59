"""`pip install .` gives the half that needs no ROS."""

import sys
import sysconfig
import zipfile
from email import message_from_bytes
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from trunk_ros.__main__ import COMMANDS

MAIN = "trunk_ros.__main__:main"
pytestmark = pytest.mark.timeout(300)  # builds two wheels


def needed(requirements, known):
    """What these and all that they require in turn are here: distributions by name, as pip would choose."""
    for one in map(Requirement, requirements or ()):
        if (one.marker is None or one.marker.evaluate({"extra": ""})) and one.name not in known:
            known[one.name] = distribution(one.name)
            needed(known[one.name].requires, known)
    return known


def tops(held):
    """The files and folders that a distribution has in the folder of imports."""
    return {file.parts[0] for file in held.files or () if file.parts[0] not in ("..", "__pycache__")}


@pytest.fixture(scope="module")
def wheel(source, run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    options = ["--no-deps", "--no-build-isolation", "--wheel-dir", folder]
    run(sys.executable, "-m", "pip", "wheel", *options, source, cwd=folder)
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def python(wheel, run, tmp_path_factory):
    """A fresh environment with the wheel, and links to what it says it requires and to nothing else: to
    install all of that anew takes longer than all other tests of a package.
    """
    folder = tmp_path_factory.mktemp("fresh")
    run(sys.executable, "-m", "venv", "--without-pip", folder / "venv", cwd=folder)
    pip = [sys.executable, "-m", "pip", "--python", folder / "venv"]
    run(*pip, "install", "-q", "--no-compile", "--no-deps", wheel, cwd=folder)
    files = zipfile.ZipFile(wheel)
    about = files.read(next(name for name in files.namelist() if name.endswith(".dist-info/METADATA")))
    here = Path(sysconfig.get_path("purelib"))
    there = folder / "venv" / here.relative_to(sys.prefix)
    for name in set().union(
        *map(tops, needed(message_from_bytes(about).get_all("Requires-Dist"), {}).values())
    ):
        (there / name).symlink_to(here / name)
    return folder / "venv/bin/python"


def test_the_wheel_holds_every_file_of_the_package_and_its_configuration(wheel, source):
    held = {name.rpartition(".data/data/share/trunk_ros/")[2] for name in zipfile.ZipFile(wheel).namelist()}
    files = [path for folder in ("trunk_ros", "config", "launch") for path in (source / folder).rglob("*")]
    files = [path for path in files if path.is_file() and path.parent.name != "__pycache__"]
    assert {str(path.relative_to(source)) for path in files} <= held


def test_the_source_distribution_builds_the_same_wheel(wheel, source, run, tmp_path):
    run(sys.executable, "setup.py", "-q", "sdist", "--dist-dir", tmp_path, cwd=source)
    options = ["--no-deps", "--no-build-isolation", "--wheel-dir", tmp_path]
    run(sys.executable, "-m", "pip", "wheel", *options, next(tmp_path.glob("*.tar.gz")), cwd=tmp_path)
    again = next(tmp_path.glob("*.whl"))
    assert sorted(zipfile.ZipFile(again).namelist()) == sorted(zipfile.ZipFile(wheel).namelist())


def test_a_wheel_puts_one_command_on_the_path_and_no_import_beside_others(wheel):
    files = zipfile.ZipFile(wheel)
    entry = next(name for name in files.namelist() if name.endswith("entry_points.txt"))
    assert files.read(entry).decode().split() == ["[console_scripts]", "trunk_ros", "=", MAIN]


def test_without_ros_help_names_every_command(python, run, tmp_path):
    run(python, "-c", "import importlib.util as u; assert u.find_spec('rclpy') is None", cwd=tmp_path)
    shown = run(python, "-m", "trunk_ros", "--help", cwd=tmp_path).stdout
    assert [name for name in COMMANDS if name not in shown] == []
    assert run(python.with_name("trunk_ros"), "--help", cwd=tmp_path).stdout == shown


@pytest.mark.parametrize("name", ["simulate", "diagnose", "import", "recover", "info", "check", "effects"])
def test_without_ros_these_commands_start(python, run, tmp_path, name):
    assert "usage" in run(python, "-m", "trunk_ros", name, "--help", cwd=tmp_path).stdout.lower()


def test_an_installed_package_finds_its_configuration(python, run, tmp_path):
    code = "from trunk_ros.share import config_path; print(config_path('trunk'))"
    found = run(python, "-c", code, cwd=tmp_path).stdout.strip()
    assert found == str(python.parents[1] / "share/trunk_ros/config/trunk.yaml")
