"""Loops of servos that take several steps at once, against the reference, which takes each by itself."""

from __future__ import annotations

import numpy as np
import pytest

from test.effects.example import arm_of, stamps
from test.test_servos_that_change import surroundings
from trunk_ros import servo_run
from trunk_ros.compiled import Array
from trunk_ros.effects.servo.leaps import leaping_loops
from trunk_ros.effects.servo.loop import fresh, servo_loop, unlimited
from trunk_ros.servo_run import run_servo, servo_core

ROWS, COLUMNS = 600, 5


def stepped(
    setpoint: Array, stamp: Array, numbers: Array, pull: Array, load: Array, ahead: float, state: Array
) -> Array:
    """Gearbox angles (n, columns) of the reference; ``numbers`` (6, columns)."""
    kp, tau_v, up, down, delay, torque = numbers[:, None]
    none, out = np.zeros((1, len(kp[0]))), np.empty_like(setpoint)
    servo_loop(
        setpoint, stamp, kp, tau_v, up, down, delay, pull, load, torque, none, none[0], none,
        np.stack([none] * 3), unlimited(len(kp[0])), none, none[:0], ahead, 0, state, out,
    )  # fmt: skip
    return out


@pytest.mark.parametrize("top", [0.3, 5.0, np.inf])
@pytest.mark.parametrize("ahead", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("apart", [(0.01,), (0.005,), (0.0, 0.0013, 0.004, 0.01, 0.011, 0.4), (0.001, 0.03)])
def test_they_go_as_the_reference(top: float, ahead: float, apart: tuple[float, ...]) -> None:
    """Whatever the stamps are, whenever setpoints come, with the top speed often, at times or never there."""
    rng = np.random.default_rng(8)
    stamp = 50.0 + np.cumsum(rng.choice(apart, size=ROWS))
    setpoint = np.cumsum(rng.normal(scale=0.01, size=(ROWS, COLUMNS)), axis=0)
    setpoint[200:300] = setpoint[200]
    pull, load = rng.normal(scale=2e-3, size=(2, ROWS, COLUMNS))
    each = np.linspace(0.6, 1.4, COLUMNS)
    delay = np.array([0.0, 0.013, 0.2, -0.004, 0.0052])
    numbers = np.array([20.0 * each, 0.02 * each, top * each, 0.7 * top * each, delay, 0.4 * each])
    numbers[:2, 1] = 400.0, 1e-4  # a stiff one, in shorter steps
    numbers[0, 3] = -20.0 if np.isfinite(top) else 20.0  # one that runs away, as fast as it may
    start = fresh(rng.normal(scale=0.1, size=COLUMNS), 0.2)
    state, after, out = start.copy(), start.copy(), np.empty_like(setpoint)
    right = stepped(setpoint, stamp, numbers, pull, load, ahead, state)
    leaping_loops(setpoint, stamp, *numbers[:5], pull, load, numbers[5], ahead, 0, after, out)
    assert out == pytest.approx(right, abs=1e-9)
    assert after == pytest.approx(state, abs=1e-7, nan_ok=True)


def test_a_run_in_pieces_goes_as_the_whole() -> None:
    rng, stamp = np.random.default_rng(9), stamps(6, 100.0)
    now = surroundings(stamp, COLUMNS)
    core = servo_core(arm_of(COLUMNS), (), now)
    core.pull = rng.normal(scale=1e-3, size=(len(stamp), COLUMNS))
    setpoint = np.cumsum(rng.normal(scale=0.01, size=(len(stamp), COLUMNS)), axis=0)
    whole, state = run_servo(core, now, setpoint, stamp, fresh(np.zeros(COLUMNS)))
    after, pieces = fresh(np.zeros(COLUMNS)), []
    for first, last in ((0, 1), (1, 200), (200, len(stamp))):
        here, out = servo_run._between(core, first, last), np.empty((last - first, COLUMNS))
        servo_run._step(here, setpoint[:last], setpoint[:0], stamp[:last], first, after, out)
        pieces.append(out)
    assert np.array_equal(np.concatenate(pieces), whole)
    assert np.array_equal(after, state, equal_nan=True)


@pytest.mark.parametrize(
    ("name", "value", "leaps"),
    [
        ("kp", 12.0, True),
        ("load", 0.01, True),
        ("torque", 0.3, True),
        ("delay", 0.03, True),
        ("uneven", 0.1, True),
    ]
    + [(name, 1e-3, False) for name in ("rub", "dead_zone", "cogging", "dry", "ki", "speed_ki")]
    + [(name, 0.5, False) for name in ("quickest", "ramp", "hardest")],
)
@pytest.mark.parametrize("columns", [2, 9])
def test_what_is_more_than_linear_is_stepped(
    name: str, value: float, leaps: bool, columns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where it is there in one joint, and from some moment on."""
    stamp = stamps(8, 100.0)
    now, seen = surroundings(stamp, columns), []
    core = servo_core(arm_of(columns), (), now)
    number = np.repeat(getattr(core, name), len(stamp), axis=0)
    number[400:, 1] = value
    setattr(core, name, number)
    leaping = servo_run.leaping_loops
    monkeypatch.setattr(servo_run, "leaping_loops", lambda *a: (seen.append(len(a[-1])), leaping(*a)))
    setpoint = 0.1 * np.sin(stamp)[:, None] + np.zeros((1, columns))
    run_servo(core, now, setpoint, stamp, fresh(np.zeros(columns)))
    assert sum(seen) == (len(stamp) if leaps else 0)
