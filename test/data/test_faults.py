"""Readings that a sensor never made are left out and said."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import NOISE, TRUNK, diagnose, of_the_wires, on, recorded, reshaped
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.data.sensor_faults import all_that_sticks, dead, sticks, strays, without_faults
from trunk_ros.diagnosis import Diagnosis


def faulty(position: Array) -> Diagnosis:
    """Of an arm with a dead band that is too narrow in the model, by other joint readings."""
    return diagnose([reshaped(of_the_wires(recorded(LOOSE, 40.0)), "joint_states", position=position)])


LOOSE = {"backlash": {"half_width": on(2, 8e-4)}}


@pytest.fixture
def position() -> Array:
    return recorded(LOOSE, 40.0).series["joint_states"].position.copy()


def test_a_sensor_that_sticks_is_said_and_hides_no_physics(position: Array) -> None:
    position[1200:1290, 1] = position[1200, 1]
    position[2500:2700, 3] = position[2500, 3]
    result = faulty(position)
    assert [(f.effect, f.joints) for f in result.findings] == [("backlash", ["joint_2"])]
    assert result.unexplained == []
    notes = " ".join(result.quality["made"]["notes"])
    assert "joint_2: its sensor sticks, first at 12.01 s; 89 readings left out" in notes
    assert "joint_4: its sensor sticks, first at 25.01 s; 199 readings left out" in notes


@pytest.mark.parametrize("noise", [NOISE, 0.0])
def test_a_sensor_that_sticks_while_the_joint_moves_little_is_seen_beside_the_motor(noise: float) -> None:
    """Its noise would not let it repeat itself; where there is none, a joint may have stuck and slipped."""
    good = recorded(seconds=30.0, noise=noise)
    position = good.series["joint_states"].position.copy()
    way = np.abs(position[530:2930, 2] - position[500:2900, 2])
    rows = 500 + int(np.argmax((way > 15 * NOISE) & (way < 30 * NOISE))) + np.arange(1, 30)
    position[rows, 2] = position[rows[0] - 1, 2]
    stuck = reshaped(good, "joint_states", position=position.copy())
    assert not sticks(position[:, 2], good.series["joint_states"].stamp).any()
    left_out = np.isnan(without_faults(stuck).series["joint_states"].position)
    assert left_out.sum() == left_out[rows, 2].sum() == (len(rows) if noise else 0)


@pytest.mark.parametrize("rate", [8.0, 12.0])
def test_a_joint_that_sticks_and_slips_is_no_sensor_that_sticks(rate: float) -> None:
    """In a perfect simulation of few samples, whose motion looks like noise from one to the next."""
    good = recorded(seconds=60.0, noise=0.0, rate=rate)
    position = good.series["joint_states"].position.copy()
    far = 1.3 * np.quantile(np.abs(np.diff(position[:, 3])), 0.99)
    way = np.abs(position[208:, 3] - position[200:-8, 3])
    first = 200 + int(np.argmin(np.abs(way - far)))
    position[first : first + 8, 3] = position[first, 3]
    seen = without_faults(reshaped(good, "joint_states", position=position))
    assert not any("sticks" in note for note in seen.notes)


@pytest.mark.parametrize("seed", [0, 28])
def test_a_simulated_joint_that_rests_in_its_dead_band_is_no_sensor_that_sticks(seed: int) -> None:
    """Driven with an encoder's counts: those had passed for noise that lets no reading repeat itself."""
    made = recorded(seconds=20.0, noise=0.0, seed=seed)
    motor = made.series["gearbox_states"]
    angles, _ = Chain(TRUNK, "wire").run(motor.position, motor.stamp)
    simulated = reshaped(made, "joint_states", position=angles)
    assert without_faults(simulated) is simulated


def test_an_old_message_is_old_for_joints_that_hardly_moved_meanwhile(position: Array) -> None:
    position[:, 3] = position[0, 3] + NOISE * np.random.default_rng(5).normal(size=len(position))
    position[1200:1290] = position[1200]
    old = all_that_sticks(position, np.arange(len(position)) / 100)
    assert not sticks(position[:, 3], np.arange(len(position)) / 100).any()
    assert np.flatnonzero(old[:, 3]).tolist() == list(range(1201, 1290))
    position[2000:2050, 3] = position[2000, 3]  # one sensor alone, and nothing leaps
    assert (all_that_sticks(position, np.arange(len(position)) / 100) == old).all()


