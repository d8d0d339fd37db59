"""Parameters of the recorder."""

from __future__ import annotations

from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.model import Declaration
from trunk_ros.nodes.bags.writer import Options
from trunk_ros.recording.mcap.write import COMPRESSION

MIB = float(1 << 20)

PARAMETERS = (
    Declaration("output", "", "", None, "folder of the bag; must not exist", True),
    Declaration("topics", [""], "", None, "topics to record; empty: all of the node's namespace", True),
    Declaration("all_namespaces", False, "", None, "record the topics of other namespaces too", True),
    Declaration("exclude", [""], "", None, "topics to leave out", True),
    Declaration("compression", "zstd", "", None, f"of chunks: {', '.join(COMPRESSION)}", True),
    Declaration(
        "chunk_size",
        1.0,
        "MiB",
        (0.001, 64.0),
        "size at which a chunk is closed; every 0.4 s at the latest",
        True,
    ),
    Declaration(
        "buffer_size",
        64.0,
        "MiB",
        (0.1, 4096.0),
        "messages that may wait for the disk; more is counted as loss",
        True,
    ),
    Declaration("depth", 5000, "", (1, 1e6), "messages of a topic that may wait in the middleware", True),
    Declaration("split_size", 0.0, "MiB", (0.0, 1e6), "size at which a new file is begun; 0: never", True),
    Declaration(
        "split_duration", 0.0, "s", (0.0, 1e6), "time after which a new file is begun; 0: never", True
    ),
    Declaration("manifest", "{}", "", None, "JSON about the run, kept in the bag", True),
)


def bag_options(node: Any) -> Options:
    """What the parameters say of the bag. Raises TrunkError."""
    if not node.value("output"):
        raise TrunkError("give the bag's folder: --ros-args -p output:=FOLDER")
    if node.value("compression") not in COMPRESSION:
        raise TrunkError(
            f"unknown compression {node.value('compression')!r}: choose {', '.join(COMPRESSION)}"
        )
    return Options(
        node.value("compression"),
        int(node.value("chunk_size") * MIB),
        int(node.value("buffer_size") * MIB),
        int(node.value("split_size") * MIB),
        node.value("split_duration"),
    )
