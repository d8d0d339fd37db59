"""The smooth course of a signal."""

import warnings

import numpy as np
import pytest

from trunk_ros.cubic import cubic
from trunk_ros.effects.periods import periods


def test_a_cubic_is_the_course_of_any_cubic() -> None:
    x = np.random.default_rng(0).uniform(-300.0, -100.0, 400)
    y = 3.0 + 2.0 * x - 0.1 * x**2 + 1e-3 * x**3
    assert cubic(x, y, np.array([-200.0, -310.0])) == pytest.approx([-12397.0, -40018.0], rel=1e-6)


def test_a_joint_that_goes_between_a_few_stops_has_a_course_and_warns_of_nothing() -> None:
    stops = np.repeat([0.0, 1.0, 0.5], 50)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert cubic(stops, 2.0 * stops, stops) == pytest.approx(2.0 * stops)
        assert cubic(stops[:50], np.arange(50.0), np.zeros(1)) == pytest.approx([24.5])
        periods(stops, np.sin(stops), 0.5, 40.0)
