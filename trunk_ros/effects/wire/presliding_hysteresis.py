"""The reversal is a rounded loop that depends on amplitude, not a sharp dead band."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled, copied
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Motion, Now
from trunk_ros.effects.wire.elements import beside
from trunk_ros.effects.wire.play import JITTER
from trunk_ros.parameter import Parameter

PLAYS = 20
REACHED = 1e-12  # rad
LEAST = 0.02  # of the nominal dead band
SPREAD, BOUC_WEN, BOUC_WEN_2, DAHL, BRISTLES = range(5)
KIND = {
    "spread": SPREAD,
    "compliant": SPREAD,
    "bouc_wen": BOUC_WEN,
    "bouc_wen_2": BOUC_WEN_2,
    "dahl": DAHL,
    "bristles": BRISTLES,
}
SOLVED = 20  # Newton steps, from the side on which none overshoots; a few do


class PreslidingHysteresis(Effect):
    """The play's half-width w is followed by a rounded zone of ``width``.

    spread: plays of half-widths w + width s^shape, s evenly in 0 ... 1 (Prandtl-Ishlinskii, the same as
    Maxwell slip elements);
    compliant: the same, and a share of the motion, ``through``, gets past contacts that stick: they shear;
    bouc_wen, bouc_wen_2: h' = u' (1 - abs(h/H)^n (1 + sign(u' h))/2) with n = 1, 2; dahl: n = 1 with half
    the stiffness;
    H = width/2 behind a play of half-width w;
    bristles: the friction of the joint itself, which gives by ``bend`` before it slides (Dahl), on an elastic
    wire: theta = u - z, dz/dtheta = (W - sign(theta') z)/bend, with the stretch W = w + width that slides.
    """

    id = "presliding_hysteresis"
    stage, place, regime = "wire", 100, "reversal"
    signature = "Loops against position that are rounded at the reversals and shrink with the amplitude."
    source = (
        "Al-Bender & De Moerloose (2011), Int. J. Struct. Stab. Dyn.; compliant: a Maxwell slip element that "
        "never slips beside them; "
        "Bouc-Wen: Ismail et al. (2009), eq. (2); Dahl (1968)."
    )
    forms = ("spread", "bouc_wen", "bouc_wen_2", "dahl", "compliant", "bristles")
    beyond = "backlash"
    parameters = (
        Parameter(
            "width",
            "rad",
            (0.0, 1e3),
            "half the travel after a reversal until it slides fully, less w",
            typical=1e-3,
            scan=(5e-4, 2e-3),
        ),
        Parameter(
            "shape", "1", (0.1, 4.0), "above 1: more of the plays are narrow, below: wide", typical=1.0,
            null=1.0, scale="log",
        ),
        Parameter("through", "1", (0.0, 0.9), "share of the motion that gets past what sticks", typical=0.2),
        Parameter("bend", "rad", (0.0, 1e3), "travel of the joint that its friction gives by", typical=5e-4),
    )  # fmt: skip
    confused_with = (
        ("backlash", "reverse with small amplitudes: backlash lets nothing through"),
        ("stribeck_friction", "reverse at one speed with several amplitudes"),
    )

    def credible(self, now: Now, beside: bool = False) -> bool:
        """What is rounded has some width: past that the dead band itself gives way."""
        width = now.arm.dead_band[list(now.columns)] if now.arm is not None else np.zeros(1)
        rounded = self["bend"] if self.form == "bristles" else self["width"]
        return bool(np.all(rounded > LEAST * width))

    def adjust(self, core: Core, now: Now) -> None:
        if self._element is not None:
            core.rounding = beside(core.rounding, self._element, self._acts)

    @property
    def _acts(self) -> np.ndarray:
        return np.asarray((self["width"] != 0.0) | (self["bend"] != 0.0))

    @cached_property
    def _element(self) -> RoundedPlay | None:
        if not self._acts.any():
            return None
        gives = self["bend"] if self.form == "bristles" else self["through"]
        return RoundedPlay(self["width"], self["shape"], gives, KIND[self.form])

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """Of a wide loop only how it rises: what is flat in it is a dead band."""
        forms = super().forms_shown(motion)
        return tuple(form for form in forms if form == "dahl") if motion.wide_loop else forms

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        width, shape, through, bend = cls.parameters
        more = {"spread": (shape,), "compliant": (shape, through), "bristles": (bend,)}
        return (width, *more.get(form, ()))


class RoundedPlay:
    """A friction element with a rounded zone, in the place of the sharp play."""

    def __init__(self, width: Array, shape: Array, through: Array, kind: int):
        """(columns,) each; ``through``: of bristles the ``bend`` [rad]."""
        self.width = width
        self.through = through
        self.kind = kind
        evenly = (np.arange(PLAYS) + 0.5) / PLAYS
        self.zone = width[:, None] * evenly ** shape[:, None]
        """(columns, PLAYS) rad by which each play is wider than the dead band."""

    def run(self, u: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.run; state (PLAYS, columns): plays, or for the others the play, the input and the
        force.
        """
        memory = self._memory(u, state)
        out = np.empty_like(u)
        rounded(u, np.maximum(width, 0.0), self.width, self.zone, self.through, self.kind, memory, out)
        return out, memory

    def invert(self, y: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.invert, by a search: the element's output grows with its input."""
        memory, u = (
            (self._memory(y, None), y[0].copy()) if state is None else (state[0].copy(), state[1].copy())
        )
        out = np.empty_like(y)
        rounded_inverse(
            y, np.maximum(width, 0.0), self.width, self.zone, self.through, self.kind, memory, u, out
        )
        return out, (memory, u)

    def _memory(self, u: Array, state: Any) -> Array:
        if state is not None and state.ndim == 2:
            return np.asarray(state).copy()
        start = np.tile(u[0], (PLAYS, 1))
        if self.kind != SPREAD:
            start[2] = 0.0
        return start


@compiled
def step(u: float, w: float, width: float, zone: Array, through: float, kind: int, memory: Array) -> float:
    """One step of one column; ``memory`` (PLAYS,) changes in place."""
    if kind == SPREAD:
        total = 0.0
        for k in range(PLAYS):
            memory[k] = min(max(memory[k], u - w - zone[k]), u + w + zone[k])
            total += memory[k]
        return through * u + (1.0 - through) * total / PLAYS
    if kind == BRISTLES:
        return float(bent(u, w + width, through, memory))
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
def bent(u: float, w: float, bend: float, memory: Array) -> float:
    """The joint whose friction gives by ``bend`` on a wire that it stretches by ``w``; ``memory`` is input
    and stretch.
    """
    moved, memory[0] = u - memory[0], u
    side = 1.0 if moved > 0.0 else -1.0
    lacks, way, x = max(w - side * memory[2], 0.0), abs(moved), 0.0
    if bend <= 0.0:
        memory[2] = min(max(memory[2] + moved, -w), w)
        return float(u - memory[2])
    for _ in range(SOLVED):
        decay = np.exp(-x / bend)
        off = way - x - lacks * (1.0 - decay)
        if off < REACHED:
            break
        x += off / (1.0 + lacks / bend * decay)
    memory[2] = min(max(side * (w - lacks * np.exp(-x / bend)), -w), w)
    return float(u - memory[2])


@compiled
def rounded(
    u: Array,
    width: Array,
    rounding: Array,
    zone: Array,
    through: Array,
    kind: int,
    memory: Array,
    out: Array,
) -> None:
    """Pass ``u`` (n, columns) through; ``memory`` (PLAYS, columns) changes in place."""
    steps, columns = u.shape
    varying = width.shape[0] > 1
    own = np.empty(PLAYS)
    for j in range(columns):
        copied(memory[:, j], own)
        for k in range(steps):
            w = width[k, j] if varying else width[0, j]
            out[k, j] = step(u[k, j], w, rounding[j], zone[j], through[j], kind, own)
        copied(own, memory[:, j])


@compiled
def rounded_inverse(
    y: Array,
    width: Array,
    rounding: Array,
    zone: Array,
    through: Array,
    kind: int,
    memory: Array,
    u: Array,
    out: Array,
) -> None:
    """The input of least motion that takes the element from its state to ``y`` (n, columns)."""
    steps, columns = y.shape
    varying = width.shape[0] > 1
    own = np.empty(PLAYS)
    trial = np.empty(PLAYS)
    for j in range(columns):
        copied(memory[:, j], own)
        for k in range(steps):
            w = width[k, j] if varying else width[0, j]
            copied(own, trial)
            gap = y[k, j] - step(u[j], w, rounding[j], zone[j], through[j], kind, trial)
            if abs(gap) > JITTER:
                u[j] = reach(y[k, j], gap, u[j], w, rounding[j], zone[j], through[j], kind, own, trial)
            step(u[j], w, rounding[j], zone[j], through[j], kind, own)
            out[k, j] = u[j]
        copied(own, memory[:, j])


@compiled
def reach(
    y: float,
    gap: float,
    u: float,
    w: float,
    width: float,
    zone: Array,
    through: float,
    kind: int,
    own: Array,
    trial: Array,
) -> float:
    """Input next to ``u`` for which the output, ``gap`` away, is ``y``: false position, halved (Illinois)."""
    side = 1.0 if gap > 0.0 else -1.0
    near, short = u, -abs(gap)
    far = u + gap + side * (2.0 * (w + width) + abs(gap))
    copied(own, trial)
    over = side * (step(far, w, width, zone, through, kind, trial) - y)
    last = 0
    for count in range(60):
        middle = 0.5 * (near + far) if count % 4 == 3 else (near * over - far * short) / (over - short)
        copied(own, trial)
        off = side * (step(middle, w, width, zone, through, kind, trial) - y)
        if abs(off) < REACHED:
            return middle
        if off < 0.0:
            near, short, over, last = middle, off, over * (0.5 if last < 0 else 1.0), -1
        else:
            far, over, short, last = middle, off, short * (0.5 if last > 0 else 1.0), 1
    return far