def test_joints_that_stand_meanwhile_do_not_stick(position: Array) -> None:
    """In a perfect simulation in which one joint moves after the other, or one is not read at all."""
    for joint in range(1, 5):
        position[: 800 * joint, joint] = position[800 * joint, joint]
    position[1200:1290, 1] = position[1200, 1]
    position[400:450, 0] = position[400, 0]
    stamp = np.arange(len(position)) / 100
    position[:, 4] = np.nan
    assert np.flatnonzero(all_that_sticks(position, stamp)[:, 1:].any(axis=0)).tolist() == [0]
    assert all_that_sticks(position, stamp)[401:450, 0].all()


def test_single_readings_far_off_are_said_and_hide_no_physics(position: Array) -> None:
    flipped = np.random.default_rng(1).choice(np.arange(10, 3990, 7), 12, replace=False)
    position[flipped, 2] += 0.1
    result = faulty(position)
    assert [(f.effect, f.joints) for f in result.findings] == [("backlash", ["joint_2"])]
    assert result.unexplained == []
    assert "joint_3: 12 single readings far from" in " ".join(result.quality["made"]["notes"])


@pytest.mark.parametrize("step", [0.0, 1e-4, 4e-3])
def test_a_joint_that_stands_or_is_read_coarsely_has_no_faults(position: Array, step: float) -> None:
    """Nor one that stands in a perfect simulation, moves on, and jumps as its wire slips."""
    position[1000:2000] = position[1000]
    position[2000:] += position[1000] - position[2000]
    position[3000:] += 2e-3
    seen = step * np.round(position / step) if step else position
    for column in seen.T:
        assert not sticks(column, np.arange(len(column)) / 100).any()
        assert not strays(column).any()


def test_a_good_recording_stays_the_same_object() -> None:
    good = recorded(seconds=40.0)
    assert without_faults(good) is good


