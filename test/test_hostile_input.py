"""Hostile files, names and numbers get one line and exit code 2 from every command."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
import yaml

from test.diagnosis.arms import of_the_wires, recorded
from trunk_ros.__main__ import main
from trunk_ros.compiled import compiled
from trunk_ros.errors import TrunkError, printable
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.plain_yaml import load
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.write import write_recording
from trunk_ros.trajectory import Trajectory, load_trajectory

ROOT = Path(__file__).parents[1]
LONG = "n" * 300
OF_TABLE = "time: {column: t, unit: s}\njoints: [a]\njoint_states: {position: {columns: [x], unit: deg}}\n"
OF_BAG = 'joints: [a]\njoint_states: {position: {columns: ["/joint_states.position[0]"], unit: rad}}\n'
ODD = os.fsdecode(b"caf\xe9 \xff")  # no UTF-8


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "bag"
    write_recording(path, recorded(seconds=5.0))
    return path


@pytest.fixture
def refused(capfd: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a command that must refuse; its line."""

    def run(*arguments: Any) -> str:
        assert main([str(each) for each in arguments]) == 2
        said = capfd.readouterr().err.strip()
        assert len(said.splitlines()) == 1, said
        return said

    return run


SCALARS = [
    "!!bool x", '!!int ""', "!!float x", "!!binary x", "!!timestamp x", "!!python/object:os.system x",
    "1:0:0", "9" * 400, "9" * 5000, "1e400", ".nan", ".inf", "-.inf", "{}", "[]", "~", "2026-11-22",
]  # fmt: skip


@pytest.mark.parametrize("value", SCALARS)
@pytest.mark.parametrize("name", ["arm.payload", "arm.joints", "wire.ratio", "servo.kp", "model.duration"])
def test_odd_values_in_a_model_are_refused_or_read(
    name: str, value: str, tmp_path: Path, bag: Path, capfd
) -> None:
    flat = "".join(f"    {key}: {json}\n" for key, json in _model_but(name))
    (tmp_path / "model.yaml").write_text(f"/**:\n  ros__parameters:\n{flat}    {name}: {value}\n")
    code = main(
        ["simulate", str(bag), "--model", str(tmp_path / "model.yaml"), "--output", str(tmp_path / "out")]
    )
    said = capfd.readouterr().err.strip()
    assert (code, len(said.splitlines())) in ((0, 0), (2, 1)), said


def _model_but(name: str) -> list[tuple[str, str]]:
    flat = load_model("trunk").parameters()
    return [(key, yaml.safe_dump(value, default_flow_style=True, width=10**6).splitlines()[0])
            for key, value in flat.items() if key != name]  # fmt: skip


@pytest.mark.parametrize("value", SCALARS)
@pytest.mark.parametrize("where", ["time", "sec", "position", "joint"])
def test_odd_values_in_a_trajectory_are_refused_or_read(where: str, value: str, tmp_path: Path) -> None:
    given = {"time": "1.0", "sec": "1", "position": "0.1", "joint": "joint_1", where: value}
    time = f"{{sec: {given['sec']}, nanosec: 0}}" if where == "sec" else given["time"]
    points = f"points:\n- {{positions: [{given['position']}], time_from_start: {time}}}\n"
    (tmp_path / "motion.yaml").write_text(f"joint_names: [{given['joint']}]\n{points}")
    read = read_or_refused(tmp_path / "motion.yaml")
    if read is not None:
        assert where != "time" or value == "{}"  # as a message that says nothing of it
        assert np.isfinite(read.time).all()
        assert np.isfinite(read.position).all()


def read_or_refused(path: Path) -> Trajectory | None:
    try:
        return load_trajectory(path)
    except TrunkError as error:
        return None if str(error).startswith(str(path)) else pytest.fail(str(error))


@pytest.mark.parametrize("value", SCALARS)
@pytest.mark.parametrize(
    "key", ["version", "message_count", "relative_file_paths", "storage_identifier", "custom_data"]
)
def test_odd_values_in_metadata_are_refused_or_read(key: str, value: str, tmp_path: Path, bag: Path) -> None:
    lines = (bag / "metadata.yaml").read_text().splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith(f"  {key}:"))
    end = next(
        (k for k in range(start + 1, len(lines)) if lines[k].startswith("  ") and lines[k][2] not in " -"),
        len(lines),
    )
    copy = tmp_path / "bag"
    copy.mkdir()
    (copy / "bag_0.mcap").symlink_to(bag / "bag_0.mcap")
    (copy / "metadata.yaml").write_text("\n".join([*lines[:start], f"  {key}: {value}", *lines[end:]]) + "\n")
    assert main(["simulate", str(copy), "--model", "trunk", "--output", str(tmp_path / "out")]) in (0, 2)


