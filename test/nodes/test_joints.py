"""Joints are matched by name."""

import numpy as np
import pytest

from trunk_ros.nodes.graph.joints import JointMatcher, MessageError


def test_order_does_not_matter():
    matcher = JointMatcher(["a", "b", "c"])
    np.testing.assert_array_equal(matcher.gather(["c", "a", "b"], [3.0, 1.0, 2.0]), [1.0, 2.0, 3.0])
    assert not matcher.oddities()


def test_missing_and_unknown_joints_are_named():
    matcher = JointMatcher(["a", "b"])
    np.testing.assert_array_equal(matcher.gather(["b", "x"], [2.0, 9.0]), [np.nan, 2.0])
    assert matcher.oddities() == ["unknown joint x ignored", "joint a missing"]


@pytest.mark.parametrize(
    ("names", "values", "words"),
    [
        (["a", "a"], [1.0, 2.0], "named twice"),
        (["x"], [1.0], "no joint of x"),
        (["a", "b"], [1.0], "2 names but 1"),
    ],
)
def test_messages_that_make_no_sense_are_refused(names, values, words):
    with pytest.raises(MessageError, match=words):
        JointMatcher(["a", "b"]).gather(names, values)


def test_an_empty_field_is_no_values():
    assert np.isnan(JointMatcher(["a", "b"]).gather(["a", "b"], [])).all()
