"""A copy of the sources to build from, so that builds leave nothing in the checkout."""

import os
import shutil
import subprocess

import pytest

from test.packaging.imports import ROOT

NOT_SOURCES = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "build", "install", "log", "dist")


@pytest.fixture(scope="session")
def source(tmp_path_factory):
    return shutil.copytree(ROOT, tmp_path_factory.mktemp("source") / "trunk_ros", ignore=NOT_SOURCES)


@pytest.fixture(scope="session")
def bare():
    """The environment without what .venv and a sourced ROS put into it."""
    ours = ("PYTHON", "AMENT", "COLCON", "ROS_", "RMW_", "_ROS_WHEELS", "LD_LIBRARY_PATH", "VIRTUAL_ENV")
    return {name: value for name, value in os.environ.items() if not name.startswith(ours)}


@pytest.fixture(scope="session")
def run(bare):
    """run(*words, cwd, **environment) -> CompletedProcess that has ended with 0."""

    def call(*words, cwd, **environment):
        words = [str(word) for word in words]
        env = bare | environment
        done = subprocess.run(words, cwd=cwd, env=env, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done

    return call
