"""A model of another arm is refused."""

from dataclasses import replace

import numpy as np
import pytest

from test.nodes.graph import needs_ros
from trunk_ros.arm.urdf import urdf
from trunk_ros.errors import ModelError
from trunk_ros.model import load_model

pytestmark = needs_ros
ARM = load_model("trunk").arm


def check(text, arm=ARM):
    from trunk_ros.nodes.graph.model_swap import check_description

    check_description(text, arm)


def test_the_arms_own_description_is_accepted_and_one_with_more_joints_or_room_too():
    check(urdf(ARM))
    check(urdf(replace(ARM, upper=ARM.upper * 2)))
    check(urdf(ARM).replace("</robot>", '<joint name="gripper" type="prismatic"/></robot>'))


def test_a_model_without_limits_says_nothing_of_them():
    check(urdf(ARM), replace(ARM, lower=np.full(5, -np.inf), upper=np.full(5, np.inf)))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            urdf(ARM).replace("joint_3", "elbow"),
            "robot_description has no joint_3, but joint_1, joint_2, elbow",
        ),
        (urdf(replace(ARM, upper=ARM.upper - 0.1)), "joint_1 goes from -0.4014 to 0.4014 rad"),
        ("no xml", "is not URDF"),
        ("", "is not URDF"),
    ],
)
def test_another_arms_description_is_refused_with_the_difference(text, words):
    with pytest.raises(ModelError, match=words):
        check(text)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"joints": tuple("abcde")}, "the model has joints a, b, c, d, e, the arm joint_1"),
        ({"lower": ARM.lower / 2}, "lower is not that of the running arm"),
    ],
)
def test_another_arms_model_is_refused_at_a_swap(change, words):
    from trunk_ros.nodes.graph.model_swap import check_same_arm

    with pytest.raises(ModelError, match=words):
        check_same_arm(replace(ARM, **change), ARM)
