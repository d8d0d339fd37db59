"""The last link's mass and centre in another file, whose frames and bodies may be cut otherwise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from trunk_ros.arm.body import Body
from trunk_ros.bodies.found import Bodies
from trunk_ros.compiled import Array

AGREES = 0.05  # of unit vectors
SMALL = 1e-6  # m

OTHER_FRAME = "{}: mass and centre of the last link: its frame in the file cannot be found from the model's"
TOO_LIGHT = "{}: mass and centre of the last link: what is fixed to it in the file weighs as much itself"


@dataclass(frozen=True)
class Frame:
    """Where the joints are as the last link sees them, all joints at 0."""

    axes: Array
    """(joints, 3) unit vectors."""
    anchors: Array
    """(joints, 3) m, the last joint's at the last row."""
    tip: Array
    """(3,) m, NaN where it is not known."""

    @property
    def ways(self) -> Array:
        """(2 joints + 1, 3) unit vectors: axes, and ways from the last joint to the others and to the tip,
        NaN where there is none.
        """
        ways = np.vstack([self.anchors, self.tip]) - self.anchors[-1]
        size = np.linalg.norm(ways, axis=1, keepdims=True)
        return np.vstack([self.axes, np.where(size > SMALL, ways, np.nan) / np.maximum(size, SMALL)])

    @staticmethod
    def of(body: Body, joints: list[int]) -> Frame:
        """Of an arm's model, seen through some of its ``joints``, the last one at the end."""
        place, turn = (each[0] for each in body.places(np.zeros((1, len(body.own)))))
        back, origin = turn[joints[-1]].T, place[joints[-1]]
        axes = np.einsum("jab,jb->ja", turn[joints], body.axes[joints]) @ back.T
        return Frame(axes, (place[joints] - origin) @ back.T, (place[-1] - origin) @ back.T)


def turn_between(model: Frame, file: Frame) -> Array | None:
    """(3, 3) turn of the model's last link into the file's; None where the two are different arms, or one
    joint does not tell.
    """
    mine, theirs = model.ways, file.ways
    known = np.isfinite(mine).all(axis=1) & np.isfinite(theirs).all(axis=1)
    mine, theirs = mine[known], theirs[known]
    if np.abs(mine - theirs).max() < AGREES:
        return np.eye(3)
    if np.linalg.matrix_rank(mine, tol=AGREES) < 2:
        return None
    turn = np.asarray(Rotation.align_vectors(theirs, mine)[0].as_matrix())
    return turn if np.abs(mine @ turn.T - theirs).max() < AGREES else None


def own_part(
    bodies: Bodies, turn: Array, anchor: Array, mass: float, fixed: tuple[float, Array]
) -> tuple[float, Array] | None:
    """Mass [kg] and centre (3,) m of the link itself, without what is ``fixed`` to it in the file: its mass
    and first moments (3,). None where nothing is left of it.

    ``mass``: of both together as the file has it, where none was found; ``anchor`` (3,): of the last joint.
    """
    assert bodies.centre is not None
    whole = mass if bodies.mass is None else bodies.mass.value
    moments = turn @ np.array(bodies.centre.value) * bodies.centre.for_mass + whole * anchor
    left = whole - fixed[0]
    return (left, (moments - fixed[1]) / left) if left > 0.0 else None


def told(bodies: Bodies) -> str:
    """What is written of the last link."""
    assert bodies.centre is not None
    centre = ", ".join(f"{value:.4g}" for value in bodies.centre.value)
    mass = "" if bodies.mass is None else f"mass {bodies.mass.value:.4g} kg, "
    return f"bodies: {mass}centre {centre} m from {bodies.last}"
