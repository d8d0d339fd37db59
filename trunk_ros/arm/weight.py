"""Where a tree of links is, what its weight does to its joints and which mass they move, over recordings.

The links are those of Pinocchio's model, and so are the formulas: of all that a recording asks of rigid
bodies this is asked most, and through the library a posture takes twice to twenty times as long.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from trunk_ros.compiled import Array, compiled


class Tree(NamedTuple):
    """Joints of a model in its order, one value each; the root is left out."""

    parent: np.ndarray
    """(joints,): 0 for the root, else the number of the joint before, from 1."""
    turn: Array
    """(joints, 3, 3) of the joint's frame at 0 in the one before."""
    place: Array
    """(joints, 3) m, likewise."""
    axis: Array
    """(joints, 3) unit vectors in the joint's frame."""
    slides: np.ndarray
    """(joints,): which are prismatic."""
    mass: Array
    """(joints,) kg."""
    centre: Array
    """(joints, 3) m: of mass, in the joint's frame."""
    inertia: Array
    """(joints, 3, 3) kg m^2 about the centre, in the joint's axes."""


def tree_of(model: Any) -> Tree:
    """Of a model of Pinocchio in which each joint has one value."""
    joints = range(1, model.njoints)
    motions = np.array([np.ravel(model.joints[i].createData().S) for i in joints]).reshape(-1, 6)
    slides = np.asarray(motions[:, :3].any(axis=1))
    return Tree(
        np.array([model.parents[i] for i in joints], dtype=np.int64),
        np.array([model.jointPlacements[i].rotation for i in joints]).reshape(-1, 3, 3),
        np.array([model.jointPlacements[i].translation for i in joints]).reshape(-1, 3),
        np.ascontiguousarray(np.where(slides[:, None], motions[:, :3], motions[:, 3:])),
        slides,
        np.array([model.inertias[i].mass for i in joints]),
        np.array([model.inertias[i].lever for i in joints]).reshape(-1, 3),
        np.array([model.inertias[i].inertia for i in joints]).reshape(-1, 3, 3),
    )


@compiled
def forward(q: Array, tree: Tree, turn: Array, at: Array, axis: Array) -> None:
    """Where the joints' frames are at ``q`` (joints,), in the root's axes: ``turn`` (joints + 1, 3, 3) and
    ``at`` (joints + 1, 3), the root first, and ``axis`` likewise, along or about which each moves.
    """
    row = np.empty(3)
    for d in range(3):
        for e in range(3):
            turn[0, d, e] = 1.0 if d == e else 0.0
        at[0, d] = 0.0
    for i in range(1, len(q) + 1):
        a, one = tree.parent[i - 1], tree.axis[i - 1]
        move = q[i - 1] if tree.slides[i - 1] else 0.0
        c, s = (1.0, 0.0) if tree.slides[i - 1] else (np.cos(q[i - 1]), np.sin(q[i - 1]))
        for d in range(3):
            at[i, d] = at[a, d]
            for e in range(3):
                at[i, d] += turn[a, d, e] * tree.place[i - 1, e]
                row[e] = (
                    turn[a, d, 0] * tree.turn[i - 1, 0, e]
                    + turn[a, d, 1] * tree.turn[i - 1, 1, e]
                    + turn[a, d, 2] * tree.turn[i - 1, 2, e]
                )
            along = row[0] * one[0] + row[1] * one[1] + row[2] * one[2]
            axis[i, d] = along
            at[i, d] += along * move
            turn[i, d, 0] = c * row[0] + s * (row[1] * one[2] - row[2] * one[1]) + (1 - c) * along * one[0]
            turn[i, d, 1] = c * row[1] + s * (row[2] * one[0] - row[0] * one[2]) + (1 - c) * along * one[1]
            turn[i, d, 2] = c * row[2] + s * (row[0] * one[1] - row[1] * one[0]) + (1 - c) * along * one[2]


@compiled
def frames(q: Array, tree: Tree, turn: Array, at: Array) -> None:
    """The same over a recording ``q`` (n, joints): ``turn`` (n, joints + 1, 3, 3) and ``at``
    (n, joints + 1, 3).
    """
    axis = np.empty((q.shape[1] + 1, 3))
    for k in range(len(q)):
        forward(q[k], tree, turn[k], at[k], axis)


