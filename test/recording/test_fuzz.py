"""Malformed input of any kind gives a recording or one line, whatever is wrong with it, and soon.

FUZZ_EXAMPLES=20000 makes a long run of it.
"""

import os
import shutil
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from test.recording.bags import NOETIC, motion, only_file, pose, write_bag, write_ros1
from trunk_ros.errors import TrunkError
from trunk_ros.model import load_model
from trunk_ros.nodes.bags.source import BagSource
from trunk_ros.recording.importing.bag import read_bag
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recover import recover
from trunk_ros.trajectory import load_trajectory

KINDS = ("mcap", "mcap_zstd", "mcap_message", "mcap_file", "sqlite3", "ros1", "ros1_lz4", "ros1_bz2")
EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "100"))
FUZZ = settings(
    max_examples=EXAMPLES,
    deadline=10_000,
    derandomize=EXAMPLES <= 100,  # the same in every short run, new ones in a long one
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)

MAPPING = """
time: {column: t, unit: s}
joints: [a, b]
gearbox_states: {position: {columns: [x, {expr: "y + 2 * x"}], unit: rad}}
joint_states: {position: {columns: [x, y], unit: [rad, m]}, velocity: {columns: [x, y], unit: "1"}}
"""
TABLE = "t,x,y\n0,1,2\n0.1,3,4\n0.1,5,6\n0.2,7,8\n"


