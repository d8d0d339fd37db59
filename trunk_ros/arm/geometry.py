"""How an arm's links differ from its description."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trunk_ros.arm.body import Body
from trunk_ros.arm.pinocchio import library
from trunk_ros.compiled import Array


@dataclass
class Geometry:
    """Small changes of links and frames; turns are rotation vectors [rad], shifts are in m."""

    shift: Array
    """(joints, 3): of all that follows a joint, along the axes of the joint's frame."""
    tilt: Array
    """(joints, 3): of a joint's axis about the axes of its frame; the arm with all joints at 0 stays."""
    zero: Array
    """(joints,) rad or m that a joint stands beyond its reading."""
    base: Array
    """(6,): of the whole arm along and about the axes of the base link."""
    tool: Array
    """(6,): of the tip along and about its own axes."""

    def __bool__(self) -> bool:
        """Whether anything is changed."""
        return any(each.any() for each in (self.shift, self.tilt, self.zero, self.base, self.tool))

    @staticmethod
    def nominal(joints: int) -> Geometry:
        """No change."""
        return Geometry(
            np.zeros((joints, 3)), np.zeros((joints, 3)), np.zeros(joints), np.zeros(6), np.zeros(6)
        )


def changed(body: Body, geometry: Geometry) -> Body:
    """The body with another geometry."""
    if not geometry:
        return body
    pin = library()
    model = body.model.copy()
    own = {i: j for j, i in enumerate(body.own)}
    behind = pin.SE3.Identity()  # what the joint before passes on
    for i in body.path:
        placed = behind * model.jointPlacements[i]
        j = own.get(i)
        turn = np.eye(3) if j is None else pin.exp3(geometry.tilt[j])
        model.jointPlacements[i] = placed * pin.SE3(turn, np.zeros(3))
        after = np.zeros(3) if j is None else geometry.shift[j]
        behind = pin.SE3(turn.T, np.zeros(3)) * pin.SE3(np.eye(3), after)
    tip = model.frames[body.tip]
    tip.placement = behind * tip.placement * _moved(geometry.tool)
    base = body.base * _moved(geometry.base).inverse()
    return replace(
        body,
        model=model,
        base=base,
        offset=body.offset + body.spread @ geometry.zero,
        _loaded={},
    )


def _moved(change: Array) -> Any:
    pin = library()
    return pin.SE3(pin.exp3(np.asarray(change[3:])), np.asarray(change[:3]))
