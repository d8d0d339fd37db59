"""How the wires lay when a recording began is told by its first joint angles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.effects.example import arm_of
from trunk_ros.chain import Chain
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.simulate import simulate
from trunk_ros.start import first_rows, moved_zero

T = np.arange(0.0, 40.0, 0.5)
CAME_FROM = np.array([0.3, -0.2])  # rad, joint side


def model() -> Model:
    """A wide play on one joint, and a drag by the other: both remember."""
    return Model(
        arm_of(2),
        {
            "backlash": {"half_width": np.array([0.1, 0.05])},
            "coupling_drag": {
                "weight_1_6": np.array([0.3, 0.0]), "low_1": np.full(2, 0.02), "high_1": np.full(2, 0.4),
                "source": ["joint_2", ""],
            },
        },
        error=np.full(2, 0.002),
        reach=np.full(2, 0.3),
    )  # fmt: skip


def recorded() -> tuple[Recording, np.ndarray]:
    """Joint 2 swings a little while joint 1 stands, after both have come from elsewhere."""
    asked = np.column_stack([np.zeros_like(T), 0.08 * np.sin(0.3 * T)]) / 0.625
    path = np.vstack([asked[0] + CAME_FROM / 0.625, asked])
    shown, _ = Chain(model(), "wire").run(path, np.concatenate([[-1.0], T]))
    joints = ("joint_1", "joint_2")
    series = {
        "gearbox_states": JointSeries(T, joints, asked),
        "joint_states": JointSeries(T, joints, shown[1:]),
    }
    return Recording("run", 0, float(T[-1]), series), shown[1:]


def off(settle: float) -> np.ndarray:
    """(joints,) rms after the first five seconds."""
    recording, true = recorded()
    predicted = simulate(recording, model(), settle=settle).series["joint_states"].position
    return np.asarray(np.sqrt(np.mean((predicted - true)[T >= 5.0] ** 2, axis=0)))


def test_the_state_at_the_start_is_what_the_first_angles_say() -> None:
    assert off(0.0)[0] > 0.05
    assert off(5.0)[0] < 0.01


def test_later_joint_angles_are_never_read() -> None:
    recording, _ = recorded()
    shown = recording.series["joint_states"]
    wrong = np.where((T >= 5.0)[:, None], shown.position + 1.0, shown.position)
    other = Recording(
        "run", 0, recording.duration, recording.series | {"joint_states": JointSeries(T, shown.joints, wrong)}
    )
    one, two = (simulate(r, model()).series["joint_states"].position for r in (recording, other))
    assert np.array_equal(one, two)


@pytest.mark.parametrize(("settle", "rows"), [(0.0, 0), (5.0, 10), (0.1, 1)])
def test_first_rows_are_those_within_the_time_and_one_at_least(settle: float, rows: int) -> None:
    assert first_rows(T, settle) == rows


def shifted(by: float) -> np.ndarray:
    """(joints,) mean of measured less predicted after the first five seconds, where the second joint's zero
    has moved ``by`` rad.
    """
    recording, true = recorded()
    shown = recording.series["joint_states"]
    moved = true + np.array([0.0, by])
    series = recording.series | {"joint_states": JointSeries(T, shown.joints, moved)}
    other = Recording("run", 0, recording.duration, series)
    predicted = simulate(other, model()).series["joint_states"].position
    return np.asarray((moved - predicted)[T >= 5.0].mean(axis=0))


def test_a_zero_has_moved_where_no_memory_explains_the_first_angles() -> None:
    assert np.abs(shifted(0.4)).max() < 0.02  # no play is as wide
    assert shifted(0.004)[1] == pytest.approx(0.004 + shifted(0.0)[1], abs=0.002)  # no more than chance


def test_what_varies_while_it_is_looked_at_is_no_zero_but_a_model_that_is_wrong() -> None:
    recording, true = recorded()
    shown = recording.series["joint_states"]
    off = np.where(np.arange(len(T)) % 2, 0.4, 0.0)[:, None] * [0.0, 1.0]
    series = recording.series | {"joint_states": JointSeries(T, shown.joints, true + off)}
    wrong = simulate(Recording("run", 0, recording.duration, series), model()).series["joint_states"].position
    assert abs(float((wrong - true)[T >= 5.0].mean(axis=0)[1])) < 0.1


def test_zeros_that_hardly_moved_stay_and_those_that_did_may_go_far() -> None:
    zero, gain = moved_zero(np.array([0.0, 2.0, 5.0, -100.0]), np.zeros(4))
    assert zero[:2].tolist() == gain[:2].tolist() == [0.0, 0.0]
    assert 4.0 < zero[2] < 5.0
    assert zero[3] == pytest.approx(-100.0, rel=0.001)


def test_zeros_that_differed_between_the_recordings_of_the_fit_differ_again() -> None:
    zero, gain = moved_zero(np.array([2.0, -2.0, -100.0]), np.array([3.0, 0.3, 3.0]))
    assert zero[:2] == pytest.approx([2.0 * 0.9, -2.0 * 0.09 / 1.09])
    assert gain[0] == pytest.approx(4.0 * 0.9)
    assert zero[2] == pytest.approx(-100.0, rel=0.01)


def test_a_model_knows_by_how_much_zeros_differ() -> None:
    recording, true = recorded()
    shown = recording.series["joint_states"]
    moved = true + np.array([0.0, 0.005])  # no more than its error may be by chance
    other = Recording(
        "run", 0, recording.duration, recording.series | {"joint_states": JointSeries(T, shown.joints, moved)}
    )
    left = {}
    for zero in (0.0, 0.01):
        known = replace(model(), zero=np.array([0.0, zero]))
        predicted = simulate(other, Model.from_parameters(known.parameters())).series["joint_states"].position
        left[zero] = abs(float((moved - predicted)[T >= 5.0].mean(axis=0)[1]))
    assert left[0.01] < 0.5 * left[0.0]


def test_a_model_that_does_not_know_its_error_has_no_zero_that_moved() -> None:
    recording, true = recorded()
    bare = Model(arm_of(2), {"backlash": {"half_width": np.array([0.001, 0.001])}})
    one = simulate(recording, bare).series["joint_states"].position
    shown = recording.series["joint_states"]
    series = recording.series | {"joint_states": JointSeries(T, shown.joints, true + 3.0)}
    two = simulate(Recording("run", 0, recording.duration, series), bare).series["joint_states"].position
    assert np.abs(one - two).max() < 0.01


def test_nor_has_a_joint_of_which_a_model_does_not_know_it() -> None:
    recording, true = recorded()
    known = replace(model(), error=np.array([0.004, 0.0]))
    one = simulate(recording, known).series["joint_states"].position
    shown = recording.series["joint_states"]
    series = recording.series | {"joint_states": JointSeries(T, shown.joints, true + np.array([0.0, 3.0]))}
    two = simulate(Recording("run", 0, recording.duration, series), known).series["joint_states"].position
    assert np.abs(one - two).max() < 0.01


def test_where_the_motors_stand_at_angles_that_the_fit_did_not_see_no_zero_has_moved() -> None:
    recording, true = recorded()
    shown = recording.series["joint_states"]
    series = recording.series | {"joint_states": JointSeries(T, shown.joints, true + np.array([0.0, 0.4]))}
    moved = Recording("run", 0, recording.duration, series)
    off = {}
    for highest in (0.5, -0.1):  # the first angles are 0
        known = replace(model(), lowest=np.full(2, -0.5), highest=np.full(2, highest))
        off[highest] = simulate(moved, known).series["joint_states"].position - true
    assert np.abs(off[0.5][T >= 5.0].mean(axis=0)[1] - 0.4) < 0.02
    assert np.abs(off[-0.1][T >= 5.0].mean(axis=0)[1]) < 0.1
