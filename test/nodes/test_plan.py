"""What cannot be begun is refused before anything starts."""

import pytest

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.run.plan import plan_of


def refused(*arguments):
    with pytest.raises(TrunkError) as error:
        plan_of([str(argument) for argument in arguments])
    text = str(error.value)
    assert "\n" not in text
    return text


def test_an_output_that_exists_is_refused_unless_overwriting_a_bag(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    assert "exists" in refused("--output", bag)
    (bag / "metadata.yaml").touch()
    assert plan_of(["--output", str(bag), "--overwrite"]).overwrite
    (bag / "thesis.tex").touch()
    assert "thesis.tex" in refused("--output", bag, "--overwrite")


def test_an_output_below_a_file_is_refused(tmp_path):
    (tmp_path / "file").touch()
    assert "file" in refused("--output", tmp_path / "file" / "bag")


def test_without_an_output_only_when_nothing_is_recorded():
    assert "--output" in refused("--seconds", 5)
    assert plan_of(["--without", "recorder"]).output is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--without", "servo"], "choose from servo_driver"),
        (["--seconds", "0"], "above 0"),
        (["--seconds", "x"], "invalid float"),
        (["--rate", "0"], "1 to 2000"),
        (["--model", "nowhere.yaml"], "nowhere.yaml"),
        (["--model", "direct"], "trajectory FILE"),
        (["--trajectory", "waltz"], "unknown trajectory 'waltz'"),
        (["--trajectory", "none.yaml"], "none.yaml"),
        (["--nonsense"], "--nonsense"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(tmp_path, arguments, words):
    assert words in refused("--output", tmp_path / "bag", *arguments)
    assert not list(tmp_path.iterdir())


def test_a_trajectory_that_breaks_a_limit_is_refused_with_the_reason(tmp_path):
    file = tmp_path / "far.yaml"
    file.write_text("{joint_names: [joint_2], points: [{positions: [0.6], time_from_start: 3.0}]}")
    assert "joint_2 would reach" in refused("--output", tmp_path / "bag", "--trajectory", file)
    file.write_text("{joint_names: [elbow], points: [{positions: [0.1], time_from_start: 3.0}]}")
    said = refused("--output", tmp_path / "bag", "--trajectory", file)
    assert "unknown joint 'elbow'" in said
    assert "--model MODEL.yaml says which arm" in said
    assert "--model MODEL.yaml" not in refused("--without", "recorder", "-m", "trunk", "--trajectory", file)


def test_the_compensator_believes_the_model_and_the_plant_is_nominal(tmp_path):
    found = tmp_path / "found.yaml"
    found.write_text(
        (plan_config("trunk")).replace("servo:", "effects: {backlash: {half_width: [0.001]}}\n    servo:")
    )
    plan = plan_of(["--output", str(tmp_path / "bag"), "--model", str(found)])
    assert "backlash" in plan.models["compensator"].effects
    assert not plan.models["servo_driver"].effects
    assert not plan.models["wire_elasticity"].effects


def test_direct_takes_the_joints_of_the_trajectory(tmp_path):
    file = tmp_path / "two.yaml"
    file.write_text("{joint_names: [q1, q2], points: [{positions: [0.6, 0.1], time_from_start: 3.0}]}")
    plan = plan_of(["--without", "recorder", "--model", "direct", "--trajectory", str(file)])
    assert plan.arm.joints == ("q1", "q2")


def plan_config(name):
    from trunk_ros.share import config_path

    return config_path(name).read_text()
