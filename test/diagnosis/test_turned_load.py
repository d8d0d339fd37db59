"""A load cell whose sign is turned is told from what its joint does."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import reshaped
from test.diagnosis.test_measured_load import loaded
from trunk_ros.diagnosis import diagnose
from trunk_ros.recording.recording import Recording


def turned(recording: Recording) -> Recording:
    """The same with the load cell the other way round."""
    effort = recording.series["joint_states"].effort
    assert effort is not None
    return reshaped(recording, "joint_states", effort=-effort)


def notes(recording: Recording) -> list[str]:
    said = diagnose(recording, model="direct", experiments=False).quality["loaded"]["notes"]
    return [note for note in said if "sign" in note]


def test_a_joint_that_gives_way_against_its_load_has_a_load_cell_with_a_turned_sign() -> None:
    (note,) = notes(turned(loaded()))
    assert note.startswith("effort of joint_states of jaw looks as if its sign were turned")
    assert '{expr: "0 - column"}' in note


@pytest.mark.parametrize("stretches", [1.0, 0.0])
def test_a_joint_that_yields_to_its_load_or_to_none_has_a_load_cell_with_the_right_sign(
    stretches: float,
) -> None:
    made = loaded()
    shown = made.series["joint_states"]
    assert shown.effort is not None
    less = (1.0 - stretches) * 0.075 * np.log1p(shown.effort / 0.05)
    assert not notes(reshaped(made, "joint_states", position=shown.position - less))
