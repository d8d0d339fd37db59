"""tip_error: where the tip is, coloured by how far it is from where a model has it; for RViz."""

from __future__ import annotations

from array import array
from collections import deque
from typing import Any

import numpy as np

from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.messages import nanoseconds
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.ros import PointCloud2, PointField, PoseStamped
from trunk_ros.nodes.parameters import PARAMETERS
from trunk_ros.trajectory import Array

KEPT = 500  # poses
SIZE = 4  # bytes of a number
FIELDS = ("x", "y", "z", "intensity")


class Beside:
    """Poses beside a model's, straight between its two next to them. Stamps are ns, places (3,) m."""

    def __init__(self) -> None:
        self._model: deque[tuple[int, Array]] = deque(maxlen=KEPT)
        self._waiting: deque[tuple[int, Any, Array]] = deque(maxlen=KEPT)

    def seen(self, stamp: int, header: Any, place: Array) -> list[tuple[Any, Array, float]]:
        """Note where the tip is; returns header, place and distance [m] of each that can be compared."""
        self._waiting.append((stamp, header, place))
        return self._compared()

    def predicted(self, stamp: int, place: Array) -> list[tuple[Any, Array, float]]:
        """Note where the model has it; one before the last means that time was set back."""
        if self._model and stamp <= self._model[-1][0]:
            self._model.clear()
        self._model.append((stamp, place))
        return self._compared()

    def _compared(self) -> list[tuple[Any, Array, float]]:
        found: list[tuple[Any, Array, float]] = []
        while self._waiting and self._model and self._waiting[0][0] <= self._model[-1][0]:
            stamp, header, place = self._waiting.popleft()
            if stamp >= self._model[0][0]:
                found.append((header, place, float(np.linalg.norm(place - self._at(stamp)))))
        return found

    def _at(self, stamp: int) -> Array:
        since = np.array([at - stamp for at, _ in self._model], dtype=float)
        places = np.array([place for _, place in self._model])
        return np.array([np.interp(0.0, since, column) for column in places.T])


class TipError(TrunkNode):
    """A point for each pose of the tip; ``intensity``: the distance [m]. RViz keeps them for a while."""

    NAME = "tip_error"
    idle = True
    OWN = PARAMETERS[NAME]

    def configure(self) -> None:
        """Listen to both tips."""
        self.beside = Beside()
        self.publish = self.streams.publish(PointCloud2, "trunk/tip_error")
        self.streams.sense("trunk/tip_pose", self.on_seen, PoseStamped)
        self.streams.sense(self.value("predicted"), self.on_predicted, PoseStamped)

    def on_seen(self, pose: Any) -> None:
        """Where the tip is."""
        self.show(self.beside.seen(nanoseconds(pose.header.stamp), pose.header, place_of(pose)))

    def on_predicted(self, pose: Any) -> None:
        """Where the model has it."""
        self.show(self.beside.predicted(nanoseconds(pose.header.stamp), place_of(pose)))

    def show(self, compared: list[tuple[Any, Array, float]]) -> None:
        """Publish a cloud for each."""
        for each in compared:
            self.publish(cloud(*each))


def place_of(pose: Any) -> Array:
    """Where a pose is [m]."""
    at = pose.pose.position
    return np.array([at.x, at.y, at.z], dtype=float)


def cloud(header: Any, place: Array, error: float) -> Any:
    """A cloud of one point [m] with the error [m] as its intensity."""
    message = PointCloud2(header=header, height=1, width=1, is_dense=True)
    message.point_step = message.row_step = SIZE * len(FIELDS)
    message.fields = [
        PointField(name=name, offset=SIZE * k, datatype=PointField.FLOAT32, count=1)
        for k, name in enumerate(FIELDS)
    ]
    message.data = array("B", np.append(place, error).astype("<f4").tobytes())
    return message


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(TipError, argv)