def test_one_reading_in_fifty_far_off_is_left_out_also_in_fast_motion_and_two_at_a_time() -> None:
    """As many large steps are usual then: what the motor explains is taken off first."""
    good = recorded(seconds=40.0, size=3.0)
    position, chance = good.series["joint_states"].position.copy(), np.random.default_rng(3)
    rows = 10 + 50 * np.arange(len(position) // 50 - 1)
    rows = np.concatenate([rows, rows[::9] + 1])
    position[rows, 1] += chance.uniform(8e-3, 2e-2, len(rows))
    put_right = without_faults(reshaped(good, "joint_states", position=position))
    left_out = np.isnan(put_right.series["joint_states"].position)
    assert left_out[rows, 1].mean() > 0.98
    assert left_out.sum() == left_out[rows, 1].sum()
    assert any("joint_2" in note and "far from those beside" in note for note in put_right.notes)


def test_a_burst_of_noise_is_no_row_of_single_readings_and_no_physics() -> None:
    good = recorded(seconds=30.0)
    position = good.series["joint_states"].position.copy()
    position[1000:1500] += 1.4e-3 * np.random.default_rng(5).normal(size=(500, 5))
    spoiled = reshaped(good, "joint_states", position=position)
    assert not any("single readings" in note for note in without_faults(spoiled).notes)
    assert diagnose([spoiled]).verdict == "no_mismatch"


def test_readings_that_are_off_by_less_than_physics_are_found_beside_the_motor() -> None:
    """A sag of 10 mrad, readings off by 4 mrad, and a motor that goes there and back; the joint does once."""
    rng, t = np.random.default_rng(1), np.arange(8000) / 100
    moved = 0.5 * np.sin(0.7 * t) + 0.2 * np.sin(1.9 * t)
    moved[3000:3500] = moved[3000]
    readings = moved + 5e-3 * np.cos(0.5 * t) + 1e-4 * rng.standard_normal(len(t))
    moved[3200:3202] += 4e-3
    moved[3300] += 4e-3
    readings[3302] += 4e-3  # which the joint follows late
    off = np.sort(rng.choice(np.arange(10, 2900, 10), 150, replace=False))
    readings[off] += 4e-3 * rng.choice([-1.0, 1.0], len(off))
    assert np.flatnonzero(strays(readings, moved)).tolist() == off.tolist()


@pytest.mark.parametrize("shown", ["where it was", "something else"])
def test_a_sensor_that_dies_while_its_noise_goes_on_is_said_and_hides_no_physics(
    position: Array, shown: str
) -> None:
    chance = np.random.default_rng(11)
    angle = position[1200, 1] if shown == "where it was" else 0.4
    position[1200:1900, 1] = angle + NOISE * chance.normal(size=700)
    result = faulty(position)
    assert [(f.effect, f.joints) for f in result.findings] == [("backlash", ["joint_2"])]
    assert "joint_2: its sensor sticks, first at 1" in " ".join(result.quality["made"]["notes"])


def test_a_gap_in_the_motors_readings_hides_no_dead_sensor() -> None:
    stamp, chance = np.arange(6000) / 100, np.random.default_rng(5)
    moved = 0.4 * np.sin(0.5 * stamp)
    readings = moved + NOISE * chance.normal(size=len(stamp))
    readings[1200:1900] = 0.4 + NOISE * chance.normal(size=700)
    moved[4000:4400] = np.nan
    assert np.flatnonzero(dead(readings, readings - moved, NOISE)).tolist() == list(range(1200, 1900))


def test_a_stop_that_is_met_once_by_a_joint_that_mostly_rests_is_no_dead_sensor() -> None:
    """It leaves the stop as fast as the motor goes, which is far beyond its usual steps."""
    stamp = np.arange(12000) / 100
    at = [0.0, 2.0, 3.0, 9.0, 10.0, 30.0, 31.0, 32.5, 33.5, 60.0, 61.0, 80.0, 81.0, 120.0]
    to = [0.0, 0.0, 0.2, 0.2, -0.1, -0.1, 0.6, 0.6, 0.1, 0.1, -0.2, -0.2, 0.25, 0.25]
    moved = np.interp(stamp, at, to)
    readings = np.minimum(moved, 0.3) + NOISE * np.random.default_rng(5).normal(size=len(stamp))
    assert not dead(readings, readings - moved, NOISE).any()


def test_what_stops_a_joint_on_its_way_is_no_dead_sensor() -> None:
    """A stop that holds it while the motor goes on and comes back, and what breaks loose."""
    good = recorded(seconds=40.0)
    series = good.series["joint_states"]
    stopped = series.position.copy()
    for j, readings in enumerate(series.position.T):
        chance, stop = np.random.default_rng(j), np.quantile(readings, 0.7)
        held = readings > stop
        stopped[held, j] = stop + NOISE * chance.normal(size=held.sum())
    seen = without_faults(reshaped(good, "joint_states", position=stopped))
    assert not any("sticks" in note for note in seen.notes)
    loose = series.position.copy()
    turn = int(np.argmax(loose[500:1500, 2])) + 500
    fall = turn + int(np.argmin(loose[turn : turn + 600, 2]))
    half = (turn + fall) // 2
    loose[turn:half, 2] = loose[turn, 2] + NOISE * np.random.default_rng(7).normal(size=half - turn)
    seen = without_faults(reshaped(good, "joint_states", position=loose))
    assert not any("sticks" in note for note in seen.notes)


def test_a_brake_that_opens_late_is_no_dead_sensor() -> None:
    """It slips before it opens, so that the joint moves, and the joint rings as it catches up."""
    stamp, chance = np.arange(9000) / 100, np.random.default_rng(3)
    at = np.arange(0.0, 91.0, 6.0)
    to = np.where(np.arange(len(at)) % 4 < 2, 0.4, -0.4)
    way = np.clip((stamp - at[(stamp // 6).astype(int)]) / 2.5, 0.0, 1.0)
    before, after = to[(stamp // 6).astype(int)], to[(stamp // 6).astype(int) + 1]
    moved = before + (after - before) * way**2 * (3.0 - 2.0 * way)
    off = moved - before
    held = (np.abs(off) > 0.0) & (way < 0.14)
    readings = np.where(held, moved - np.clip(off, -14e-3, 14e-3), moved)
    opens = np.flatnonzero(held[:-1] & ~held[1:])
    for first in opens:
        readings[first + 1 : first + 7] += np.sign(off[first]) * np.array([4, 4, -4, -1, 0.5, 0.2]) * 1e-3
    readings += NOISE * chance.normal(size=len(stamp)) - 5e-4 * np.sign(after - before)
    assert len(opens) > 3
    assert not dead(readings, readings - moved, NOISE).any()


@pytest.mark.parametrize("seed", range(4))
def test_bursts_of_noise_on_a_joint_that_rests_are_no_dead_sensor(seed: int) -> None:
    stamp, chance = np.arange(6000) / 20, np.random.default_rng(seed)
    speed = 0.2 * np.cos(0.5 * stamp) * (np.sin(0.05 * stamp) > 0.3)
    moved = np.cumsum(speed) / 20
    readings = moved + NOISE * chance.normal(size=len(stamp)) - 6e-4 * np.sign(np.cos(0.5 * stamp))
    for first in chance.integers(0, 5980, 15):
        size = chance.integers(3, 10)
        readings[first : first + size] += 2e-2 * chance.normal(size=size)
    assert not dead(readings, readings - moved, NOISE).any()
