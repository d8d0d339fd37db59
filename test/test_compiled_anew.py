"""What is compiled is kept for the next process, and compiled anew where what it calls is another one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import trunk_ros

CALLED = """from trunk_ros.compiled import compiled
TIMES = {times}
@compiled
def called(x):
    return {sign}TIMES * x
"""
CALLS = """from called import called
from trunk_ros.compiled import compiled
@compiled
def calls(x):
    return 1.0 + called(x)
"""
SHOWN = "from calls import calls; print(calls(2.0), sum(calls.machine.stats.cache_hits.values()))"


def shown(folder: Path, times: float, sign: str = "") -> list[str]:
    """What a process gets, and how much it had not to compile. Only the file of what is called is written."""
    (folder / "called.py").write_text(CALLED.format(times=times, sign=sign))
    path = os.pathsep.join(map(str, (folder, Path(trunk_ros.__file__).parents[1])))
    env = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    run = [sys.executable, "-c", SHOWN]
    return subprocess.run(
        run, env=env | {"PYTHONPATH": path}, capture_output=True, text=True, check=True
    ).stdout.split()


@pytest.mark.parametrize(("times", "sign", "right"), [(5.0, "", "11.0"), (3.0, "-", "-5.0")])
def test_a_change_in_another_file_is_seen(times: float, sign: str, right: str, tmp_path: Path) -> None:
    (tmp_path / "calls.py").write_text(CALLS)
    assert shown(tmp_path, 3.0) == ["7.0", "0"]
    assert shown(tmp_path, 3.0) == ["7.0", "1"]
    assert shown(tmp_path, times, sign) == [right, "0"]
