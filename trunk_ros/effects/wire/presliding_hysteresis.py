"""The reversal is a rounded loop that depends on amplitude, not a sharp dead band."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter

PLAYS = 12
SPREAD, BOUC_WEN, BOUC_WEN_2, DAHL = range(4)


class PreslidingHysteresis(Effect):
    """The play's half-width w is followed by a rounded zone of ``width``.

    spread: plays of half-widths w + width s^shape, s evenly in 0 ... 1 (Prandtl-Ishlinskii, the same as
    Maxwell slip elements);
    bouc_wen, bouc_wen_2: h' = u' (1 - abs(h/H)^n (1 + sign(u' h))/2) with n = 1, 2; dahl: n = 1 with half
    the stiffness;
    H = width/2 behind a play of half-width w.
    """

    id = "presliding_hysteresis"
    stage, place, regime = "wire", 100, "reversal"
    signature = "Loops against position that are rounded at the reversals and shrink with the amplitude."
    source = (
        "Al-Bender & De Moerloose (2011), Int. J. Struct. Stab. Dyn.; "
        "Bouc-Wen: Ismail et al. (2009), eq. (2); Dahl (1968)."
    )
    forms = ("spread", "bouc_wen", "bouc_wen_2", "dahl")
    parameters = (
        Parameter(
            "width",
            "rad",
            (0.0, 3.0),
            "half the travel after a reversal until it slides fully, less w",
            typical=1e-3,
            scan=(5e-4, 2e-3),
        ),
        Parameter(
            "shape", "1", (0.25, 4.0), "above 1: more of the plays are narrow, below: wide", typical=1.0,
            null=1.0, scale="log",
        ),
    )  # fmt: skip
    confused_with = (
        ("backlash", "reverse with small amplitudes: a dead band lets nothing through"),
        ("stribeck_friction", "reverse at one speed with several amplitudes"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        if np.any(self["width"] != 0.0):
            core.rounding = RoundedPlay(self["width"], self["shape"], self.forms.index(self.form))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "spread" else cls.parameters[:1]


class RoundedPlay:
    """A friction element with a rounded zone, in the place of the sharp play."""

    def __init__(self, width: Array, shape: Array, kind: int):
        self.width = width
        self.shape = shape
        self.kind = kind

    def run(self, u: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.run; state (PLAYS, columns): plays, or for the others the play, the input and the
        force.
        """
        memory = self._memory(u, state)
        out = np.empty_like(u)
        rounded(u, np.maximum(width, 0.0), self.width, self.shape, self.kind, memory, out)
        return out, memory

    def invert(self, y: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.invert, by bisection: the element's output grows with its input."""
        memory, u = (
            (self._memory(y, None), y[0].copy()) if state is None else (state[0].copy(), state[1].copy())
        )
        out = np.empty_like(y)
        rounded_inverse(y, np.maximum(width, 0.0), self.width, self.shape, self.kind, memory, u, out)
        return out, (memory, u)

    def _memory(self, u: Array, state: Any) -> Array:
        if state is not None and state.ndim == 2:
            return np.asarray(state).copy()
        start = np.tile(u[0], (PLAYS, 1))
        if self.kind != SPREAD:
            start[2] = 0.0
        return start


@compiled
def step(u: float, w: float, width: float, shape: float, kind: int, memory: Array) -> float:
    """One step of one column; ``memory`` (PLAYS,) changes in place."""
    if kind == SPREAD:
        total = 0.0
        for k in range(PLAYS):
            place = (k + 0.5) / PLAYS
            half = w + width * (place if shape == 1.0 else place**shape)
            memory[k] = min(max(memory[k], u - half), u + half)
            total += memory[k]
        return total / PLAYS
    before = memory[0]
    memory[0] = min(max(before, u - w), u + w)
    travel = memory[0] - before
    limit = width / 2
    force = memory[2]
    if limit <= 0.0:
        return float(memory[0])
    side = 1.0 if travel > 0.0 else -1.0
    left = abs(travel)
    toward = force * side
    if kind == DAHL:
        toward = limit - (limit - toward) * np.exp(-left / (2.0 * limit))
    else:
        if toward < 0.0:
            free = min(left, -toward)
            toward += free
            left -= free
        if left > 0.0 and kind == BOUC_WEN:
            toward = limit - (limit - toward) * np.exp(-left / limit)
        elif left > 0.0:
            toward = limit * np.tanh(np.arctanh(min(toward / limit, 1.0 - 1e-12)) + left / limit)
    memory[2] = toward * side
    return float(memory[0] - memory[2])


@compiled
def rounded(
    u: Array, width: Array, rounding: Array, shape: Array, kind: int, memory: Array, out: Array
) -> None:
    """Pass ``u`` (n, columns) through; ``memory`` (PLAYS, columns) changes in place."""
    steps, columns = u.shape
    varying = width.shape[0] > 1
    own = np.empty(PLAYS)
    for j in range(columns):
        own[:] = memory[:, j]
        for k in range(steps):
            w = width[k, j] if varying else width[0, j]
            out[k, j] = step(u[k, j], w, rounding[j], shape[j], kind, own)
        memory[:, j] = own


@compiled
def rounded_inverse(
    y: Array, width: Array, rounding: Array, shape: Array, kind: int, memory: Array, u: Array, out: Array
) -> None:
    """The input of least motion that takes the element from its state to ``y`` (n, columns)."""
    steps, columns = y.shape
    varying = width.shape[0] > 1
    own = np.empty(PLAYS)
    trial = np.empty(PLAYS)
    for j in range(columns):
        own[:] = memory[:, j]
        for k in range(steps):
            w = width[k, j] if varying else width[0, j]
            trial[:] = own
            gap = y[k, j] - step(u[j], w, rounding[j], shape[j], kind, trial)
            if abs(gap) > 1e-12:
                near = u[j]
                far = u[j] + gap + (2.0 * (w + rounding[j]) + abs(gap)) * (1.0 if gap > 0 else -1.0)
                for _ in range(50):
                    middle = 0.5 * (near + far)
                    trial[:] = own
                    if (step(middle, w, rounding[j], shape[j], kind, trial) - y[k, j]) * gap < 0.0:
                        near = middle
                    else:
                        far = middle
                u[j] = far
            step(u[j], w, rounding[j], shape[j], kind, own)
            out[k, j] = u[j]
        memory[:, j] = own