@compiled
def weigh(q: Array, gravity: Array, tree: Tree, out: Array) -> None:
    """Moment or force of the weight on each joint, ``out`` (n, joints), positive where it tends to increase
    the joint's value ``q`` (n, joints); ``gravity`` (3,) m/s^2 in the root's axes.
    """
    steps, joints = q.shape
    turn, at, axis = np.empty((joints + 1, 3, 3)), np.empty((joints + 1, 3)), np.empty((joints + 1, 3))
    mass, first = np.empty(joints + 1), np.empty((joints + 1, 3))  # of all that hangs on a joint
    for k in range(steps):
        forward(q[k], tree, turn, at, axis)
        for i in range(1, joints + 1):
            for d in range(3):
                centre = at[i, d]
                for e in range(3):
                    centre += turn[i, d, e] * tree.centre[i - 1, e]
                first[i, d] = tree.mass[i - 1] * centre
            mass[i] = tree.mass[i - 1]
        for i in range(joints, 0, -1):
            a = tree.parent[i - 1]
            if tree.slides[i - 1]:
                out[k, i - 1] = mass[i] * (
                    axis[i, 0] * gravity[0] + axis[i, 1] * gravity[1] + axis[i, 2] * gravity[2]
                )
            else:
                x, y, z = (
                    first[i, 0] - mass[i] * at[i, 0],
                    first[i, 1] - mass[i] * at[i, 1],
                    first[i, 2] - mass[i] * at[i, 2],
                )
                out[k, i - 1] = (
                    axis[i, 0] * (y * gravity[2] - z * gravity[1])
                    + axis[i, 1] * (z * gravity[0] - x * gravity[2])
                    + axis[i, 2] * (x * gravity[1] - y * gravity[0])
                )
            if a > 0:
                mass[a] += mass[i]
                for d in range(3):
                    first[a, d] += first[i, d]


@compiled
def mass_matrix(q: Array, tree: Tree, out: Array) -> None:
    """M, ``out`` (n, joints, joints) in kg m^2, kg m or kg, of joints at ``q`` (n, joints): of all that hangs
    on a joint the momentum in which one unit of its speed results, along every joint before it (composite
    rigid bodies, Featherstone 2008, ch. 6).
    """
    steps, joints = q.shape
    turn, at, axis = np.empty((joints + 1, 3, 3)), np.empty((joints + 1, 3)), np.empty((joints + 1, 3))
    mass, first, second = np.empty(joints + 1), np.empty((joints + 1, 3)), np.empty((joints + 1, 3, 3))
    along, about = np.empty((joints + 1, 3)), np.empty((joints + 1, 3))  # speeds at the root, and of turning
    centre, push, spin, half = np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3))
    for k in range(steps):
        forward(q[k], tree, turn, at, axis)
        for i in range(1, joints + 1):
            m = mass[i] = tree.mass[i - 1]
            for d in range(3):
                centre[d] = at[i, d]
                for e in range(3):
                    centre[d] += turn[i, d, e] * tree.centre[i - 1, e]
                    half[d, e] = 0.0
                    for f in range(3):
                        half[d, e] += turn[i, d, f] * tree.inertia[i - 1, f, e]
            far = centre[0] * centre[0] + centre[1] * centre[1] + centre[2] * centre[2]
            for d in range(3):
                first[i, d] = m * centre[d]
                for e in range(3):
                    second[i, d, e] = m * ((far if d == e else 0.0) - centre[d] * centre[e])
                    for f in range(3):
                        second[i, d, e] += half[d, f] * turn[i, e, f]
            slides = tree.slides[i - 1]
            for d in range(3):
                about[i, d] = 0.0 if slides else axis[i, d]
                along[i, d] = axis[i, d] if slides else cross(at[i], axis[i], d)
        for i in range(joints, 0, -1):
            for d in range(3):
                push[d] = mass[i] * along[i, d] + cross(about[i], first[i], d)
                spin[d] = cross(first[i], along[i], d)
                for e in range(3):
                    spin[d] += second[i, d, e] * about[i, e]
            out[k, i - 1, :i] = 0.0
            j = i
            while j > 0:
                size = 0.0
                for d in range(3):
                    size += about[j, d] * spin[d] + along[j, d] * push[d]
                out[k, i - 1, j - 1] = size
                j = tree.parent[j - 1]
            a = tree.parent[i - 1]
            if a > 0:
                mass[a] += mass[i]
                for d in range(3):
                    first[a, d] += first[i, d]
                    for e in range(3):
                        second[a, d, e] += second[i, d, e]
        for i in range(joints):
            for j in range(i):
                out[k, j, i] = out[k, i, j]


@compiled
def cross(a: Array, b: Array, d: int) -> float:
    """A component of the cross product of two vectors (3,)."""
    e, f = (d + 1) % 3, (d + 2) % 3
    return float(a[e] * b[f] - a[f] * b[e])