@pytest.fixture(scope="module")
def seeds(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A small recording of every kind: the file to damage."""
    folder = tmp_path_factory.mktemp("seeds")
    messages = [*motion(count=30), ("/trunk/tip_pose", 10**18, pose(10**18, [0.0] * 7))]
    modes = {"": "NONE", "_zstd": "STORAGE", "_message": "MESSAGE", "_file": "FILE"}
    seeds = {}
    for name, mode in modes.items():
        bag = write_bag(folder / f"mcap{name}", messages, compression=CompressionMode[mode])
        seeds[f"mcap{name}"] = only_file(bag, ".mcap.zstd" if name == "_file" else ".mcap")
    bag = write_bag(folder / "sqlite3", messages, StoragePlugin.SQLITE3)
    seeds["sqlite3"] = only_file(bag, ".db3")
    ros1 = motion(count=30, store=NOETIC)
    seeds["ros1"] = write_ros1(folder / "plain.bag", ros1)
    for method in Writer1.CompressionFormat:
        seeds[f"ros1_{method.name.lower()}"] = write_ros1(folder / f"{method.name}.bag", ros1, method)
    return seeds


@st.composite
def damages(draw: st.DrawFn) -> list[tuple[str, float, bytes]]:
    """Overwrite, insert, remove or cut at a share of the length."""
    kinds = st.sampled_from(["overwrite", "insert", "remove", "cut"])
    where = st.floats(0, 1)
    what = st.one_of(
        st.binary(min_size=1, max_size=9), st.sampled_from([b"\xff" * 8, bytes(8), b"\xff\xff\xff\x7f"])
    )
    return draw(st.lists(st.tuples(kinds, where, what), min_size=1, max_size=4))


def damaged(data: bytes, damage: list[tuple[str, float, bytes]]) -> bytes:
    for kind, share, what in damage:
        at = int(share * len(data))
        rest = {"overwrite": at + len(what), "insert": at, "remove": at + 3 * len(what), "cut": len(data)}[
            kind
        ]
        data = data[:at] + (b"" if kind in ("remove", "cut") else what) + data[rest:]
    return data


def one_line_or_fine(action, *arguments) -> None:
    try:
        action(*arguments)
    except TrunkError as error:
        text = str(error)
        assert text
        assert "\n" not in text
        assert len(text) < 2000


@pytest.mark.parametrize("kind", KINDS)
@FUZZ
@given(damage=damages())
def test_damaged_bytes_of_a_bag(seeds, tmp_path, kind, damage):
    seed = seeds[kind]
    bag = (
        shutil.copytree(seed.parent, tmp_path / "bag", dirs_exist_ok=True) if "ros1" not in kind else tmp_path
    )
    file = bag / seed.name
    file.write_bytes(damaged(seed.read_bytes(), damage))
    one_line_or_fine(read_recording, file)
    one_line_or_fine(read_recording, bag)
    if file.suffix == ".mcap":
        one_line_or_fine(recover, bag)


@FUZZ
@given(
    content=st.binary(max_size=300),
    head=st.sampled_from(
        [b"", b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n", b"SQLite format 3\0", b"\x28\xb5\x2f\xfd"]
    ),
)
def test_random_bytes(tmp_path, content, head):
    file = tmp_path / "random"
    file.write_bytes(head + content)
    one_line_or_fine(read_recording, file)
    one_line_or_fine(recover, file)


@FUZZ
@given(damage=damages())
def test_damaged_metadata(seeds, tmp_path, damage):
    bag = shutil.copytree(seeds["mcap"].parent, tmp_path / "bag", dirs_exist_ok=True)
    (bag / "metadata.yaml").write_bytes(damaged((bag / "metadata.yaml").read_bytes(), damage))
    one_line_or_fine(read_recording, bag)
    one_line_or_fine(recover, bag)


YAML = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)
KEYS = st.sampled_from(
    [
        "version",
        "storage_identifier",
        "relative_file_paths",
        "compression_mode",
        "compression_format",
        "topics_with_message_count",
        "custom_data",
    ]
)


@FUZZ
@given(key=KEYS, value=YAML)
@example(key="relative_file_paths", value=["", ".", "..", "/"])
@example(key="custom_data", value={"trunk_ros.units": "[[[["})
def test_metadata_with_entries_of_another_kind(seeds, tmp_path, key, value):
    bag = shutil.copytree(seeds["mcap"].parent, tmp_path / "bag", dirs_exist_ok=True)
    content = yaml.safe_load((bag / "metadata.yaml").read_text())
    content["rosbag2_bagfile_information"][key] = value
    (bag / "metadata.yaml").write_text(yaml.safe_dump(content))
    one_line_or_fine(read_recording, bag)


@FUZZ
@given(damage=damages())
def test_damaged_mappings(tmp_path, damage):
    (tmp_path / "table.csv").write_text(TABLE)
    mapping = tmp_path / "map.yaml"
    mapping.write_bytes(damaged(MAPPING.encode(), damage))
    one_line_or_fine(read_csv, tmp_path / "table.csv", mapping)


@FUZZ
@given(damage=damages())
@example(damage=[("overwrite", 0.0, b'"')])  # a header that holds all other lines
def test_damaged_tables(tmp_path, damage):
    (tmp_path / "map.yaml").write_text(MAPPING)
    table = tmp_path / "table.csv"
    table.write_bytes(damaged(TABLE.encode(), damage))
    one_line_or_fine(read_csv, table, tmp_path / "map.yaml")


BAG_MAPPING = """
joints: [a, b]
gearbox_states:
  position: {columns: ["/joint_states.position[0]", {expr: "'/joint_states.position[c]' * 2"}], unit: rad}
joint_states:
  position: {columns: ["/trunk/tip_pose.pose.position.x", "/joint_states.position[a]"], unit: [m, rad]}
"""


@FUZZ
@given(damage=damages())
def test_damaged_mappings_of_bags(seeds, tmp_path, damage):
    mapping = tmp_path / "map.yaml"
    mapping.write_bytes(damaged(BAG_MAPPING.encode(), damage))
    one_line_or_fine(read_bag, seeds["mcap"], mapping)


@pytest.mark.parametrize("kind", ["mcap", "mcap_zstd", "sqlite3"])
@FUZZ
@given(damage=damages())
def test_damaged_bags_that_are_mapped(seeds, tmp_path, kind, damage):
    (tmp_path / "map.yaml").write_text(BAG_MAPPING)
    file = tmp_path / seeds[kind].name
    file.write_bytes(damaged(seeds[kind].read_bytes(), damage))
    one_line_or_fine(read_bag, file, tmp_path / "map.yaml")


@pytest.mark.parametrize("kind", ["mcap", "mcap_zstd", "sqlite3", "ros1", "ros1_bz2"])
@FUZZ
@given(damage=damages())
def test_damaged_bags_that_are_replayed(seeds, tmp_path, kind, damage):
    file = tmp_path / seeds[kind].name
    file.write_bytes(damaged(seeds[kind].read_bytes(), damage))
    one_line_or_fine(replayed, file)


def replayed(path: Path) -> int:
    with BagSource(path) as bag:
        return sum(len(data) for _, _, data in bag.messages({topic.name for topic in bag.topics}))


MODEL = yaml.safe_dump({"/**": {"ros__parameters": load_model("trunk").parameters()}}).encode()


@FUZZ
@given(damage=damages())
def test_damaged_models(tmp_path, damage):
    model = tmp_path / "model.yaml"
    model.write_bytes(damaged(MODEL, damage))
    one_line_or_fine(load_model, model)


@FUZZ
@given(name=st.sampled_from(sorted(load_model("trunk").parameters())), value=YAML)
@example(name="arm.joints", value=["a"] * 3)
@example(name="arm.link_length", value=[float("nan")] * 5)
def test_models_with_entries_of_another_kind(tmp_path, name, value):
    model = tmp_path / "model.yaml"
    flat = load_model("trunk").parameters() | {name: value}
    model.write_text(yaml.safe_dump({"/**": {"ros__parameters": flat}}))
    one_line_or_fine(load_model, model)


LAUGHS = "".join(f"l{i}: &l{i} [{', '.join([f'*l{i - 1}'] * 9) if i else 'lol'}]\n" for i in range(30))
MERGES = "".join(f"m{i}: &m{i} {{{f'<<: [*m{i - 1}, *m{i - 1}]' if i else 'a: b'}}}\n" for i in range(40))


@pytest.mark.parametrize("bomb", [LAUGHS, MERGES, "[" * 100_000, "? " * 5_000])
def test_yaml_that_grows_when_it_is_read_is_refused_soon(seeds, tmp_path, bomb):
    (tmp_path / "map.yaml").write_text(bomb)
    one_line_or_fine(read_csv, tmp_path / "table.csv", tmp_path / "map.yaml")
    one_line_or_fine(load_model, tmp_path / "map.yaml")
    one_line_or_fine(load_trajectory, tmp_path / "map.yaml")
    bag = shutil.copytree(seeds["mcap"].parent, tmp_path / "bag")
    file = bag / "metadata.yaml"
    for old, new in (("- mcap.mcap", "- *l29"), ("custom_data: null", "custom_data: {a: *l29}")):
        text = file.read_text()
        assert old in text
        (bag / "metadata.yaml").write_text(bomb + (text.replace(old, new) if bomb == LAUGHS else text))
        one_line_or_fine(read_recording, bag)
        file.write_text(text)


@pytest.mark.parametrize("name", ["arm.joints", "arm.link_length", "arm.payload", "servo.kp"])
def test_a_model_that_grows_when_it_is_read_is_refused_soon(tmp_path, name):
    (tmp_path / "model.yaml").write_text(f"{LAUGHS}/**: {{ros__parameters: {{{name}: *l29}}}}\n")
    with pytest.raises(TrunkError, match="refers to its own parts"):
        load_model(tmp_path / "model.yaml")
