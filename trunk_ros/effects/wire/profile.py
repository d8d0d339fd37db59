"""A pair of wires with friction spread over the arcs: tension profiles that slip from either end inward.

A wire is a row of elastic stretches, from the wheel to the joint, with a share of an arc between each two.
There the tensions T on both sides stay within exp(mu d_alpha) of each other (Euler-Eytelwein); at that limit
the wire slips. What moves one end thus slips a zone next to it, in which the profile is exponential, and
leaves the rest as it was. Its stretch decides how deep the zone goes.
"""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled

ENOUGH = 1e-10  # N by which the joint may be out of balance
TRIES = 60


@compiled
def zone(
    tension: Array, soft: Array, grip: Array, pull: float, from_joint: bool
) -> tuple[int, float, float, float]:
    """What happens in a wire whose end moves by ``pull`` m, positive to stretch it.

    ``tension`` (k,) N, ``soft`` (k,) m/N of each stretch, ``grip`` (k - 1,) mu d_alpha. Returns how deep the
    zone goes, the tension [N] and stiffness [N/m] of the moved end, and how slack the wire gets [m].
    """
    k = len(tension)
    side = 1.0 if pull > 0.0 else -1.0
    stretch, share, soften = pull, 1.0, 0.0
    for depth in range(k):
        i = k - 1 - depth if from_joint else depth
        stretch += soft[i] * tension[i]
        soften += soft[i] * share
        moved = stretch / soften
        if depth == k - 1:
            break
        g = grip[i - 1] if from_joint else grip[i]
        after = tension[i - 1] if from_joint else tension[i + 1]
        limit = np.exp(-side * g)
        if side * (moved * share * limit - after) <= 0.0:
            return depth, moved, 1.0 / soften, 0.0
        share *= limit
    if moved < 0.0:
        return k - 1, 0.0, 0.0, -stretch
    return k - 1, moved, 1.0 / soften, 0.0


@compiled
def move(tension: Array, slack: float, soft: Array, grip: Array, pull: float, from_joint: bool) -> float:
    """Move an end of a wire by ``pull`` m; returns how slack it is then [m]. ``tension`` changes in place."""
    if slack > 0.0:
        pull -= slack
        if pull <= 0.0:
            return -pull
    depth, end, _, left = zone(tension, soft, grip, pull, from_joint)
    k = len(tension)
    side = 1.0 if pull > 0.0 else -1.0
    for n in range(depth + 1):
        i = k - 1 - n if from_joint else n
        tension[i] = end
        if n < k - 1:
            end *= np.exp(-side * (grip[i - 1] if from_joint else grip[i]))
    return left


@compiled
def at_joint(tension: Array, slack: float, soft: Array, grip: Array, pull: float) -> tuple[float, float]:
    """Tension [N] and stiffness [N/m] that the joint would find, if it moved its end by ``pull`` m."""
    if slack > 0.0:
        pull -= slack
        if pull <= 0.0:
            return 0.0, 0.0
    _, end, stiffness, _ = zone(tension, soft, grip, pull, True)
    return end, stiffness


@compiled
def pair_step(wheel: float, force: float, tension: Array, slack: Array, soft: Array, grip: Array) -> float:
    """How far the joint goes [m] when the wheel has gone ``wheel`` m and the load pulls with ``force`` N.

    ``tension`` (2, k) and ``slack`` (2,) of the wire that pulls forward and the one that pulls back change in
    place. Newton's method on T_forward - T_back + force = 0, kept between what was too little and too much.
    """
    slack[0] = move(tension[0], slack[0], soft, grip, wheel, False)
    slack[1] = move(tension[1], slack[1], soft, grip, -wheel, False)
    gone, least, most = 0.0, -np.inf, np.inf
    for _ in range(TRIES):
        one, stiff_one = at_joint(tension[0], slack[0], soft, grip, -gone)
        other, stiff_other = at_joint(tension[1], slack[1], soft, grip, gone)
        rest = one - other + force
        if abs(rest) < ENOUGH or stiff_one + stiff_other == 0.0:
            break
        if rest > 0.0:
            least = gone
        else:
            most = gone
        gone += rest / (stiff_one + stiff_other)
        if not least < gone < most:
            gone = 0.5 * (least + most)
    slack[0] = move(tension[0], slack[0], soft, grip, -gone, True)
    slack[1] = move(tension[1], slack[1], soft, grip, gone, True)
    return gone
