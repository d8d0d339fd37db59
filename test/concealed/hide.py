"""What the demo hides in its arm: drawn from a seed, or of the effects that are asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from test.concealed.catalogue import CATALOGUE
from test.concealed.draws import ALL, logarithmic
from test.concealed.hidden import Hidden
from test.concealed.live_arm import can_be_live
from test.concealed.nominal import RATIO, Array
from test.concealed.plant import Effects, run
from test.concealed.recipe import Look, sized
from test.concealed.sensing import PERIOD
from test.concealed.trajectory import draw_reference

NOISE = 1e-4  # rad rms of the joint sensors
LEVEL = (10.0, 40.0)  # strength of an effect: rms over the noise
KINDS = (
    ("backlash", "presliding_hysteresis", "tension_error"),
    ("ratio_error", "joint_coupling", "load_elasticity"),
    ("sensor_delay", "viscous_lag", "zero_offset"),
)


def hide(seed: int, effects: Sequence[str] = ()) -> Effects:
    """Hidden physics of a seed: an effect of each of three kinds, or the given ones, on joints of their own.

    Raises ValueError for an effect that a live arm cannot have.
    """
    rng = np.random.default_rng(seed)
    names = list(effects) or [str(rng.choice(kind)) for kind in KINDS]
    for name in names:
        if name not in CATALOGUE:
            raise ValueError(f"no effect {name}; there are {', '.join(CATALOGUE)}")
    reference = draw_reference(rng, "mixed", np.arange(3000, dtype=np.float64) * PERIOD)
    setpoint = reference / RATIO
    look = Look(run((), setpoint), ALL)
    free = [int(j) for j in rng.permutation(5)]
    hidden = []
    for name in names:
        many = min(int(rng.integers(1, 3)), max(len(free), 1))
        joints, free = tuple(sorted(free[:many])) or (int(rng.integers(5)),), free[many:]
        hidden.append(_drawn(rng, name, joints, look, setpoint))
    return tuple(hidden)


def _drawn(
    rng: np.random.Generator, name: str, joints: tuple[int, ...], look: Look, setpoint: Array
) -> Hidden:
    level = float(logarithmic(rng, *LEVEL))
    for _ in range(50):
        recipe = CATALOGUE[name](rng, joints, look)
        if not can_be_live(recipe.make(recipe.start)):
            continue
        return sized(recipe, lambda h: _strength(h, look, setpoint), level)
    raise ValueError(f"{name} is none that a live arm can have")


def _strength(h: Hidden, look: Look, setpoint: Array) -> float:
    apart = (run((h,), setpoint).theta - look.motion.theta)[:, list(h.joints)]
    return float(np.sqrt((apart**2).mean()) / NOISE)
