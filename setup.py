"""Builds the package for colcon (ament_python) and for pip. What package.xml says is read from there."""

import ast
import sys
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

MANIFEST = ElementTree.parse("package.xml").getroot()
NAME = MANIFEST.findtext("name")

REQUIRES = [
    "numpy>=1.26",
    "scipy>=1.11",
    "numba>=0.58",
    "PyYAML>=6.0",
    "Jinja2>=3.1",
    "matplotlib>=3.6",
    "threadpoolctl>=3.1",
    "rich>=13.7",
    "argcomplete>=3.1",
    "rosbags>=0.10.11,<0.12",
    "mcap>=1.2.1",
    "lz4>=4.0",
    "zstandard>=0.22",
    "pin>=3.4; platform_system != 'Windows'",  # Pinocchio; on Windows conda has it
]
ROS = [
    "ros-jazzy-rclpy~=7.1",
    "ros-jazzy-rmw-fastrtps-cpp~=8.4",
    "ros-jazzy-ament-index-python~=1.8",
    "ros-jazzy-builtin-interfaces~=2.0",
    "ros-jazzy-rcl-interfaces~=2.0",
    "ros-jazzy-std-msgs~=5.3",
    "ros-jazzy-std-srvs~=5.3",
    "ros-jazzy-sensor-msgs~=5.3",
    "ros-jazzy-geometry-msgs~=5.3",
    "ros-jazzy-trajectory-msgs~=5.3",
    "ros-jazzy-diagnostic-msgs~=5.3",
    "ros-jazzy-lifecycle-msgs~=2.0",
    "ros-jazzy-rosgraph-msgs~=2.0",
]

MUJOCO = [
    "mujoco-core>=4.0",
]
SHOW = [
    "rerun-sdk>=0.41",
]
TABLES = [
    "pandas>=2.1",
]
FLEET = [
    "distributed>=2024.8",
    "pyarrow>=16",
    "ruptures>=1.1.9",
    "fsspec>=2024.2",
]


def commands():
    """Keys of COMMANDS in trunk_ros/__main__.py, read without importing what may not be installed yet."""
    for node in ast.parse(Path(NAME, "__main__.py").read_text(encoding="utf-8")).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(target, ast.Name) and target.id == "COMMANDS" for target in targets):
            return [ast.literal_eval(key) for key in node.value.keys]
    raise SystemExit(f"setup.py: no dict COMMANDS in {NAME}/__main__.py")


def scripts():
    """`ros2 run` wants an executable per command. pip's bin/ is on the PATH, where names such as `import`
    belong to others, so a wheel brings one script that takes the command as its first argument."""
    wheel = {"bdist_wheel", "editable_wheel", "dist_info"} & set(sys.argv)
    return [f"{name} = {NAME}.__main__:main" for name in ([NAME] if wheel else commands())]


def share(folder):
    """Files of a folder, with its subfolders, for share/trunk_ros."""
    files = sorted(path for path in Path(folder).rglob("*") if path.is_file() and path.suffix != ".pyc")
    return [(f"share/{NAME}/{path.parent}", [str(path)]) for path in files]


DATA = [f"**/*.{suffix}" for suffix in ("html", "j2", "css", "js", "json", "yaml", "txt")]

setup(
    name=NAME,
    version=MANIFEST.findtext("version"),
    description=MANIFEST.findtext("description"),
    license=MANIFEST.findtext("license"),
    maintainer=MANIFEST.findtext("maintainer"),
    maintainer_email=MANIFEST.find("maintainer").get("email"),
    python_requires=">=3.11",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed", *DATA]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *share("config"),
        *share("launch"),
    ],
    install_requires=REQUIRES,
    extras_require={"ros": ROS, "mujoco": MUJOCO, "show": SHOW, "tables": TABLES, "fleet": FLEET},
    entry_points={"console_scripts": scripts()},
    zip_safe=False,
)
