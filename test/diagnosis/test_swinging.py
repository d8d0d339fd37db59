"""A link that swings while the other joints shake it, on an arm of tendons and masses in an engine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from test.concealed.bag import write_bag
from test.concealed.mujoco_case import draw_mujoco_case
from test.diagnosis.arms import diagnose
from trunk_ros.compiled import Array
from trunk_ros.model import Model, load_model
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.simulate import simulate


def error(model: Model, recording: Recording) -> Array:
    """(joints,) rms [rad] of what a model predicts of the joints less what they show, after 3 s."""
    joints, said = recording.series["joint_states"], simulate(recording, model).series["joint_states"]
    off = (said.position - joints.position)[joints.stamp > 3.0]
    return np.asarray(np.sqrt((off**2).mean(axis=0)))


@pytest.mark.parametrize("seed", [6082, 6037])
def test_a_link_that_swings_is_told_by_the_masses_that_shake_it(seed: int, tmp_path: Path) -> None:
    case = draw_mujoco_case(seed, "link_resonance")
    for run, name in ((case.train, "train"), (case.test, "test")):
        write_bag(run, tmp_path / name, seed)
    result = diagnose([tmp_path / "train"])

    (hidden,), (found,) = case.truth, result.findings
    (joint,) = hidden["joints"]
    assert (found.effect, found.joints, found.evidence["form"]) == ("link_resonance", [joint], "links")
    said = found.parameters[joint]["frequency"]
    wanted = hidden["parameters"][joint]["frequency"]
    assert said["value"] == pytest.approx(wanted, abs=0.01 * wanted + 3 * said["std"])

    other, column = read_recording(tmp_path / "test"), int(joint[-1]) - 1
    assert error(result.model, other)[column] < 0.15 * error(load_model("trunk"), other)[column]