@pytest.mark.parametrize("value", SCALARS)
@pytest.mark.parametrize("where", ["time", "unit", "rate_hz", "joints", "columns", "delimiter"])
def test_odd_values_in_a_mapping_are_refused_or_read(where: str, value: str, tmp_path: Path) -> None:
    given = {"time": "{column: t, unit: s}", "joints": "[a]", "columns": "[x]", "unit": "rad", where: value}
    topic = f"joint_states: {{position: {{columns: {given['columns']}, unit: {given['unit']}}}}}"
    time = f"rate_hz: {value}" if where == "rate_hz" else f"time: {given['time']}"
    more = f"delimiter: {value}\n" if where == "delimiter" else ""
    (tmp_path / "map.yaml").write_text(f"{time}\njoints: {given['joints']}\n{topic}\n{more}")
    (tmp_path / "table.csv").write_text("t,x\n0,1\n1,2\n")
    with pytest.raises(TrunkError) as refused:
        read_csv(tmp_path / "table.csv", tmp_path / "map.yaml")
    assert str(refused.value).startswith(str(tmp_path))


@pytest.mark.parametrize("text", ["a: 1\na: 2\n", "{a: 1, b: {c: 1, c: 2}}"])
def test_a_key_that_is_given_twice_is_no_yaml(text: str) -> None:
    with pytest.raises(ValueError, match=r"line .*a key given twice"):
        load(text.encode())


def test_what_has_colons_is_text() -> None:
    assert load(b"[12:30:00, 1:2.5, 7, 1.5]") == ["12:30:00", "1:2.5", 7, 1.5]


# The machine


@pytest.mark.parametrize("name", [LONG, ODD, "a\x1b[31mb\a"])
def test_names_of_files_that_are_not_there(name: str, tmp_path: Path, bag: Path, refused) -> None:
    there = tmp_path / name
    refused("diagnose", there, "--output", tmp_path / "out")
    refused("diagnose", bag, "--output", tmp_path / "out", "--model", f"{there}.yaml")
    refused("simulate", bag, "--model", there, "--output", tmp_path / "out")
    refused("import", there, "--mapping", "nothing", "--output", tmp_path / "out")
    refused("import", bag / "metadata.yaml", "--mapping", there, "--output", tmp_path / "out")
    refused("recover", there)
    refused("replay", there)
    refused("bringup", "--trajectory", f"{there}.yaml", "--output", tmp_path / "out")


def test_outputs_with_names_that_are_too_long(tmp_path: Path, bag: Path, refused) -> None:
    refused("diagnose", bag, "--output", tmp_path / LONG)
    refused("simulate", bag, "--model", "trunk", "--output", tmp_path / LONG)
    refused("simulate", bag, "--model", "trunk", "--output", tmp_path / ("n" * 250))
    refused("bringup", "--output", tmp_path / LONG)


def test_an_output_whose_name_is_no_utf_8_is_written(tmp_path: Path, bag: Path) -> None:
    assert main(["simulate", str(bag), "--model", "trunk", "--output", str(tmp_path / ODD)]) in (0, 2)


LOCKED: dict[str, tuple[str, str]] = {
    "a folder": ("iterdir", "simulate locked/bag --model trunk --output out"),
    "a file": ("open", "simulate locked/bag --model trunk --output out"),
    "a file to diagnose": ("open", "diagnose locked/bag --output out"),
    "a file to import": ("open", "import locked/bag --mapping map.yaml --output out"),
    "a table": ("open", "import locked/table.csv --mapping table.yaml --output out"),
    "a file to replay": ("open", "replay locked/bag/bag_0.mcap"),
    "a model": ("read_bytes", "simulate bag --model locked/model.yaml --output out"),
    "a mapping": ("read_bytes", "import bag --mapping locked/map.yaml --output out"),
    "a folder to recover": ("stat", "recover locked/bag"),
    "an output": ("mkdir", "simulate bag --model trunk --output locked/deep/out"),
    "an import": ("mkdir", "import table.csv --mapping table.yaml --output locked/deep/out"),
    "a run": ("mkdir", "bringup --output locked/deep/out"),
}


