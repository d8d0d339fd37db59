"""Examples are the same in every run, so that what passed passes again. Long files begin first, so that no
worker is left alone with one in the end.

HYPOTHESIS_PROFILE=explore draws new ones.
"""

import gc
import os
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

ROOT = Path(__file__).parent
LONG = (
    "fleet/test_servos.py",
    "packaging/test_pip.py",
    "diagnosis/test_real.py",
    "diagnosis/test_labelled.py",
    "diagnosis/test_several.py",
    "diagnosis/test_events.py",
    "diagnosis/test_wandering.py",
    "diagnosis/search/test_slow_noise.py",
    "diagnosis/test_experiment.py",
    "diagnosis/test_changes.py",
    "diagnosis/test_real_sheath.py",
    "diagnosis/test_diagnose.py",
    "diagnosis/test_nominal_servo.py",
    "test_pages_run.py",
    "effects/test_conformance.py",
    "test_effort.py",
    "export/test_reality.py",
    "diagnosis/test_real_links.py",
    "fleet/test_command.py",
    "concealed/test_masses.py",
    "diagnosis/test_against.py",
    "effects/test_adding_an_effect.py",
    "diagnosis/test_unnamed.py",
    "diagnosis/search/test_moves.py",
    "effects/test_recovery.py",
    "test_chain.py",
    "effects/test_formulas.py",
    "diagnosis/test_report.py",
    "diagnosis/test_bend.py",
    "bodies/test_bodies.py",
    "data/test_sensing.py",
    "data/test_stations.py",
    "diagnosis/test_arm_stage.py",
    "diagnosis/test_swinging.py",
    "recording/test_fuzz.py",
    "diagnosis/test_long.py",
    "recording/test_bombs.py",
    "data/test_offset.py",
    "test_examples.py",
    "test_model.py",
    "data/test_align.py",
    "diagnosis/test_one_arm.py",
    "test_hostile_input.py",
    "concealed/test_case.py",
    "test_bench.py",
    "diagnosis/test_space_cases.py",
    "nodes/test_concealed.py",
    "nodes/test_bringup.py",
    "nodes/test_action.py",
    "concealed/test_demo.py",
    "nodes/test_hold.py",
    "nodes/test_recorder.py",
    "nodes/test_watch.py",
    "nodes/test_replay.py",
    "nodes/test_compensator.py",
    "nodes/test_bringup_refuses.py",
    "nodes/test_hostile.py",
    "packaging/test_colcon.py",
    "nodes/test_recorder_disk.py",
    "nodes/test_compensation.py",
    "nodes/test_process.py",
    "nodes/test_lifecycle.py",
    "nodes/test_slow_feedback.py",
    "nodes/test_hardware.py",
)
"""From the longest on; it is no claim, and only `--no-loadscope-reorder` heeds it. The second one waits for
others, so that what the first one compiles is there for all."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long files first, all else as it is."""
    place = {ROOT / name: k for k, name in enumerate(LONG)}
    items.sort(key=lambda item: place.get(item.path, len(LONG)))


def pytest_collection_finish() -> None:
    """What was collected stays: to look through it for garbage again and again takes a tenth of the time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)
