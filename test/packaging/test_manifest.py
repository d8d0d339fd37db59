"""package.xml, setup.py and the lock say the same, and say all that the code needs."""

import re
import sys
from functools import cache
from xml.etree import ElementTree

import trunk_ros
from test.packaging.imports import ROOT, imported, modules
from trunk_ros.__main__ import COMMANDS

# import name: (distribution on PyPI, rosdep key)
PROVIDERS = {
    "numpy": ("numpy", "python3-numpy"),
    "scipy": ("scipy", "python3-scipy"),
    "numba": ("numba", "python3-numba"),
    "yaml": ("pyyaml", "python3-yaml"),
    "jinja2": ("jinja2", "python3-jinja2"),
    "matplotlib": ("matplotlib", "python3-matplotlib"),
    "rich": ("rich", "python3-rich"),
    "rosbags": ("rosbags", "python3-rosbags-pip"),
    "mcap": ("mcap", "mcap-ros2-support"),
    "lz4": ("lz4", "mcap-ros2-support"),
    "zstandard": ("zstandard", "mcap-ros2-support"),
    "pinocchio": ("pin", "pinocchio"),
    "argcomplete": ("argcomplete", "python3-argcomplete"),
    "threadpoolctl": (
        "threadpoolctl",
        None,
    ),  # rosdep has no key; without it more CPU
    "pandas": ("pandas", None),  # the extra [tables]: pip's, not rosdep's
    "markupsafe": ("jinja2", "python3-jinja2"),
    "dask": ("distributed", None),  # the extra [fleet]: pip's, not rosdep's
    "distributed": ("distributed", None),
    "pyarrow": ("pyarrow", None),
    "ruptures": ("ruptures", None),
    "fsspec": ("fsspec", None),
    "control_msgs": (None, "control_msgs"),  # not on PyPI
    "tf2_msgs": (None, "tf2_msgs"),
    "rerun": ("rerun-sdk", None),  # the extra [show]: pip's, not rosdep's
    "mujoco": ("mujoco-core", None),  # an extra: export says so where it is missing
    "launch": (None, "launch"),
    "launch_ros": (None, "launch_ros"),
}


@cache
def manifest():
    return ElementTree.parse(ROOT / "package.xml").getroot()


def foreign_imports():
    files = modules("trunk_ros") + modules("launch")
    names = {name.partition(".")[0] for path in files for name in imported(path)}
    return sorted(names - sys.stdlib_module_names - {"trunk_ros", ""})


def providers(name):
    return PROVIDERS.get(name, (f"ros-jazzy-{name.replace('_', '-')}", name))


def setup_requirements():
    found = re.findall(r'^    "([A-Za-z0-9-]+)[<>=~]', (ROOT / "setup.py").read_text(), re.MULTILINE)
    return {name.lower() for name in found}


@cache
def lock():
    return (ROOT / "requirements/lock.txt").read_text()


def test_every_import_is_a_dependency_in_package_xml():
    keys = {element.text for element in manifest().iter("exec_depend")}
    assert [name for name in foreign_imports() if providers(name)[1] not in {*keys, None}] == []


def test_every_import_is_a_requirement_in_setup_py():
    wanted = {name: providers(name)[0] for name in foreign_imports()}
    assert set(filter(None, wanted.values())) <= setup_requirements()


def test_every_requirement_is_pinned_by_hash_in_the_lock():
    assert setup_requirements() <= set(re.findall(r"^([a-z0-9.-]+)==\S+ ", lock(), re.MULTILINE))
    entries = re.split(r"\n(?=\S)", lock().strip())
    assert [entry for entry in entries if "--hash=sha256:" not in entry] == []


def test_the_lock_names_no_index_and_no_place():
    assert not re.search(r"https?:|file:|--(extra-)?index|--find-links|--trusted", lock())


def test_package_manifest_and_changelog_have_one_version():
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    newest = re.search(r"^## (\S+)", changelog, re.MULTILINE)
    assert newest is not None
    assert trunk_ros.__version__ == manifest().findtext("version") == newest[1]


def test_every_command_is_there():
    nodes = {"servo_driver", "wire_elasticity", "compensator", "recorder", "replay", "watch"}
    assert nodes | {"bringup", "diagnose", "simulate", "import", "fleet"} <= set(COMMANDS)
