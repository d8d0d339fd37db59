"""Real recordings, where they lie beside the project, and what is found on them: each is diagnosed once."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from test.diagnosis.arms import diagnose
from trunk_ros.diagnosis import Diagnosis
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.recording import Recording
from trunk_ros.share import config_path

REAL = Path(__file__).parents[3] / "shared" / "real"
QUASI_STATIC = {"sensor_delay", "viscous_lag", "stribeck_friction", "link_resonance"}


def marks(folder: str) -> list[pytest.MarkDecorator]:
    """Of tests that need the recordings of a folder."""
    absent = not (REAL / folder).is_dir()
    return [pytest.mark.skipif(absent, reason="no real recordings here"), pytest.mark.timeout(1200)]


def read(folder: str, name: str, mapping: str, joints: tuple[str, ...] = ()) -> Recording:
    """A recording, of all joints or of some."""
    whole = read_csv(REAL / folder / f"{name}.csv", config_path(f"import/{mapping}"))
    some = {key: series.select(joints or series.joints) for key, series in whole.series.items()}
    return replace(whole, series=some)


@cache
def diagnosed(
    folder: str, name: str, mapping: str, until: str | None = None, joints: tuple[str, ...] = ()
) -> Diagnosis:
    """What is found where nothing is known of the arm; tests share it, and change nothing in it."""
    return diagnose([read(folder, name, mapping, joints)], model="direct", until=until)


def named(result: Diagnosis) -> set[str]:
    """The effects that were found."""
    return {f.effect for f in result.findings}


def value(result: Diagnosis, effect: str, joint: str, parameter: str) -> tuple[float, float]:
    """Value and spread; what was not found is 0."""
    found = [f for f in result.findings if f.effect == effect]
    if not found:
        return 0.0, 0.0
    told = found[0].parameters[joint][parameter]
    return told["value"], told["std"]
