"""How the wires lay when a recording began, from its first measured joint angles.

Whatever moved before the recording left its mark in all memory alike: in plays, in drags of neighbours, in
creep. So what is estimated is not the memory but the motion: where each motor came from.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.resistance import Resistance
from trunk_ros.stage import State

SETTLE = 5.0  # s of measured joint angles that are looked at
TURNS = 2  # places that each motor is taken to have come from, one after the other
ROUNDS = 2  # over all joints
NEAR, FAR, STEPS = 1e-3, 2.0, 7  # rad, either side: distances that are tried first
SETTLED = 0.02  # of the squared errors: a round that takes no more off them is the last
CLOSE = 0.02  # of a distance: as exactly as that it is looked for
SMALL = 1e-5  # rad: errors below it are none
BEYOND = 0.1  # of the range that a model was fitted on: as far beyond it, it is as good as within
STAYS = 6.0  # of squared errors: one zero in twenty moves between two recordings
ZERO_ROUNDS = 8
USUAL = 0.5  # rad: how far motors go where a model does not say


@dataclass(frozen=True)
class Driven:
    """A motion of the motors, and the first joint angles that were measured in it."""

    phi: Array
    """(m, joints) gearbox angles."""
    stamp: Array
    """(m,) s."""
    rows: np.ndarray
    """(k,) of them at which the joints were measured first."""
    measured: Array
    """(k, joints) rad, NaN where nothing was measured."""
    velocity: Array | None = None
    resistance: Resistance | None = None


def first_rows(stamp: Array, settle: float) -> int:
    """How many of the measured rows at ``stamp`` (n,) s lie within ``settle`` s of the first; one at least,
    where the joints stop and are measured more rarely than that.
    """
    if settle <= 0.0 or not len(stamp):
        return 0
    return max(int(np.searchsorted(stamp, stamp[0] + settle)), 1)


def begun(chain: Chain, driven: Driven) -> tuple[State | None, Array]:
    """The state of a chain at the first of a motion's samples, None where nothing was measured; and (joints,)
    rad by which the joints' zeros have moved since the model was fitted.
    """
    if not len(driven.rows) or not np.isfinite(driven.measured).any():
        return None, np.zeros(len(chain.arm.joints))
    places, size = _likeliest(chain, driven)
    state, zero = _state(chain, driven, places), _zero(chain, driven, places, size)
    if zero.any():  # what memory cannot explain is no reason to bend it
        places, size = _likeliest(chain, driven, moved=True)
        state, zero = _state(chain, driven, places), _zero(chain, driven, places, size)
    return state, zero


def _zero(chain: Chain, driven: Driven, places: Array, size: Array) -> Array:
    """(joints,) rad by which zeros have moved; none of joints of which no model says what is too far off, as
    where the motors stand at angles that it was not fitted on.
    """
    if not len(chain.model.error) or _is_new(chain, driven):
        return np.zeros(len(size))
    off = _off(chain, driven, places) / size
    unsure = _unsure(off)
    zero, _ = moved_zero(_mean(off) / unsure, _spread(chain, size * unsure))
    return np.where(chain.model.error > 0.0, size * unsure * zero, 0.0)


def _spread(chain: Chain, unit: Array) -> Array:
    """(joints,) by how much zeros differ between the recordings of the fit, rms in a ``unit`` (joints,)."""
    return chain.model.zero / unit if len(chain.model.zero) else np.zeros(len(unit))


def _is_new(chain: Chain, driven: Driven) -> bool:
    """Whether an arm begins well beyond the angles that its model was fitted on."""
    model, first = chain.model, driven.phi[driven.rows[0]] * chain.arm.ratio
    if not (len(model.lowest) and len(model.highest)):
        return False
    room = BEYOND * (model.highest - model.lowest)
    new = (first < model.lowest - room) | (first > model.highest + room)
    return bool((new & (model.error > 0.0)).any())


def _unsure(off: Array) -> Array:
    """(joints,) how many times its usual error a model errs where first readings are ``off`` (k, joints) in
    such errors: what varies meanwhile is no zero, and the model is wrong there by as much.
    """
    return np.asarray(np.sqrt(1.0 + np.maximum(_mean(off**2) - _mean(off) ** 2, 0.0)))


def moved_zero(off: Array, spread: Array) -> tuple[Array, Array]:
    """(joints,) by how much zeros have moved where first readings are ``off`` in the mean, and what that
    takes off their squares, all in a model's usual errors: an encoder is homed anew, a camera stands
    elsewhere.

    Zeros that differ between the recordings of a fit (``spread``, rms) do so here. Beyond that most stay, at
    a price (``STAYS``); those that move may go far: they have a Cauchy distribution. The error lasts for
    seconds, so that all first readings count as one.
    """
    usual = 1.0 + spread**2
    seen = off / np.sqrt(usual)
    zero = seen.copy()
    for _ in range(ZERO_ROUNDS):  # it is likeliest where its derivative is none
        zero = seen / (1.0 + 2.0 / (1.0 + zero**2))
    gain = seen**2 - (seen - zero) ** 2 - 2.0 * np.log1p(zero**2) - STAYS
    far = np.where(gain > 0.0, zero, 0.0) * np.sqrt(usual)
    near = (off - far) * (1.0 - 1.0 / usual)
    return far + near, off**2 - seen**2 + np.maximum(gain, 0.0)


def history(chain: Chain, driven: Driven) -> Array:
    """(TURNS, joints) rad, joint side: how far from where they were first seen the motors had been before."""
    return _likeliest(chain, driven)[0]


def _likeliest(chain: Chain, driven: Driven, moved: bool = False) -> tuple[Array, Array]:
    """The ``history``, and the model's usual errors (joints,); ``moved``: zeros may have moved as well.

    The likeliest, joint by joint: where angles predicted at the first measured rows are off by no more than
    the model's usual error, and the motors came from no further than they usually are. A model's error lasts
    for seconds, so that all of a joint's first rows count as one.
    """
    places = np.zeros((TURNS, len(chain.arm.joints)))
    size = _usual_error(chain, _off(chain, driven, places))
    best = _power(chain, driven, places, size, moved)
    for _ in range(ROUNDS):
        before = best
        for turn, joint in np.ndindex(places.shape):
            if np.isfinite(driven.measured[:, joint]).any():
                places, best = _moved(chain, driven, places, (turn, joint), size, moved, best)
        if best > (1.0 - SETTLED) * before:
            break
    return places, size


def _usual_error(chain: Chain, off: Array) -> Array:
    """(joints,) rad, of the model; as large as the first errors ``off`` (k, joints) where it does not say."""
    known = chain.model.error if len(chain.model.error) else np.zeros(off.shape[1])
    seen = np.sqrt(np.nan_to_num(_mean(off**2)))
    return np.maximum(np.where(known > 0.0, known, seen), SMALL)


def _mean(values: Array) -> Array:
    """(joints,) means of what is known of (k, joints)."""
    known = np.isfinite(values)
    return np.asarray(np.where(known, values, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1))


def _moved(
    chain: Chain, driven: Driven, places: Array, at: tuple[int, ...], size: Array, moved: bool, best: float
) -> tuple[Array, float]:
    """One place moved to where it is likest."""

    def with_(distance: float) -> Array:
        out = places.copy()
        out[at] = distance
        return out

    def power(distance: float) -> float:
        return _power(chain, driven, with_(distance), size, moved)

    far = _farthest(power)
    return (with_(far[0]), far[1]) if far[1] < best else (places, best)


def _farthest(power: Callable[[float], float]) -> tuple[float, float]:
    """The distance at which a power is least, and it."""
    steps = np.geomspace(NEAR, FAR, STEPS)
    grid = np.concatenate([-steps[::-1], [0.0], steps])
    tried = [power(float(d)) for d in grid]
    k = int(np.argmin(tried))
    low, high = float(grid[max(k - 1, 0)]), float(grid[min(k + 1, len(grid) - 1)])
    finer = minimize_scalar(
        power, bounds=(low, high), method="bounded", options={"xatol": CLOSE * (high - low), "maxiter": 12}
    )
    return (float(finer.x), float(finer.fun)) if finer.fun < tried[k] else (float(grid[k]), tried[k])


def _power(chain: Chain, driven: Driven, places: Array, size: Array, moved: bool) -> float:
    """Mean squares of the errors at the first measured rows, each joint's in its own ``size``, and of the
    places in what is usual; ``moved``: with the likeliest zeros.
    """
    known = chain.model.reach if len(chain.model.reach) else np.zeros(places.shape[1])
    reach = np.where(known > 0.0, known, USUAL)
    far = places / np.maximum(reach, NEAR)
    off = _off(chain, driven, places) / size
    unsure = _unsure(off)
    gain = moved_zero(_mean(off) / unsure, _spread(chain, size * unsure))[1].sum() if moved else 0.0
    return float(_mean(off**2).sum() - gain + (far**2).sum())


def _off(chain: Chain, driven: Driven, places: Array) -> Array:
    """(k, joints) measured less predicted, with the motors coming from ``places``."""
    upto = int(driven.rows[-1]) + 1
    velocity = None if driven.velocity is None else driven.velocity[:upto]
    known = None if driven.resistance is None else driven.resistance.part(slice(upto))
    state = _state(chain, driven, places)
    shown, _ = chain.run(driven.phi[:upto], driven.stamp[:upto], state, velocity, known)
    return np.asarray(driven.measured - shown[driven.rows])


def _state(chain: Chain, driven: Driven, places: Array) -> State:
    """The state after the motors have come from ``places`` in no time; what depends on time begins anew."""
    path = driven.phi[0] + places / chain.arm.ratio
    _, state = chain.run(path, np.full(len(path), driven.stamp[0]))
    lasting = {e.id for e in chain.effects if e.remembers}
    kept = {name: memory for name, memory in state.blocks.items() if name in lasting}
    return replace(state, blocks=kept, drift=0.0, swing=None)
