"""What a planar chain of point masses asks of its joints to be moved."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled


@compiled
def inertial_moments(
    theta: Array, speed: Array, acceleration: Array, length: Array, mass: Array, tip: float, out: Array
) -> None:
    """Moment of inertia forces about each joint of a planar chain, -(M(q) q'' + C(q, q') q'), into ``out``
    [N m]: positive where it tends to increase the angle, as the weight's.

    ``theta``, ``speed``, ``acceleration`` (n, joints); ``length`` [m], ``mass`` [kg] (joints,) each at the
    middle of its link; ``tip`` [kg] at the end. Recursive Newton-Euler (Luh, Walker & Paul 1980, J. Dyn. Sys.
    102(2)), here with headings instead of frames.
    """
    steps, joints = theta.shape
    reach = np.empty((joints, 2))
    force = np.empty((joints, 2))
    for k in range(steps):
        heading = turn = swing = ay = az = 0.0
        for j in range(joints):
            heading += theta[k, j]
            turn += speed[k, j]
            swing += acceleration[k, j]
            reach[j, 0] = -length[j] * np.sin(heading)
            reach[j, 1] = length[j] * np.cos(heading)
            dy = -swing * reach[j, 1] - turn * turn * reach[j, 0]
            dz = swing * reach[j, 0] - turn * turn * reach[j, 1]
            force[j, 0] = -mass[j] * (ay + dy / 2)
            force[j, 1] = -mass[j] * (az + dz / 2)
            ay += dy
            az += dz
        fy, fz, moment = -tip * ay, -tip * az, 0.0
        for j in range(joints - 1, -1, -1):
            y, z = reach[j, 0], reach[j, 1]
            moment += y * fz - z * fy + (y * force[j, 1] - z * force[j, 0]) / 2
            fy += force[j, 0]
            fz += force[j, 1]
            out[k, j] = moment


@compiled
def mass_row(theta: Array, j: int, length: Array, mass: Array, tip: float, out: Array) -> None:
    """Row ``j`` of the mass matrix of a planar chain at joint angles ``theta`` (joints,), into ``out``
    (joints,) [kg m^2]; masses as in ``inertial_moments``.
    """
    joints = len(theta)
    place = np.zeros((joints + 1, 2))
    heading = 0.0
    for k in range(joints):
        heading += theta[k]
        place[k + 1, 0] = place[k, 0] - length[k] * np.sin(heading)
        place[k + 1, 1] = place[k, 1] + length[k] * np.cos(heading)
    y, z = place[j, 0], place[j, 1]
    ey, ez = place[joints, 0], place[joints, 1]
    # of all masses beyond a joint: m, m r and m r (r - r_j), with r from the base
    total, my, mz = tip, tip * ey, tip * ez
    swung = tip * (ey * (ey - y) + ez * (ez - z))
    for k in range(joints - 1, -1, -1):
        cy, cz = (place[k, 0] + place[k + 1, 0]) / 2, (place[k, 1] + place[k + 1, 1]) / 2
        if k >= j:
            total += mass[k]
            my += mass[k] * cy
            mz += mass[k] * cz
            swung += mass[k] * (cy * (cy - y) + cz * (cz - z))
        out[k] = swung - place[k, 0] * (my - total * y) - place[k, 1] * (mz - total * z)
