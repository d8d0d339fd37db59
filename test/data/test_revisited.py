"""Noise of what stops at random places: told by places near each other, not by the next stop."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import diagnose
from trunk_ros.compiled import Array
from trunk_ros.data.noise import noise_of
from trunk_ros.data.revisited import between_visits, neighbours
from trunk_ros.recording.recording import Recording

NOISE = 5e-4  # rad


def random_places(many: int = 1500) -> tuple[Array, Array]:
    """Angles (many, 2) of two joints that go from one random place to another, and what the first is off by:
    a smooth map of both.
    """
    generator = np.random.default_rng(3)
    places = generator.uniform(-0.8, 0.8, (many, 2))
    off = 0.02 * places[:, 0] * places[:, 1] + 0.01 * places[:, 1] ** 2
    return places, off + NOISE * generator.standard_normal(many)


def test_the_nearest_place_is_not_one_of_the_stops_just_before_or_after():
    places, _ = random_places(400)
    near = neighbours(places)
    apart = np.linalg.norm((places[:, None] - places) / places.std(axis=0), axis=2)
    rows = np.arange(len(places))
    apart[np.abs(rows[:, None] - rows) < 4] = np.inf
    np.testing.assert_array_equal(near, apart.argmin(axis=1))


@pytest.mark.parametrize("places", [np.zeros((200, 2)), np.zeros((1, 2))])
def test_what_never_moves_has_no_other_places(places):
    np.testing.assert_array_equal(neighbours(places), np.arange(len(places)))


def test_noise_at_random_places_is_that_between_near_ones():
    places, rest = random_places()
    every = np.ones(len(rest), dtype=bool)
    assert noise_of([rest], [every], 1).std > 5.0 * NOISE
    assert between_visits([rest], [every], [neighbours(places)]) == pytest.approx(NOISE, rel=0.3)


def test_without_anything_to_compare_nothing_is_told():
    _, rest = random_places(50)
    assert np.isinf(between_visits([rest], [np.zeros(50, dtype=bool)], [np.arange(50)]))
    assert np.isinf(between_visits([rest], [np.ones(50, dtype=bool)], [np.arange(50)]))


def test_a_smooth_map_of_random_places_is_no_noise():
    places, rest = random_places()
    joint = places + np.column_stack([rest, NOISE * np.random.default_rng(4).standard_normal(len(rest))])
    result = diagnose(Recording.from_arrays(np.arange(len(rest)), motor=places, joint=joint), model="direct")
    told = result.stages["wire"]["joints"]["joint_1"]
    assert told["noise_floor"] < 3.0 * NOISE
    assert told["rmse_after"] < 0.5 * told["rmse_before"]
    assert "joint_1" in {joint for finding in result.findings for joint in finding.joints}
