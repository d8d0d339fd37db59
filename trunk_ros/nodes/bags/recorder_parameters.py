"""What the parameters of the recorder say of its bag."""

from __future__ import annotations

from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.bags.writer import Options
from trunk_ros.recording.mcap import COMPRESSION

MIB = float(1 << 20)


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
