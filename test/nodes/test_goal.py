"""Goals are judged as joint_trajectory_controller judges them."""

from types import SimpleNamespace

import numpy as np
import pytest

from trunk_ros.nodes.control.goal import Code, Goal, GoalError, State, Tolerance, overlaid

JOINTS = ("a", "b")
NONE = Tolerance.same(2, 0.0)


def state(*position, velocity=(0.0, 0.0)):
    return State(np.array(position), np.array(velocity))


def tolerance(name, position=0.0, velocity=0.0):
    return SimpleNamespace(name=name, position=position, velocity=velocity)


WANTED = state(0.5, 0.0)


def test_without_tolerances_a_goal_is_reached_when_its_time_is_over():
    goal = Goal(JOINTS, 1.0, NONE, NONE)
    assert goal.judge(0.99, WANTED, state(9.0, 9.0)) is None
    assert goal.judge(1.0, WANTED, state(9.0, 9.0)).code == Code.SUCCESSFUL


def test_leaving_the_path_breaks_it_off_and_names_joint_and_error():
    goal = Goal(JOINTS, 1.0, Tolerance.same(2, 0.02), NONE)
    assert goal.judge(0.5, WANTED, state(0.51, 0.0)) is None
    outcome = goal.judge(0.5, WANTED, state(0.51, -0.03))
    assert outcome.code == Code.PATH_TOLERANCE_VIOLATED
    assert "b is off by 0.03 rad, more than 0.02 rad" in outcome.text


def test_the_goal_is_waited_for_as_long_as_the_leeway_lasts():
    goal = Goal(JOINTS, 1.0, NONE, Tolerance.same(2, 0.01, 0.05), leeway=0.5)
    assert goal.judge(1.2, WANTED, state(0.48, 0.0)) is None
    assert goal.judge(1.2, WANTED, state(0.495, 0.0, velocity=(0.0, 0.1))) is None
    assert goal.judge(1.2, WANTED, state(0.495, 0.0)).code == Code.SUCCESSFUL
    missed = goal.judge(1.6, WANTED, state(0.48, 0.0))
    assert missed.code == Code.GOAL_TOLERANCE_VIOLATED
    assert "a is off by 0.02 rad" in missed.text


def test_without_leeway_the_goal_is_waited_for_as_long_as_it_takes():
    goal = Goal(JOINTS, 1.0, NONE, Tolerance.same(2, 0.01))
    assert goal.judge(1e6, WANTED, state(0.4, 0.0)) is None


def test_a_joint_that_is_not_known_is_outside_of_any_tolerance_but_not_of_none():
    unknown = state(np.nan, 0.0)
    assert Goal(JOINTS, 1.0, Tolerance.same(2, 1.0), NONE).judge(0.5, WANTED, unknown) is not None
    assert Goal(JOINTS, 1.0, NONE, NONE).judge(0.5, WANTED, unknown) is None


def test_a_goals_tolerances_replace_the_nodes_or_take_them_away():
    given = [tolerance("b", position=0.1, velocity=-1.0), tolerance("a")]
    made = overlaid(given, JOINTS, Tolerance.same(2, 0.02, 0.3))
    np.testing.assert_array_equal(made.position, [0.02, 0.1])
    np.testing.assert_array_equal(made.velocity, [0.3, 0.0])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (tolerance("elbow", 0.1), "for 'elbow': the arm has a, b"),
        (tolerance("a", -2.0), "neither positive nor 0 nor -1"),
        (tolerance("a", float("nan")), "neither positive"),
    ],
)
def test_tolerances_that_make_no_sense_are_refused(given, words):
    with pytest.raises(GoalError, match=words):
        overlaid([given], JOINTS, NONE)
