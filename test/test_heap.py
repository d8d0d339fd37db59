"""What a long recording needs for a moment it does not keep."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import recorded
from test.effects.example import motion, stamps
from trunk_ros.arm.body import TOGETHER
from trunk_ros.data.sensing.physics import beside_physics, motion_of
from trunk_ros.model import load_model

ROOT = Path(__file__).parents[1]


def resident() -> int:
    """Bytes of this process that are in memory."""
    return 4096 * int(Path("/proc/self/statm").read_text().split()[1])


def printed(code: str) -> list[float]:
    """What ``code`` prints in a process of its own: another heap has free places of its own, of any size."""
    names = (
        "import numpy as np; from test.test_heap import resident\n"
        "from trunk_ros.heap import RETURNED, keep_what_is_freed\n"
    )
    command = [sys.executable, "-c", names + code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    return [float(one) for one in done.stdout.split()]


@pytest.mark.skipif(sys.platform != "linux", reason="what glibc does")
def test_large_arrays_go_back_to_the_system_whatever_lies_behind_them() -> None:
    held, left = printed(
        "keep_what_is_freed(); before = resident()\n"
        "large, behind = np.ones(3 * RETURNED // 16), np.ones(RETURNED // 64)\n"
        "held = resident() - before; del large\n"
        "print(held / RETURNED, (resident() - before) / RETURNED)"
    )
    assert held > 1.0
    assert left < held / 2


@pytest.mark.skipif(sys.platform != "linux", reason="what glibc does")
def test_smaller_arrays_are_kept_for_the_next_ones() -> None:
    (returned,) = printed(
        "keep_what_is_freed(); one = np.ones(RETURNED // 16); there = resident(); del one\n"
        "print((there - resident()) / RETURNED)"
    )
    assert returned < 0.1


@pytest.mark.skipif(sys.platform != "linux", reason="what Linux does")
def test_what_libraries_were_linked_with_goes_back_and_they_still_work() -> None:
    loaded, left, same = printed(
        "import scipy.signal; from trunk_ros.heap import give_back\n"
        "from trunk_ros.compiled import copied; a, b = np.arange(3.0), np.zeros(3); copied(a, b)\n"
        "give_back(); loaded = resident(); give_back(libraries=True); left = resident()\n"
        "c = np.zeros(3); copied(a, c); d = scipy.signal.butter(2, 0.1, output='sos')\n"
        "print(loaded / 2**20, left / 2**20, int((a == b).all() and (a == c).all() and np.isfinite(d).all()))"
    )
    assert left < loaded - 40.0
    assert same


def test_weight_by_pieces_is_that_of_each_posture() -> None:
    arm = load_model("trunk").arm
    angles = motion(stamps((TOGETHER + 3) / 100.0, 100.0))
    rows = [0, TOGETHER - 1, TOGETHER, len(angles) - 1]
    whole = arm.load(angles)
    assert whole[rows] == pytest.approx(np.concatenate([arm.load(angles[[k]]) for k in rows]), abs=1e-15)


def test_speed_and_what_physics_may_do_lie_in_one_table() -> None:
    run, arm = recorded(seconds=10.0), load_model("trunk").arm
    seen = motion_of(run.series["gearbox_states"], run.series["joint_states"], arm)
    table = beside_physics(seen, 2, seen.speed[:, 2])
    assert np.array_equal(table[:, 0], seen.speed[:, 2])
    assert np.array_equal(table[:, 1:], beside_physics(seen, 2))


def test_all_joints_and_all_samples_of_a_topic_are_no_copy() -> None:
    series = recorded(seconds=5.0).series["gearbox_states"]
    assert series.select(series.joints) is series
    assert series.between(0.0, np.inf) is series
    assert series.select(series.joints[::-1]).joints == series.joints[::-1]
