"""Examples are the same in every run, so that what passed passes again. Long files begin first, so that no
worker is left alone with one in the end.

HYPOTHESIS_PROFILE=explore draws new ones.
"""

import os
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

ROOT = Path(__file__).parent
LONG = (
    "diagnosis/test_labelled.py",
    "diagnosis/test_against.py",
    "diagnosis/test_experiment.py",
    "diagnosis/test_real.py",
    "diagnosis/test_real_links.py",
    "diagnosis/test_several.py",
    "diagnosis/test_diagnose.py",
    "packaging/test_pip.py",
    "packaging/test_colcon.py",
    "concealed/test_demo.py",
    "diagnosis/test_real_sheath.py",
    "diagnosis/test_events.py",
    "diagnosis/test_swinging.py",
    "diagnosis/test_stations.py",
    "test_effort.py",
    "effects/test_conformance.py",
    "effects/test_recovery.py",
    "test_pages_run.py",
    "fleet/test_command.py",
    "diagnosis/search/test_moves.py",
    "bodies/test_bodies.py",
    "diagnosis/test_align.py",
    "diagnosis/test_arm_stage.py",
    "nodes/test_concealed.py",
    "nodes/test_watch.py",
    "nodes/test_bringup.py",
    "nodes/test_action.py",
    "nodes/test_recorder.py",
    "nodes/test_hold.py",
    "nodes/test_hostile.py",
    "nodes/test_compensator.py",
    "nodes/test_parameters.py",
    "nodes/test_process.py",
    "nodes/test_replay.py",
)
"""From the longest on, by processor time; it is no claim, and only `--no-loadscope-reorder` heeds it."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long files first, all else as it is."""
    place = {ROOT / name: k for k, name in enumerate(LONG)}
    items.sort(key=lambda item: place.get(item.path, len(LONG)))
