"""The readers, each as a function of the bytes of one file, and inputs to begin with."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import yaml
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from test.recording.bags import KIND, NOETIC, STORE, motion, pose, write_bag, write_ros1
from trunk_ros.errors import TrunkError
from trunk_ros.model import load_model
from trunk_ros.motion import named_trajectory
from trunk_ros.nodes.bags.source import BagSource
from trunk_ros.recording.importing.bag import read_bag
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.importing.expression import parse
from trunk_ros.recording.importing.mapping import Mapping, parse_mapping
from trunk_ros.recording.messages.block import block_of
from trunk_ros.recording.messages.decode import Decoder
from trunk_ros.recording.messages.layout import joint_layout
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recover import recover
from trunk_ros.simulate import simulate
from trunk_ros.trajectory import load_trajectory, save_trajectory

FOLDER = "TRUNK_ROS_FUZZ_FOLDER"  # in the environment
MAP = """time: {column: t, unit: s}
joints: [a, b]
gearbox_states: {position: {columns: [x, {expr: "y + 2 * x"}], unit: rad}}
joint_states: {position: {columns: [x, y], unit: [rad, m]}, velocity: {columns: [x, y], unit: "1"}}
"""
TABLE = "t,x,y\n0,1,2\n0.1,3,4\n0.1,5,6\n0.2,7,8\n"
EXPRESSIONS = (b"y + 2 * x", b"atan2(x, 'a.b[0]') / sqrt(abs(y ** 3))", b"-nonzero(radians(x)) * pi")


@dataclass(frozen=True)
class Target:
    """A reader. seeds: inputs that it reads; read: raises TrunkError for what it does not."""

    seeds: Callable[[], list[bytes]]
    read: Callable[[bytes], object]


def attempt(target: Target, data: bytes) -> None:
    """Read an input; AssertionError where what is refused is not told in one line."""
    try:
        target.read(data)
        said = "read"
    except TrunkError as error:
        said = str(error)
    assert said.isprintable()
    assert 0 < len(said) < 4000


@cache
def folder() -> Path:
    """A folder for this process: that which the fuzzer removes, as libFuzzer ends without clean-up."""
    if given := os.environ.get(FOLDER):
        return Path(given)
    _kept.append(new_folder())
    return Path(_kept[0].name)


def new_folder() -> tempfile.TemporaryDirectory[str]:
    """A folder in memory where there is such a place."""
    memory = Path("/dev/shm")
    return tempfile.TemporaryDirectory(prefix="trunk_ros_fuzz_", dir=memory if memory.is_dir() else None)


_kept: list[tempfile.TemporaryDirectory[str]] = []


def written(name: str, data: bytes) -> Path:
    """A file of this content."""
    path = folder() / name
    path.write_bytes(data)
    return path


@cache
def bag_folder() -> Path:
    """A small bag of two topics."""
    messages = [*motion(count=6), ("/trunk/tip_pose", 10**18, pose(10**18, [0.0] * 7))]
    return write_bag(folder() / "bag", messages)


@cache
def mcap_files() -> list[bytes]:
    """MCAP files, with chunks packed and not."""
    out = [file.read_bytes() for file in bag_folder().glob("*.mcap")]
    packed = write_bag(folder() / "packed", motion(count=6), compression=CompressionMode.STORAGE)
    return out + [file.read_bytes() for file in packed.glob("*.mcap")]


@cache
def recordings() -> list[bytes]:
    """A file of every kind."""
    out = mcap_files().copy()
    stored = write_bag(folder() / "sqlite3", motion(count=4), StoragePlugin.SQLITE3)
    packed = write_bag(folder() / "file", motion(count=4), compression=CompressionMode.FILE)
    out += [next(stored.glob("*.db3")).read_bytes(), next(packed.glob("*.zstd")).read_bytes()]
    for method in (None, *Writer1.CompressionFormat):
        path = folder() / f"{method}.bag"
        out.append(write_ros1(path, motion(count=4, store=NOETIC), method).read_bytes())
    return out


def read_metadata(data: bytes) -> None:
    """A folder whose metadata.yaml this is."""
    bag = folder() / "described"
    bag.mkdir(exist_ok=True)
    for file in bag_folder().glob("*.mcap"):
        (bag / file.name).write_bytes(file.read_bytes())
    (bag / "metadata.yaml").write_bytes(data)
    try:
        read_recording(bag)
    finally:
        recover(bag)


def named(stem: str, data: bytes) -> Path:
    """A file of this content with the suffix by which rosbags knows it."""
    suffixes = {b"\x89MCAP": ".mcap", b"SQLite": ".db3", b"#ROSBAG": ".bag"}
    found = (suffix for magic, suffix in suffixes.items() if data.startswith(magic))
    return written(stem + next(found, ""), data)


def bags() -> list[bytes]:
    """Those of the files that rosbags opens."""
    return [each for each in recordings() if named("seed", each).suffix]


def replayed(data: bytes) -> int:
    """All messages of a bag, as replay takes them."""
    with BagSource(named("replayed", data)) as bag:
        return sum(len(content) for _, _, content in bag.messages({topic.name for topic in bag.topics}))


def bag_mapping() -> Mapping:
    """Columns of the small bag."""
    columns = ["/joint_states.position[a]", {"expr": "'/joint_states.position[1]' * 2"}]
    return parse_mapping(
        {"joints": ["a", "b"], "joint_states": {"position": {"columns": columns, "unit": "rad"}}}
    )


def decoded(data: bytes) -> None:
    """A JointState, in CDR and as ROS 1 has it."""
    for encoding in ("cdr", "ros1"):
        Decoder(joint_layout).add(block_of("/joint_states", KIND, encoding, [data, data], [0, 1]))


def moved(data: bytes) -> None:
    """A recording whose joints are taken for gearboxes, through an ideal transmission."""
    recording = read_recording(written("moved", data))
    series = {**recording.series, "gearbox_states": recording.require("joint_states")}
    simulate(
        type(recording)(recording.name, recording.start_ns, recording.duration, series), load_model("direct")
    )


def expressed(data: bytes) -> None:
    """An expression of columns."""
    with suppress(ValueError):
        parse(data.decode(errors="replace"))


def models() -> list[bytes]:
    """Model files."""
    flat = [load_model(name).parameters() for name in ("trunk", "direct")]
    return [yaml.safe_dump({"/**": {"ros__parameters": each}}).encode() for each in flat]


def trajectories() -> list[bytes]:
    """A trajectory, cut short."""
    path = folder() / "seed.yaml"
    save_trajectory(path, named_trajectory("default", load_model("trunk").arm, 2.0))
    text = path.read_text().splitlines(keepends=True)
    return [
        "".join(text[:6]).encode(),
        b"joint_names: [a]\npoints: [{positions: [1], time_from_start: {sec: 1}}]\n",
    ]


def messages() -> list[bytes]:
    """Serialised messages."""
    states = [message for _, _, message in motion(count=2, full=True)]
    old = [message for _, _, message in motion(count=2, full=True, store=NOETIC)]
    new = [bytes(STORE.serialize_cdr(each, KIND)) for each in states]
    return new + [bytes(NOETIC.serialize_ros1(each, KIND)) for each in old]


TARGETS = {
    "recording": Target(recordings, lambda data: read_recording(written("recording", data))),
    "metadata": Target(lambda: [(bag_folder() / "metadata.yaml").read_bytes()], read_metadata),
    "recover": Target(mcap_files, lambda data: recover(written("recovered.mcap", data))),
    "replay": Target(bags, replayed),
    "import_bag": Target(bags, lambda data: read_bag(named("imported", data), bag_mapping())),
    "table": Target(
        lambda: [TABLE.encode()],
        lambda data: read_csv(written("table.csv", data), parse_mapping(yaml.safe_load(MAP))),
    ),
    "mapping": Target(
        lambda: [MAP.encode()],
        lambda data: read_csv(written("seed.csv", TABLE.encode()), written("map.yaml", data)),
    ),
    "model": Target(models, lambda data: load_model(written("model.yaml", data))),
    "trajectory": Target(trajectories, lambda data: load_trajectory(written("motion.yaml", data))),
    "message": Target(messages, decoded),
    "expression": Target(lambda: list(EXPRESSIONS), expressed),
    "simulate": Target(recordings, moved),
}
