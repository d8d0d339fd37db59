"""Mappings say precisely what is wrong with them, and those of config/import fit the data they are for."""

from pathlib import Path

import pytest
import yaml

from trunk_ros.errors import RecordingError
from trunk_ros.recording.importing.mapping import load_mapping, parse_mapping
from trunk_ros.share import config_names

GOOD = """
time: {column: t, unit: ms}
joints: [a, b]
gearbox_states: {position: {columns: [x, y], unit: [deg, mm]}}
joint_states: {position: {columns: [x, {expr: x + y}], unit: [rad, m]}, effort: {columns: [e, e], unit: N}}
"""


def changed(**entries: object) -> dict[str, object]:
    return {**yaml.safe_load(GOOD), **entries}


def test_a_mapping_names_its_columns_and_the_si_units_of_its_joints():
    mapping = parse_mapping(yaml.safe_load(GOOD))
    assert set(mapping.columns) == {"t", "x", "y", "e"}
    assert mapping.units() == {"a": "rad", "b": "m"}
    assert mapping.time[1] == 1e-3


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ({"joint_state": {}}, "no entry 'joint_state': there are"),
        ({"joints": ["a", "a"]}, "joints: must be a list of different names"),
        ({"joints": "a"}, "joints: must be"),
        (
            {"joints": ["a"]},
            "gearbox_states.position: columns must be a list with one for each of the 1 joints",
        ),
        ({"time": {"rate_hz": 50}}, "time: rate_hz is an entry of its own, beside joints"),
        ({"rate_hz": 40}, "give either `time"),
        ({"time": {"column": "t", "unit": "h"}}, "unit 'h' is none of s, ms, us, ns"),
        ({"time": {}}, "a column is a name or"),
        ({"setpoints": {"velocity": {"columns": ["x", "y"], "unit": "rad/s"}}}, "setpoints: has no position"),
        ({"setpoints": {"position": {"columns": ["x", "y"], "unit": "N"}}}, "unit must be one of rad, deg"),
        ({"setpoints": {"position": {"columns": ["x", "y"]}}}, "unit must be one of"),
        ({"setpoints": {"position": {"columns": ["x", {"expr": "os.x"}], "unit": "rad"}}}, "'os.x' may hold"),
        ({"setpoints": {"position": {"columns": ["x", 3], "unit": "rad"}}}, "a column is a name or"),
        ({"delimiter": "ab"}, "delimiter: must be one character"),
    ],
)
def test_what_is_wrong_is_named_with_what_could_be(tmp_path, entries, said):
    file = tmp_path / "map.yaml"
    file.write_text(yaml.safe_dump(changed(**entries)))
    with pytest.raises(RecordingError) as caught:
        load_mapping(file)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("rate", [0, -1, "fast", True, float("nan"), None])
def test_a_rate_is_a_number_above_0(rate):
    content = changed(rate_hz=rate)
    del content["time"]
    with pytest.raises(ValueError, match="rate_hz: must be"):
        parse_mapping(content)


@pytest.mark.parametrize("text", ["", "[]", "3", "a: [", "\x00"])
def test_what_is_no_mapping_is_refused_in_one_line(tmp_path, text):
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(RecordingError) as caught:
        load_mapping(tmp_path / "map.yaml")
    assert "\n" not in str(caught.value)


def test_a_name_that_is_unknown_lists_those_that_are():
    with pytest.raises(RecordingError, match=r"dvrk: no such mapping: give a file, or one of .*dvrk-wrist, "):
        load_mapping("dvrk")


@pytest.mark.parametrize("name", config_names("import"))
def test_every_mapping_of_config_import_is_valid(name):
    assert load_mapping(Path(name).name).joints
