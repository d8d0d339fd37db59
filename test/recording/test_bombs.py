"""Small files that unpack to large ones are refused soon and in little memory, which an option lifts."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from test.recording.bags import motion, write_bag
from test.recording.bombs import BOMBS, INDEX_BOMBS, cost_of, yaml_bombs
from trunk_ros.console.arguments import Parser
from trunk_ros.errors import RecordingError, TrunkError
from trunk_ros.nodes.bags.source import BagSource
from trunk_ros.recording import allowance, plain_yaml
from trunk_ros.recording.importing.bag import read_bag
from trunk_ros.recording.importing.mapping import parse_mapping
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recover import recover
from trunk_ros.trajectory import load_trajectory

MEGABYTES, SECONDS = 1000, 30
COLUMN = {"columns": ["/joint_states.position[0]"], "unit": "rad"}
MAPPING = parse_mapping({"joints": ["a"], "joint_states": {"position": COLUMN}})


def replayed(path: Path) -> int:
    with BagSource(path) as bag:
        return sum(len(data) for _, _, data in bag.messages({topic.name for topic in bag.topics}))


def imported(path: Path) -> object:
    return read_bag(path, MAPPING)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Each bomb, made once."""
    return cache(lambda name: BOMBS[name](tmp_path_factory.mktemp(name)))


@pytest.mark.parametrize("action", [read_recording, replayed, imported, recover])
@pytest.mark.parametrize("bomb", BOMBS)
def test_a_small_file_that_unpacks_without_end_is_refused(bomb, action, made):
    path = made(bomb)
    cost = cost_of(action, path)
    assert cost.megabytes < MEGABYTES, cost
    assert cost.seconds < SECONDS, cost
    assert "\n" not in cost.said
    assert cost.said == "read" or cost.said.startswith(str(path)), cost
    if action is read_recording:
        assert allowance.OPTION in cost.said or bomb == "long_name", cost


@pytest.mark.parametrize("action", [replayed, imported])
@pytest.mark.parametrize("bomb", INDEX_BOMBS)
def test_what_a_file_hides_from_one_who_reads_it_from_its_front_is_found(bomb, action, tmp_path):
    path = INDEX_BOMBS[bomb](tmp_path)
    cost = cost_of(action, path)
    assert cost.megabytes < 200, cost
    assert cost.said.startswith(str(path)), cost
    assert allowance.OPTION in cost.said or "an index that leads to no chunk" in cost.said


@pytest.mark.parametrize("text", yaml_bombs())
def test_yaml_without_end_is_refused(text, tmp_path):
    path = tmp_path / "file.yaml"
    path.write_bytes(yaml_bombs()[text])
    cost = cost_of(load_trajectory, path)
    assert cost.megabytes < MEGABYTES, cost
    assert cost.seconds < SECONDS, cost
    assert cost.said.startswith(str(path)), cost


def test_the_option_lifts_the_bounds(tmp_path, monkeypatch):
    bag = write_bag(tmp_path / "bag", motion(count=2000))
    monkeypatch.setattr(allowance, "FLOOR", 1000)
    monkeypatch.setattr(allowance, "GROWTH", 0)
    monkeypatch.delenv(allowance.VARIABLE, raising=False)
    with pytest.raises(RecordingError, match=allowance.OPTION):
        read_recording(bag)
    monkeypatch.setenv(allowance.VARIABLE, "0")
    Parser("any", "Any command.").parse_args([allowance.OPTION])
    assert len(read_recording(bag).series["joint_states"].stamp) == 2000


def test_yaml_with_many_values_is_read_where_that_is_asked_for(tmp_path, monkeypatch):
    path = tmp_path / "large.yaml"
    path.write_text("[" + "1," * 1100 + "1]")
    monkeypatch.setattr(plain_yaml, "_MOST", 1000)
    monkeypatch.setenv(allowance.VARIABLE, "")
    with pytest.raises(TrunkError, match=f"more than 1000 values: give {allowance.OPTION}"):
        load_trajectory(path)
    monkeypatch.setenv(allowance.VARIABLE, "1")
    with pytest.raises(TrunkError, match="needs joint_names"):
        load_trajectory(path)
