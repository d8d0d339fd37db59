"""Claims about loops of servos that run faster than each 2 ms, and are described right otherwise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import diagnose
from test.diagnosis.test_nominal_servo import JOINTS, NOISE, PERIOD, PLAIN, _asked, _stated, recorded_servos
from trunk_ros.compiled import Array
from trunk_ros.data.quality import servo_remarks
from trunk_ros.diagnosis import Diagnosis
from trunk_ros.diagnosis.servos import described_servo
from trunk_ros.diagnosis.servos.described_servo import Told
from trunk_ros.errors import ModelError
from trunk_ros.model import load_model, save_model
from trunk_ros.recording.recording import JointSeries, Recording

TAU_V, V_MAX = 0.02, 5.0


def _path(asked: Array, step: float, kp: float) -> Array:
    """(n,) rad under setpoints (n,) that come each PERIOD, in a loop that runs each ``step`` s."""
    phi, v, out = float(asked[0]), 0.0, []
    for target in asked.tolist():
        out.append(phi)
        for _ in range(round(PERIOD / step)):
            v += step / TAU_V * (min(max(kp * (target - phi), -V_MAX), V_MAX) - v)
            phi += step * v
    return np.array(out)


def faster(step: float, kp: float = 20.0) -> Recording:
    """Three servos in 15 s."""
    t = np.arange(0.0, 15.0, PERIOD)
    asked = _asked(t, 1)
    went = np.column_stack([_path(column, step, kp) for column in asked.T])
    went += NOISE / 5.0 * np.random.default_rng(4).standard_normal(went.shape)
    series = {name: JointSeries(t, JOINTS, x) for name, x in (("setpoints", asked), ("gearbox_states", went))}
    return Recording("faster", 0, float(t[-1]), series)


def names(found: Diagnosis) -> list[str]:
    return [one.effect for one in found.findings]


@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_a_loop_that_runs_faster_is_no_mismatch(step: float, tmp_path: object) -> None:
    """The angles differ by up to 0.5 mrad from the reference's, fifty times the noise."""
    found = diagnose(faster(step), model=_stated())
    assert (found.verdict, names(found)) == ("no_mismatch", [])
    assert found.model.arm.step == pytest.approx(step, abs=3e-4)
    (quality,) = found.quality.values()
    assert any("(servo.step)" in note for note in quality["notes"])
    save_model(found.model, f"{tmp_path}/model.yaml")
    assert load_model(f"{tmp_path}/model.yaml").arm.step == found.model.arm.step


def test_what_is_wrong_with_its_gain_is_still_named() -> None:
    found = diagnose(faster(1e-4, kp=24.0), model=_stated())
    assert (found.verdict, names(found)) == ("explained", ["servo_bandwidth"])


def test_what_one_servo_has_besides_hides_no_steps_of_all() -> None:
    """It leaves forty times what the steps of the others do, which passed for a delay of all."""
    run = faster(1e-4, kp=24.0)
    went = run.series["gearbox_states"]
    went.position[:, 0] += 2e-3 * np.sin(8.0 * went.position[:, 0])
    found = diagnose(run, model=_stated())
    assert found.model.arm.step < 5e-4
    assert "servo_bandwidth" in names(found)
    assert "servo_delay" not in names(found)


def test_the_references_own_steps_stay() -> None:
    for kp in (20.0, 24.0):
        found = diagnose(recorded_servos(PLAIN | {"kp": (kp,) * 3}, after=0.0), model=_stated())
        assert found.model.arm.step == 2e-3


def test_a_step_that_no_servo_runs_in_is_refused() -> None:
    with pytest.raises(ModelError, match=r"servo\.step"):
        _stated(step=0.5)


def test_where_the_first_joints_leave_too_much_the_others_are_not_fitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nor what is told: it leaves at most what it leaves as it is."""
    told, asked = described_servo._told(_stated(), [faster(1e-3)]), []

    def left(some: Sequence[Told], *_: object) -> Array:
        asked.append(len(some))
        return np.full(len(some), 1e6 if len(asked) == 2 else 0.0)

    monkeypatch.setattr(described_servo, "_left", left)
    assert not described_servo._clearly_nearer(told, told)
    assert asked == [1, 1]


def test_faster_loops_are_said_to_be_no_fault() -> None:
    asked = JointSeries(np.arange(9.0), ("a",), np.zeros((9, 1)))
    model = load_model("trunk")
    (said,) = servo_remarks(
        Recording("made", 0, 9.0, {"setpoints": asked}), replace(model, arm=replace(model.arm, step=1e-3))
    )
    assert "loops that run each 1 ms (servo.step): no fault, " in said