@pytest.mark.parametrize("what", LOCKED)
def test_what_may_not_be_touched_is_said(what: str, tmp_path: Path, bag: Path, refused, monkeypatch) -> None:
    """Also where the tests run as root, whom no permission stops."""
    call, command = LOCKED[what]
    whole = getattr(Path, call)

    def forbidden(self: Path, *given: Any, **options: Any) -> Any:
        if "locked" in self.parts:
            raise PermissionError(13, "Permission denied", str(self))
        return whole(self, *given, **options)

    locked = tmp_path / "locked"
    (locked / "bag").mkdir(parents=True)
    for name in ("metadata.yaml", "bag_0.mcap"):
        (locked / "bag" / name).write_bytes((bag / name).read_bytes())
    (tmp_path / "bag").symlink_to(bag)
    save_model(load_model("trunk"), locked / "model.yaml")
    for folder in (tmp_path, locked):
        (folder / "map.yaml").write_text(OF_BAG)
        (folder / "table.yaml").write_text(OF_TABLE)
        (folder / "table.csv").write_text("t,x\n0,1\n1,2\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Path, call, forbidden)
    assert "Permission denied" in refused(*command.split())


@pytest.mark.parametrize(
    "command",
    [
        "diagnose bag --output locked/deep/out",
        "simulate bag --model trunk --output locked/out",
        "import bag --mapping map.yaml --output locked/out",
    ],
)
def test_an_output_that_may_not_be_written_is_said_before_the_work(
    command: str, tmp_path: Path, monkeypatch, refused
) -> None:
    """There is nothing to work on here."""
    (tmp_path / "locked").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(os, "access", lambda path, mode: "locked" not in Path(path).parts)
    assert refused(*command.split()).endswith(f"Permission denied in {tmp_path / 'locked'}")


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS])
def test_a_disk_that_takes_nothing_is_said_before_the_work(
    number: int, tmp_path: Path, monkeypatch, refused
) -> None:
    """Root may write anywhere, as far as permissions tell. There is nothing to work on here."""

    def full(self: Path, data: bytes) -> int:
        raise OSError(number, os.strerror(number), str(self))

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Path, "write_bytes", full)
    said = refused("diagnose", "bag", "--output", "new/out")
    assert said.endswith(f"new/out cannot be written: {os.strerror(number)} in {tmp_path}")
    assert list(tmp_path.iterdir()) == []


def test_loops_are_compiled_anew_where_no_cache_can_be_written(monkeypatch) -> None:
    def unwritable(function: Any = None, cache: bool = False, **options: Any) -> Any:
        if cache:
            raise RuntimeError("cannot cache function 'twice': no locator available for file 'x.py'")
        return lambda function: function

    monkeypatch.setattr(numba, "njit", unwritable)
    assert compiled(_twice)(2.0) == 4.0


def _twice(x: float) -> float:
    return 2 * x


@pytest.mark.parametrize(
    "remap", ["/joint_states:=bad name!", "/joint_states:=/a//b", "/joint_states:=1x", "x", ":=y"]
)
def test_topics_that_cannot_be_are_refused(remap: str, bag: Path, refused) -> None:
    assert "--remap" in refused("replay", bag, "--remap", remap)


# Names and times


NAMES = ("a\x1b[31m$x^", "<b>&amp;\\frac{\a" + 300 * "x")


def test_any_joint_name_is_read_diagnosed_and_shown(tmp_path: Path, capfd) -> None:
    whole = of_the_wires(recorded({"backlash": {"half_width": np.full(5, 2e-3)}}, 8.0))
    series = {
        key: replace(each.select(("joint_1", "joint_2")), joints=NAMES) for key, each in whole.series.items()
    }
    write_recording(tmp_path / "bag", Recording("odd", whole.start_ns, whole.duration, series))
    assert all(joint.isprintable() for joint in read_recording(tmp_path / "bag").joints)
    command = ["diagnose", tmp_path / "bag", "--model", "direct", "--output", tmp_path / "out"]
    assert main([str(each) for each in command]) == 0, capfd.readouterr().err
    page = (tmp_path / "out" / "report.html").read_text()
    assert not {"\x1b", "\a"} & set(page)
    assert "<b>&amp;" not in page


@pytest.mark.parametrize("name", ["名前", "a\u202eb", "\x7f", "tab\tnew\nline"])
def test_names_are_shown_with_what_cannot_be_shown_written_out(name: str) -> None:
    assert printable(name).isprintable()
    assert printable("名前") == "名前"


def test_a_time_beyond_all_clocks_gets_one_line(tmp_path: Path, refused) -> None:
    (tmp_path / "map.yaml").write_text(OF_TABLE)
    for time in ("1e301", "-1e301", "1e308", "9e9"):
        (tmp_path / "table.csv").write_text(f"t,x\n0,1\n{time},2\n")
        said = refused(
            "import", tmp_path / "table.csv", "--mapping", tmp_path / "map.yaml", "--output", tmp_path / "bag"
        )
        assert "is its unit right?" in said


def test_a_model_of_very_many_joints_is_refused(tmp_path: Path, bag: Path, refused) -> None:
    flat = {"arm.joints": [f"j{k}" for k in range(2000)], "wire.ratio": [1.0]}
    (tmp_path / "model.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": flat}}))
    said = refused("simulate", bag, "--model", tmp_path / "model.yaml", "--output", tmp_path / "out")
    assert "1000 at most" in said
    assert isinstance(load_model("direct"), Model)


HANGS = """
import time
from trunk_ros.nodes.graph import process
process.LEAVING = 0.2
process.leave_in_time()
time.sleep(60)
"""


def test_a_node_whose_middleware_does_not_let_go_of_it_ends_all_the_same() -> None:
    """As where a partner was killed that held a lock in shared memory."""
    pytest.importorskip("rclpy")
    done = subprocess.run([sys.executable, "-c", HANGS], cwd=ROOT, timeout=50)
    assert done.returncode == -signal.SIGALRM
