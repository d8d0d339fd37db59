"""replay --through: a node's answers to what was recorded, beside what it said then."""

import pytest

from test.nodes.graph import needs_ros, trunk

pytestmark = needs_ros


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A recorded run of an arm that is not the nominal one."""
    folder = tmp_path_factory.mktemp("through")
    (folder / "plant.yaml").write_text(plant())
    done = trunk(
        "bringup",
        "--output",
        folder / "bag",
        "--seconds",
        4,
        "--sim-time",
        "--plant-model",
        folder / "plant.yaml",
    )
    assert done.returncode == 0, done.stderr
    return folder / "bag"


def plant() -> str:
    import yaml

    from trunk_ros.model import load_model

    return yaml.safe_dump(
        {
            "/**": {
                "ros__parameters": load_model("trunk").parameters()
                | {"effects.backlash.half_width": [0.002] * 5}
            }
        }
    )


def test_the_node_says_again_what_was_recorded(command, run):
    done = command("replay", run, "--through", "wire_elasticity", "--tolerance", "1e-12")
    assert done.returncode == 0, done.stderr
    assert "with the parameters that it had" in done.stdout
    rows = [line.split() for line in done.stdout.splitlines()]
    assert {row[0] for row in rows[2:-1]} == {"joint_states", "trunk/wire_states", "trunk/tip_pose"}
    assert all(row[2] == row[4] != "0" for row in rows[2:-1])  # all of the samples compared
    assert rows[-1][:3] == ["the", "same,", "within"]


def test_another_model_says_something_else(command, run):
    done = command("replay", run, "--through", "wire_elasticity", "--model", "trunk")
    assert done.returncode == 0
    assert "differs by more than 1e-09: joint_states position" in done.stdout
    strict = command("replay", run, "--through", "wire_elasticity", "--model", "trunk", "--tolerance", "1e-4")
    assert strict.returncode == 1


def test_a_bag_without_what_the_node_needs_is_refused(command, tmp_path):
    from test.recording.bags import motion, write_bag

    bag = write_bag(tmp_path / "bag", motion())
    done = command("replay", bag, "--through", "wire_elasticity")
    assert done.returncode == 2
    assert "no topic trunk/gearbox_states" in done.stderr
    assert len(done.stderr.splitlines()) == 1
