"""Claims about recorded setpoints of servos that the model states: they may be samples of what moves on
between them, where it does not say that they are held.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import diagnose
from test.diagnosis.test_nominal_servo import JOINTS, NOISE, PLAIN, _stated, recorded_servos, reference
from trunk_ros.arm.arm import STEP
from trunk_ros.compiled import Array
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.recording.recording import JointSeries, Recording

EVERY = 5  # steps of the plant, from one row of the table to the next


def _asked(t: Array, fastest: float) -> Array:
    """(n, joints) rad: a profile that is smooth, with speeds up to about ``fastest`` Hz."""
    rng = np.random.default_rng(5)
    out = np.zeros((len(t), len(JOINTS)))
    for frequency in np.linspace(0.1, 1.0, 4) * fastest:
        out += rng.uniform(0.1, 0.3, 3) * np.sin(2 * np.pi * frequency * t[:, None] + rng.uniform(0, 6, 3))
    return out * np.clip(t / 2, 0.0, 1.0)[:, None]


def sampled(fastest: float = 0.5, kp: float = 20.0, seconds: float = 20.0) -> Recording:
    """A table of what was asked and of shafts, of servos that were asked every 2 ms."""
    t = np.arange(0.0, seconds, STEP)
    asked = _asked(t, fastest)
    went = np.column_stack([reference(column, 1, kp, 0.02, 5.0)[: len(t)] for column in asked.T])
    went += NOISE * np.random.default_rng(2).standard_normal(went.shape)
    some = slice(0, None, EVERY)
    series = {"setpoints": JointSeries(t[some], JOINTS, asked[some])}
    series["gearbox_states"] = JointSeries(t[some], JOINTS, went[some])
    return Recording("sampled", 0, seconds, series)


@pytest.mark.parametrize("fastest", [0.3, 1.2], ids=["slow", "fast"])
def test_samples_of_a_profile_are_no_quicker_servo(fastest: float) -> None:
    """Half of the time from one to the next had been a ``servo_bandwidth`` of 0.11."""
    found = diagnose(sampled(fastest), model=_stated())
    assert (found.verdict, found.model.setpoints) == ("no_mismatch", "sampled")
    assert any("samples of what moves on" in note for note in found.quality["sampled"]["notes"])


def test_what_other_servos_would_explain_as_well_is_samples_all_the_same() -> None:
    """Read in counts of 0.8 mrad, other delays nearly explain it too: it had been a ``servo_delay``."""
    made, fine = sampled(), 2 * np.pi / 2**13
    shafts = made.series["gearbox_states"]
    coarse = replace(shafts, position=np.round(shafts.position / fine) * fine)
    found = diagnose(replace(made, series={**made.series, "gearbox_states": coarse}), model=_stated())
    assert (found.verdict, found.model.setpoints) == ("no_mismatch", "sampled")


@pytest.mark.parametrize("kp", [20.0, 22.2, 26.0])
def test_setpoints_that_are_held_are_no_samples_whatever_the_servo(kp: float) -> None:
    found = diagnose(recorded_servos(PLAIN | {"kp": (kp,) * 3}, after=0.0), model=_stated())
    assert found.model.setpoints == "held"
    assert [one.effect for one in found.findings] == ["servo_bandwidth"] * (kp != 20.0)


def test_what_the_model_says_of_setpoints_stays(tmp_path: object) -> None:
    stated = replace(_stated(), setpoints_stated=True)
    save_model(stated, f"{tmp_path}/model.yaml")
    read: Model = load_model(f"{tmp_path}/model.yaml")
    assert (read.setpoints, read.setpoints_stated) == ("held", True)
    assert diagnose(sampled(), model=read).model.setpoints == "held"
    save_model(_stated(), f"{tmp_path}/silent.yaml")
    assert not load_model(f"{tmp_path}/silent.yaml").setpoints_stated
