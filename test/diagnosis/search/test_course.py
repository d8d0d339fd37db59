"""Sizes one after the other, and the values that say so."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trunk_ros.diagnosis.search.course import Course
from trunk_ros.effects.moments import share

SIZES = st.lists(st.sampled_from([0.0, 1.0, 0.5, -2.0]), min_size=1, max_size=6)


@given(SIZES)
def test_values_say_what_a_course_is(sizes: list[float]) -> None:
    """Between its moments what acts by the values, times the first size, is the course."""
    moments = tuple(10.0 * (k + 1) for k in range(len(sizes) - 1))
    course = Course(tuple(sizes), moments).plain()
    values = course.values()
    if values is None:
        spells = sum(s != 0.0 for s in course.sizes)
        assert spells == 0 or spells > 3
        return
    stamp = np.arange(5.0, 10.0 * len(sizes) + 5.0, 10.0)
    acts = share(stamp, values, 1)[:, 0]
    assert course.first * acts == pytest.approx(course.at(stamp), abs=1e-12)
    again = Course.of(values)
    assert again.at(stamp) * course.first == pytest.approx(course.at(stamp), abs=1e-12)


def test_a_window_adds_to_what_is_there() -> None:
    twice = Course.of({"from": 10.0, "until": 20.0}).plus(1.0, 30.0, np.inf)
    assert twice.values() == {"from": 10.0, "until": 20.0, "from_2": 30.0}
    assert twice.plus(-0.9, 10.0, 20.0).rounded().values() == {"from": 30.0}
    assert Course.of({}).plus(1.5, 18.0, np.inf).values("payload_") == {
        "payload_from_2": 18.0,
        "payload_times_2": 2.5,
    }


def test_each_moment_may_be_left_out() -> None:
    changed = Course.of({"from_2": 10.0, "times_2": 3.0})
    assert set(changed.simpler()) == {Course((3.0,)), Course((1.0,)), Course((0.0, 3.0), (10.0,))}
    assert all(len(c.moments) < 3 for c in Course.of({"from": 5.0, "until": 9.0, "from_2": 12.0}).simpler())


def test_the_least_sizes_may_be_none() -> None:
    fewer = list(Course((0.0, 1.0, 0.04, 0.5), (1.0, 2.0, 3.0)).without_the_least())
    assert fewer == [Course((0.0, 1.0, 0.0, 0.5), (1.0, 2.0, 3.0)), Course((0.0, 1.0, 0.0), (1.0, 2.0))]


@pytest.mark.parametrize("seed", range(40))
def test_whatever_moments_a_fit_led_to_a_course_is_what_the_effect_does_and_can_be_said(seed: int) -> None:
    """Out of order, at the recording's beginning, or after its end."""
    rng = np.random.default_rng(seed)
    moments = ("from", "until", "from_2", "until_2", "from_3", "until_3")
    at = np.where(rng.random(6) < 0.3, 0.0, rng.uniform(0.0, 40.0, 6))
    said = {name: float(t) for name, t in zip(moments, at, strict=True) if rng.random() < 0.7}
    said |= {f"times_{k}": float(rng.uniform(-2.0, 2.0)) for k in (2, 3) if f"from_{k}" in said}
    course = Course.of(said)
    stamp = np.arange(0.05, 45.0, 0.1)
    far = np.all([np.abs(stamp - t) > 0.1 for t in said.values()] or [stamp > 0.0], axis=0)
    assert np.allclose(course.at(stamp)[far], share(stamp, said, 1)[far, 0])
    assert all(t > 0.0 for t in course.moments)
    values = course.values()
    if values is not None:
        assert all(f"from_{k}" in values for k in (2, 3) if f"times_{k}" in values)
        assert np.allclose(Course.of(values).at(stamp) * course.first, course.at(stamp))
