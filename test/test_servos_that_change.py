"""Servos that change in mid-run, many of them at once."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from test.effects.example import arm_of, stamps
from trunk_ros import servo_run
from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.effects.servo.loop import fresh
from trunk_ros.servo_run import run_servo, servo_core

COLUMNS = 9


def surroundings(stamp: Array, columns: int) -> Now:
    """Of joints that begin at rest at 0."""
    none = np.zeros((len(stamp), columns))
    dt = np.diff(stamp, prepend=stamp[:1])
    names = tuple(map(str, range(columns)))
    return Now(stamp, dt, none, none, none, none, none, names, np.ones(columns))


def one_of(core: Core, column: int) -> Core:
    """The loop of a column."""
    some = {
        f.name: value[..., column : column + 1]
        for f in fields(core)
        if isinstance(value := getattr(core, f.name), np.ndarray) and value.shape[-1:] == (COLUMNS,)
    }
    return replace(core, **some)


@pytest.mark.parametrize("often", [False, True])
def test_servos_that_change_come_out_as_each_by_itself(often: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Side by side from one change to the next, or by itself where it changes all the time."""
    rng, stamp = np.random.default_rng(5), stamps(20, 100.0)
    rows, since = len(stamp), np.arange(len(stamp))[:, None]
    setpoint = np.cumsum(rng.normal(scale=0.02, size=(rows, COLUMNS)), axis=0)
    moments = rng.integers(300, 1700, size=(3, COLUMNS)) if often else np.full((3, COLUMNS), 700)
    now, pieces = surroundings(stamp, COLUMNS), []
    core = servo_core(arm_of(COLUMNS), (), now)
    core.kp = np.where(since > moments[0], 9.0, 20.0)
    core.delay = np.where(since > moments[1], 0.013, 0.02 * (np.arange(COLUMNS) % 2))
    core.rub = np.where(since > moments[2], 0.004, 0.002)
    core.load = rng.normal(scale=1e-3, size=(rows, COLUMNS))
    core.pull = rng.normal(scale=1e-3, size=(rows, 1)) + np.zeros((1, COLUMNS))
    stepped = servo_run.servo_loops
    monkeypatch.setattr(servo_run, "servo_loops", lambda *a: (pieces.append(len(a[-1])), stepped(*a)))
    together, state = run_servo(core, now, setpoint, stamp, fresh(np.zeros(COLUMNS)))
    assert pieces == ([] if often else [701, 1300])
    for j in range(COLUMNS):
        asked, alone = np.ascontiguousarray(setpoint[:, j : j + 1]), surroundings(stamp, 1)
        got, after = run_servo(one_of(core, j), alone, asked, stamp, fresh(np.zeros(1)))
        assert np.array_equal(got[:, 0], together[:, j])
        assert np.array_equal(after[:, 0], state[:, j], equal_nan=True)


@pytest.mark.parametrize(("columns", "loop"), [(2, "servo_loop"), (COLUMNS, "servo_loops")])
def test_numbers_of_any_layout_in_memory_are_stepped_by_one_compiled_loop(
    columns: int, loop: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each layout compiles for seconds."""
    stamp = stamps(20, 100.0)
    now, seen = surroundings(stamp, columns), []
    numbers = np.outer(np.linspace(0.8, 1.2, columns), [20.0, 0.02, 1.5, 0.01, 0.0]).T
    core = servo_core(arm_of(columns), (), now, numbers)
    core.cogging = np.full((columns, len(stamp)), 1e-3).T
    core.hardest = np.full((columns, len(stamp)), 9.0).T
    core.quickest = np.where(np.arange(len(stamp)) < 700, 0.5, 0.4)[:, None] + np.zeros((1, columns))
    stepped = getattr(servo_run, loop)
    monkeypatch.setattr(servo_run, loop, lambda *a: (seen.append(a), stepped(*a)))
    run_servo(core, now, np.zeros((len(stamp), columns)), stamp, fresh(np.zeros(columns)))
    assert seen
    assert all(a.flags.c_contiguous for one in seen for a in one if isinstance(a, np.ndarray))
