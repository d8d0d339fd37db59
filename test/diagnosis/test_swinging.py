"""A link that swings while the other joints shake it, on an arm of tendons and masses in an engine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import TransferFunction, lsim

from test.concealed.bag import write_bag
from test.concealed.mujoco_case import draw_mujoco_case
from test.diagnosis.arms import diagnose, of_the_wires
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


@pytest.mark.long
@pytest.mark.parametrize("seed", [6082, 6037])
def test_a_link_that_swings_is_told_by_the_masses_that_shake_it(seed: int, tmp_path: Path) -> None:
    case = draw_mujoco_case(seed, "link_resonance")
    for run, name in ((case.train, "train"), (case.test, "test")):
        write_bag(run, tmp_path / name, seed)
    result = diagnose([of_the_wires(read_recording(tmp_path / "train"))])

    (hidden,), (found,) = case.truth, result.findings
    (joint,) = hidden["joints"]
    assert (found.effect, found.joints, found.evidence["form"]) == ("link_resonance", [joint], "links")
    said = found.parameters[joint]["frequency"]
    wanted = hidden["parameters"][joint]["frequency"]
    assert said["value"] == pytest.approx(wanted, abs=0.01 * wanted + 3 * said["std"])

    other, column = read_recording(tmp_path / "test"), int(joint[-1]) - 1
    assert error(result.model, other)[column] < 0.15 * error(load_model("trunk"), other)[column]


@pytest.mark.parametrize("damping", [0.3, 0.6, 0.9])
def test_a_link_that_its_wire_damps_is_told_whether_it_rings_or_not(damping: float) -> None:
    """The damping is nowhere else: an oscillator of another package (SciPy) moves the link."""
    stamp = np.arange(0.0, 40.0, 0.01)
    begun, far = np.arange(0.5, 40.0, 1.2), np.random.default_rng(3).uniform(-0.4, 0.4, 33)
    share = np.clip((stamp[:, None] - begun) / 0.4, 0.0, 1.0)
    motor = (3 * share**2 - 2 * share**3) @ np.diff(far, prepend=0.0)
    omega = 2 * np.pi * 5.0
    link = TransferFunction([2 * damping * omega, omega**2], [1.0, 2 * damping * omega, omega**2])
    joint = lsim(link, motor, stamp)[1] + 1e-4 * np.random.default_rng(4).standard_normal(len(stamp))
    recording = Recording.from_arrays(stamp, motor=motor, joint=joint, joints=["a"], unit="rad")
    (found,) = diagnose(recording, model="direct").findings
    assert (found.effect, found.evidence["form"]) == ("link_resonance", "relative")
    told = {name: value["value"] for name, value in found.parameters["a"].items()}
    assert told == pytest.approx({"frequency": 5.0, "damping": damping}, rel=0.05)
