"""What all commands share: quick help, known options, one-line complaints that point the way."""

from __future__ import annotations

import argparse
import errno
import importlib
import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from test.diagnosis.arms import recorded, reshaped
from trunk_ros.__main__ import COMMANDS, MEANT, main, without_a_package
from trunk_ros.arm.files import urdf_text
from trunk_ros.commands.completion import PARSERS, parser_of, whole_parser
from trunk_ros.console.progress import Progress, every
from trunk_ros.errors import ArgumentError, ModelError, RecordingError
from trunk_ros.recording.importing.mapping import load_mapping
from trunk_ros.recording.namespace import choose
from trunk_ros.recording.output import prepare_output
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.write import write_recording
from trunk_ros.share import share_folder

OWN = [name for name, (module, _) in COMMANDS.items() if ".nodes." not in module]
HEAVY = ("numba", "scipy", "matplotlib", "rosbags", "mcap", "rich", "pandas", "rclpy")


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "run1"
    write_recording(path, recorded(seconds=12.0))
    return path


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 0
    return capsys.readouterr().out


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 2
    line = capsys.readouterr().err.strip()
    assert len(line.splitlines()) == 1
    return line


@pytest.mark.parametrize("name", COMMANDS)
def test_help_imports_nothing_that_takes_long(name: str) -> None:
    look = (
        "import sys\nfrom trunk_ros.__main__ import main\n"
        f"try:\n    main(['{name}', '--help'])\nexcept SystemExit:\n    pass\n"
        f"print([name for name in {HEAVY} if name in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True)
    assert done.stderr.strip() == "[]"
    assert f"usage: {name} " in done.stdout.replace("usage: trunk_ros ", "usage: ")


def test_completion_of_a_node_does_not_import_ros() -> None:
    look = (
        "import sys\nfrom trunk_ros.__main__ import COMMANDS\n"
        "from trunk_ros.commands.completion import whole_parser\n"
        "for name in COMMANDS:\n    whole_parser(COMMANDS, [name])\n"
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stderr


@pytest.mark.parametrize("name", [*OWN, *PARSERS])
def test_every_option_of_every_command_is_described(name: str) -> None:
    make = parser_of(name, COMMANDS[name][0])
    assert make is not None
    assert [action.dest for action in make()._actions if not action.help] == []


def test_an_unknown_command_or_option_is_answered_by_the_nearest_one(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert "did you mean diagnose?" in refused(capsys, "diagnos", "run1")
    assert "did you mean evaluate?" in refused(capsys, "compare", "run1", "run2")
    assert set(MEANT.values()) <= set(COMMANDS)
    assert "did you mean --output?" in refused(capsys, "diagnose", "run1", "--outptu", "x")
    assert "did you mean backlash?" in refused(capsys, "effects", "backlsh")


def test_a_table_given_to_diagnose_is_pointed_to_import(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "run.csv").write_text("t,a\n0,1\n")
    line = refused(capsys, "diagnose", str(tmp_path / "run.csv"), "-o", str(tmp_path / "out"))
    assert f"trunk_ros import {tmp_path / 'run.csv'} --mapping" in line
    assert refused(capsys, "diagnose", str(tmp_path / "run.csv")) == line


def test_short_options_are_the_long_ones(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "predictions of" in said(capsys, "simulate", str(bag), "-m", "trunk", "-o", str(tmp_path / "a"))
    assert said(capsys, "simulate", str(bag), "-q", "-m", "trunk", "-o", str(tmp_path / "b")) == ""


def test_a_missing_package_is_answered_by_how_to_set_up(capsys: pytest.CaptureFixture[str]) -> None:
    code = (
        "import sys; sys.modules['numpy'] = None; from trunk_ros.__main__ import main; "
        "sys.exit(main(['check', 'trunk']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 2
    assert "has no numpy: run `" in done.stderr
    assert "fault of ours" not in done.stderr
    assert ".venv/bin/activate" in without_a_package("numba")


def test_completion_knows_the_options_of_the_command_at_hand() -> None:
    parser = whole_parser(COMMANDS, ["diagnose"])
    commands = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction)).choices
    assert set(commands) == set(COMMANDS)
    assert {"--output", "-o", "--against"} <= set(commands["diagnose"]._option_string_actions)
    assert "--output" not in commands["simulate"]._option_string_actions


def test_progress_tells_the_stage_the_time_and_what_is_left() -> None:
    now, lines = [0.0], []
    progress = Progress({"reading": 0.0, "wire": 0.2, "arm": 0.8}, lines.append, lambda: now[0])
    for at, text in ((0.0, "reading"), (4.0, "wire: so far backlash"), (16.0, "arm"), (18.0, "arm: tip")):
        now[0] = at
        progress.step(text)
    assert lines == [
        "reading (0 s)",
        "wire: so far backlash (4 s)",  # too early to tell
        "arm (16 s, about 4 s to go)",
        "arm: tip (18 s, about 2 s to go)",
    ]


def test_a_step_that_takes_long_is_spoken_of_meanwhile(capsys: pytest.CaptureFixture[str]) -> None:
    progress = Progress({"wire": 0.0}, lambda _: None)
    with every(0.02, progress.line):
        progress.step("wire: evidence")
        time.sleep(0.2)
    assert capsys.readouterr().err.count("wire: evidence (0 s)\n") >= 3
    time.sleep(0.05)
    assert capsys.readouterr().err == "", "nothing once it is over"


def test_info_says_what_is_there_and_what_can_be_diagnosed(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = said(capsys, "info", str(bag))
    assert "trunk/gearbox_states  100 Hz" in text
    assert "wire  yes: joint_1, joint_2" in text
    assert "arm   no: no trunk/tip_pose" in text
    told = json.loads(said(capsys, "info", str(bag), "--json"))
    assert told["stages"]["wire"]["possible"]
    assert "backlash" in told["stages"]["wire"]["effects"]
    assert told["stages"]["arm"]["missing"] == "no trunk/tip_pose in the recording"
    assert 3e-5 < told["stages"]["wire"]["joints"]["joint_2"] < 3e-4


def test_info_gives_the_reason_why_an_effect_is_not_looked_for(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = json.loads(said(capsys, "info", str(bag), "-m", "direct", "--json"))["stages"]["wire"]
    reasons = {name: reason for reason, names in told["unseen"].items() for name in names}
    assert "load is unknown" in reasons["load_elasticity"]
    assert "no nominal backlash" in reasons["tension_error"]


def test_info_says_what_is_mixed_up(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = recorded(seconds=12.0)
    degrees = good.series["joint_states"].position * 57.29578
    write_recording(tmp_path / "bag", reshaped(good, "joint_states", position=degrees))
    assert "mixed up: joint_states looks like degrees" in said(capsys, "info", str(tmp_path / "bag"))


def test_info_shows_the_columns_of_a_table_and_a_mapping_to_begin_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "late.csv").write_text("t_ms,motor\n0,1\n")
    assert "time: {column: t_ms, unit: ms}" in said(capsys, "info", str(tmp_path / "late.csv"))
    (tmp_path / "run.csv").write_text("t_s;motor;enc\n0;1;2\n1;2;3\n")
    text = said(capsys, "info", str(tmp_path / "run.csv"))
    assert "a table of 2 rows" in text
    start = text.index("  time:")
    (tmp_path / "map.yaml").write_text(text[start : text.index("then:")])
    assert load_mapping(tmp_path / "map.yaml").delimiter == ";"


def test_the_mapping_that_info_proposes_for_decimal_commas_is_one_that_import_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, mapping = tmp_path / "de.csv", tmp_path / "map.yaml"
    table.write_text("t_ms;m;e\n" + "".join(f"{10 * k};{k},5;-0,{k}e0\n" for k in range(1, 9)))
    text = said(capsys, "info", str(table))
    proposed = text[text.index("  time:") : text.index("then:")]
    proposed = proposed.replace("MOTOR_SIDE_ANGLE", "m").replace("JOINT_ANGLE", "e")
    mapping.write_text(proposed.replace('  decimal: ","\n', ""))
    plain = ["import", str(table), "--mapping", str(mapping), "-o", str(tmp_path / "bag")]
    assert 'the mapping wants `decimal: ","`' in refused(capsys, *plain)
    mapping.write_text(proposed)
    assert main(plain) == 0
    series = read_recording(tmp_path / "bag").series
    assert series["gearbox_states"].position[:2, 0] == pytest.approx([1.5, 2.5])
    assert series["joint_states"].position[:2, 0] == pytest.approx([-0.1, -0.2])


def test_a_command_that_is_interrupted_says_what_it_left(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(importlib.import_module("trunk_ros.diagnosis.diagnose"), "diagnose", interrupted)
    assert main(["diagnose", str(bag), "-o", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err == "trunk_ros: interrupted, nothing was written\n"
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_used_is_named_with_its_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "my.urdf"
    file.write_text("<robot")
    with pytest.raises(ModelError, match=r"my\.urdf: not a URDF: unclosed token"):
        urdf_text(str(file))
    with pytest.raises(ArgumentError, match=r"my\.urdf is a file, not a folder$"):
        prepare_output(file / "x", overwrite=False)
    with pytest.raises(RecordingError, match=r"^empty: holds no topics: nothing was recorded"):
        choose("empty", {})
    monkeypatch.setattr(Path, "read_bytes", denied)
    assert main(["check", str(file)]) == 2
    assert capsys.readouterr().err == f"trunk_ros: cannot read {file}: Permission denied\n"


def denied(path: Path) -> bytes:
    """A file of somebody else."""
    raise PermissionError(errno.EACCES, "Permission denied", str(path))


@pytest.mark.parametrize(
    ("name", "kind"), [("trunk", "model"), ("direct", "model"), ("dvrk-wrist", "mapping")]
)
def test_check_tells_what_a_file_is(name: str, kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert said(capsys, "check", name).startswith(f"{name}: a {kind}, and right")


def test_check_refuses_what_is_wrong_naming_the_parameter(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (share_folder() / "config" / "trunk.yaml").read_text()
    (tmp_path / "arm.yaml").write_text(text.replace("kp:", "kpp:"))
    assert "servo.kpp" in refused(capsys, "check", str(tmp_path / "arm.yaml"))
    (tmp_path / "other.yaml").write_text("a: 1\n")
    assert "neither a model" in refused(capsys, "check", str(tmp_path / "other.yaml"))
    assert "lists its columns" in refused(capsys, "check", str(tmp_path / "run1.csv"))


def test_effects_lists_the_library_and_tells_all_of_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert "backlash" in said(capsys, "effects")
    told = json.loads(said(capsys, "effects", "backlash", "--json"))
    assert told["parameters"][0]["name"] == "half_width"
    assert "per joint  added half-width" in said(capsys, "effects", "backlash")
