"""evaluate: models and simulators on recordings."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import NOISE, on, recorded, reshaped
from trunk_ros.__main__ import main
from trunk_ros.compiled import Array
from trunk_ros.data.put_right import as_diagnosed
from trunk_ros.evaluate import of_model, of_simulator, score
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.write import write_recording
from trunk_ros.simulate import simulate
from trunk_ros.transmission import OF_MOTORS

TRUTH = {"backlash": {"half_width": on(2, 3e-3)}, "zero_offset": {"offset": on(4, 1e-3)}}
COLUMNS = ["recording", "model", "stage", "joint", "unit", "rms_before", "rms_after", "worst_before",
           "worst_after", "noise"]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An arm's bag, its model, and the bags of two simulators: one that is nominal, one that is right."""
    out = tmp_path_factory.mktemp("evaluate")
    arm, truth = recorded(TRUTH, 20.0), Model(load_model("trunk").arm, TRUTH)
    write_recording(out / "run", arm)
    save_model(truth, out / "model.yaml")
    for name, model in (("nominal", load_model("trunk")), ("right", truth)):
        said = simulate(arm, model)
        write_recording(out / name, replace(said, start_ns=said.start_ns + 10**12))
    return out


def rows_of(capsys: pytest.CaptureFixture[str], *words: str | Path) -> list[dict[str, object]]:
    """What ``evaluate --json`` prints."""
    assert main(["evaluate", *map(str, words), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["schema"] == "trunk_ros/evaluate/1"
    return list(told["rows"])


def test_a_model_is_scored_against_its_arm_without_effects(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = rows_of(capsys, folder / "run", "--model", folder / "model.yaml")
    assert list(rows[0]) == COLUMNS
    assert {(r["recording"], r["model"]) for r in rows} == {("run", str(folder / "model.yaml"))}
    wire = {r["joint"]: r for r in rows if r["stage"] == "wire"}
    assert wire["joint_2"]["rms_before"] == pytest.approx(3e-3, rel=0.1)
    assert wire["joint_2"]["rms_after"] == pytest.approx(NOISE, rel=0.05)
    assert wire["joint_2"]["noise"] == pytest.approx(NOISE, rel=0.1)
    assert wire["joint_2"]["worst_before"] > wire["joint_2"]["rms_before"]  # type: ignore[operator]
    assert wire["joint_1"]["rms_before"] == pytest.approx(wire["joint_1"]["rms_after"], rel=0.02)
    assert {r["stage"] for r in rows} == {"servo", "wire"}


def test_a_servo_that_no_one_described_is_said_to_be_that_of_trunk(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["evaluate", str(folder / "run"), "-m", "direct", str(folder / "model.yaml")]) == 0
    said = capsys.readouterr().err
    assert said.count("has no servo section") == 1
    assert "trunk_ros: direct has no servo section" in said
    assert main(["evaluate", str(folder / "run"), "-m", "direct", "--stage", "wire"]) == 0
    assert "servo section" not in capsys.readouterr().err


def test_readings_of_a_sensor_that_sticks_do_not_count(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As ``diagnose`` leaves them out."""
    position = recorded(TRUTH, 40.0).series["joint_states"].position.copy()
    position[2500:2700, 3] = position[2500, 3]
    write_recording(tmp_path / "run", reshaped(recorded(TRUTH, 40.0), "joint_states", position=position))
    assert main(["evaluate", str(tmp_path / "run"), "--model", str(folder / "model.yaml"), "--json"]) == 0
    out, said = capsys.readouterr()
    assert "run: joint_4: its sensor sticks, first at 25.01 s; 199 readings left out" in said
    after = {row["joint"]: row["rms_after"] for row in json.loads(out)["rows"] if row["stage"] == "wire"}
    assert after["joint_4"] == pytest.approx(NOISE, rel=0.05)


def spoiled_rows(
    folder: Path, spoiled: Recording, capsys: pytest.CaptureFixture[str], *words: str | Path
) -> tuple[dict[str, float], str]:
    """The errors after of the wires of a recording in ``folder``, and what was said."""
    write_recording(folder / "run", spoiled)
    assert main(["evaluate", str(folder / "run"), *map(str, words), "--json"]) == 0
    out, said = capsys.readouterr()
    return {r["joint"]: r["rms_after"] for r in json.loads(out)["rows"] if r["stage"] == "wire"}, said


def with_stamps(recording: Recording, stamp: Array) -> Recording:
    """The recording with other stamps of its joint readings."""
    shown = replace(recording.series["joint_states"], stamp=stamp)
    return replace(recording, series={**recording.series, "joint_states": shown})


def test_an_encoder_that_wraps_is_counted_on_and_said(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where a simulator, that it is compared with, does not wrap, or does."""
    arm = recorded(TRUTH, 40.0)
    wraps = []
    for source in (arm, simulate(arm, Model(load_model("trunk").arm, TRUTH))):
        position = source.series["joint_states"].position.copy()
        position[position[:, 1] > 0.1, 1] -= 2 * np.pi
        wraps.append(reshaped(source, "joint_states", position=position))
    write_recording(tmp_path / "sim_wraps", wraps[1])
    after, said = spoiled_rows(
        tmp_path, wraps[0], capsys, "-m", folder / "model.yaml", "--against", tmp_path / "sim_wraps"
    )
    assert after["joint_2"] == pytest.approx(NOISE, rel=0.05)
    assert said.count("run: joint_states of joint_2 jumps by a whole turn") == 1
    assert main(["evaluate", str(tmp_path / "run"), "--against", str(folder / "right"), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert max(r["rms_after"] for r in rows if r["stage"] == "wire") < 1.1 * NOISE


def test_a_clock_that_is_slow_is_put_right_and_said_and_a_delay_is_not(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As in ``diagnose``: a constant lag that the model does not have may be physics."""
    arm = recorded(TRUTH, 40.0)
    stamp = arm.series["joint_states"].stamp
    after, said = spoiled_rows(
        tmp_path, with_stamps(arm, 1.0005 * stamp), capsys, "-m", folder / "model.yaml"
    )
    assert "run: the clock of joint_states runs 500" in said
    assert all(rms == pytest.approx(NOISE, rel=0.1) for rms in after.values())
    (tmp_path / "late").mkdir()
    late, said = spoiled_rows(
        tmp_path / "late", with_stamps(arm, stamp + 0.01), capsys, "-m", folder / "model.yaml"
    )
    assert min(late.values()) > 3 * NOISE
    assert said == ""


def test_what_is_mixed_up_stays_an_error(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    position = recorded(TRUTH, 40.0).series["joint_states"].position.copy()
    position[:, 2] *= -1.0
    spoiled = reshaped(recorded(TRUTH, 40.0), "joint_states", position=position)
    after, said = spoiled_rows(tmp_path, spoiled, capsys, "-m", folder / "model.yaml")
    assert after["joint_3"] > 0.1
    assert "run: joint_3: mixed up, and taken as recorded" in said


def test_motors_keep_their_names() -> None:
    arm = replace(load_model("trunk").arm, motors=tuple("abcde"))
    made = recorded(TRUTH, 40.0)
    series = {
        key: replace(each, joints=arm.motors) if key in OF_MOTORS else each
        for key, each in made.series.items()
    }
    right = as_diagnosed(replace(made, series=series), Model(arm, TRUTH))
    assert right.series["gearbox_states"].joints == arm.motors
    rows = score("run", [of_model(right, "model", Model(arm, TRUTH))])
    assert {row.joint for row in rows if row.stage == "servo"} == set(arm.motors)


def test_simulators_are_scored_against_the_first_of_them(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = rows_of(capsys, folder / "run", "--against", folder / "nominal", folder / "right")
    by = {(Path(str(r["model"])).name, r["joint"]): r for r in rows}
    assert by["right", "joint_4"]["rms_before"] == pytest.approx(1e-3, rel=0.05)
    assert by["right", "joint_4"]["rms_after"] == pytest.approx(NOISE, rel=0.05)
    assert by["nominal", "joint_4"]["rms_after"] == by["right", "joint_4"]["rms_before"]


def test_too_large_an_error_ends_with_3(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run, model = str(folder / "run"), str(folder / "model.yaml")
    assert main(["evaluate", run, "--model", model, "--fail-above", "1.2"]) == 0
    capsys.readouterr()
    assert main(["evaluate", run, "--model", "trunk", "--fail-above", "1.2"]) == 3
    said = capsys.readouterr().err
    assert "2 of 10 signals err by more than 1.2 times the noise, most of all wire joint_2 of run" in said


def test_the_simulator_that_others_are_compared_with_fails_nobody(folder: Path) -> None:
    words = ["evaluate", str(folder / "run"), "--fail-above", "1.2", "--against"]
    assert main([*words, str(folder / "nominal")]) == 3
    assert main([*words, str(folder / "nominal"), str(folder / "right")]) == 0
    assert main([*words, str(folder / "right"), str(folder / "nominal")]) == 3


def test_rows_as_csv(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "rows.csv"
    words = [
        "evaluate",
        str(folder / "run"),
        "--model",
        "trunk",
        str(folder / "model.yaml"),
        "--csv",
        str(table),
    ]
    assert main(words) == 0
    with table.open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == COLUMNS
    assert len(rows) == 20
    assert "median" in capsys.readouterr().out
    assert main(words) == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["run"], "nothing to score"),
        (["run", "run", "--against", "right"], "2 recordings and 1 of --against"),
        (["run", "--model", "nope"], "no model 'nope'"),
        (["run", "--model", "trunk", "--fail-above", "nan"], "is not a number"),
    ],
)
def test_what_cannot_be_scored_is_refused_in_one_line(
    folder: Path,
    words: list[str],
    said: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(folder)
    assert main(["evaluate", *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_what_a_simulator_did_not_record_does_not_count() -> None:
    """A simulation that ends early is judged on what it has; one of other joints is refused."""
    arm = recorded(TRUTH, 40.0)
    said = simulate(arm, Model(load_model("trunk").arm, TRUTH))
    half = Recording(said.name, said.start_ns, said.duration, said.part(0.0, 20.0).series)
    rows = score("run", [of_simulator(arm, "half", half, half)])
    assert all(row.rms_after == pytest.approx(NOISE, rel=0.1) for row in rows)
    series = {"joint_states": replace(said.series["joint_states"], joints=tuple("abcde"))}
    other = replace(said, series=series)
    with pytest.raises(Exception, match="joints are matched by name"):
        of_simulator(arm, "other", other, other)


def test_the_tip_is_scored_where_it_was_recorded() -> None:
    from trunk_ros.recording.recording import PoseSeries

    arm, model = recorded({}), load_model("trunk")
    joints = arm.series["joint_states"]
    tip = model.arm.tip(joints.position)
    tip[:, 1] += 2e-3
    seen = replace(arm, tip=PoseSeries(joints.stamp, tip[:, :3], tip[:, 3:]))
    rows = {row.joint: row for row in score("run", [of_model(seen, "trunk", model)]) if row.stage == "arm"}
    assert rows["y"].rms_after == pytest.approx(2e-3, rel=1e-3)
    assert (rows["y"].unit, rows["roll"].unit) == ("m", "rad")
    assert rows["z"].rms_after < 1e-6
