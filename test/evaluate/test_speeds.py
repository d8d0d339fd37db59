"""It is said where motors go faster than the servo of a model may, as its top speed was then a guess."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from test.diagnosis.arms import SHORT, recorded
from trunk_ros.commands.evaluate import main as evaluate
from trunk_ros.commands.simulate import main as simulate
from trunk_ros.evaluate.speeds import too_slow
from trunk_ros.model import Model, save_model
from trunk_ros.recording.write import write_recording

SLOW = Model(replace(SHORT.arm, v_max=np.array([1.5, 0.2, 1.5]), servo_stated=True))
STATED = Model(replace(SHORT.arm, servo_stated=True))


def test_joints_that_go_faster_are_said_with_both_speeds() -> None:
    (said,) = too_slow(recorded(nominal=SHORT), SLOW)
    assert "joint_2" in said
    assert "v_max 0.2" in said
    assert "joint_1" not in said


def test_a_top_speed_that_is_reached_and_one_that_is_not_are_no_guess() -> None:
    assert not too_slow(recorded(nominal=SLOW), SLOW)
    assert not too_slow(recorded(nominal=SHORT), STATED)


def test_one_that_is_faster_one_way_is_no_guess_either() -> None:
    effects = {"velocity_saturation": {"v_max": 0.3}, "uneven_speed": {"excess": np.full(3, 0.5)}}
    uneven = replace(STATED, effects=effects)
    run = recorded(effects, nominal=STATED)
    assert too_slow(run, replace(uneven, effects={"velocity_saturation": {"v_max": 0.3}}))
    assert not too_slow(run, uneven)


def test_of_a_model_without_a_servo_it_is_not_said() -> None:
    model = replace(SLOW, arm=replace(SLOW.arm, servo_stated=False))
    assert not too_slow(recorded(nominal=SHORT), model)


def test_evaluate_and_simulate_say_it(tmp_path, capsys) -> None:
    write_recording(tmp_path / "bag", recorded(nominal=SHORT))
    save_model(SLOW, tmp_path / "model.yaml")
    evaluate([str(tmp_path / "bag"), "-m", str(tmp_path / "model.yaml")])
    assert capsys.readouterr().err.count("motors go faster than the servo of the model may: joint_2") == 1
    given = [str(tmp_path / "bag"), "-m", str(tmp_path / "model.yaml"), "-o", str(tmp_path / "out")]
    simulate([*given, "--from", "setpoints"])
    printed = capsys.readouterr()
    assert (printed.out + printed.err).count("motors go faster than the servo") == 1
