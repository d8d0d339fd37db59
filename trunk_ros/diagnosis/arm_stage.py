"""Joint angles against the tip: link lengths and the base's tilt, which are few and nearly linear."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.interpolate import Akima1DInterpolator

from trunk_ros.arm import Arm
from trunk_ros.chain import tip_pass
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.between import angles_between
from trunk_ros.diagnosis.criterion import FURTHER, RELEVANT, SIGNIFICANT
from trunk_ros.diagnosis.noise import Noise, noise_of, strides_within
from trunk_ros.effects import Effect, effect, registry
from trunk_ros.effects.effect import Now
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.resample import longest_gap

SIGNALS = ("y", "z", "roll")
UNITS = {"y": "m", "z": "m", "roll": "rad"}
STEP = 0.01
BLOCKS = 10
TURNS = 3


@dataclass
class TipData:
    """Tip and joint angles at the same stamps: ``tip`` (n, 3) y, z [m], roll [rad]; ``theta`` (n, joints)
    rad.
    """

    arm: Arm
    stamp: Array
    theta: Array
    tip: Array


@dataclass
class ArmFit:
    """Values found, by (effect, column), with spreads; and what is left."""

    values: dict[tuple[str, int], float] = field(default_factory=dict)
    std: dict[tuple[str, int], float] = field(default_factory=dict)
    gain: dict[tuple[str, int], float] = field(default_factory=dict)


def tip_data(recording: Recording, model: Model, delay: float = 0.0) -> TipData | None:
    """What the arm stage is judged on, joint readings being ``delay`` s old; None where the tip, link
    lengths or a joint are missing. ``model``: with the physics of the wires that was found.
    """
    joints = recording.series.get("joint_states")
    if recording.tip is None or joints is None or not model.arm.has_geometry:
        return None
    if not set(model.arm.joints) <= set(joints.joints):
        return None
    joints = joints.select(model.arm.joints)
    known = np.isfinite(joints.position).all(axis=1)
    if known.sum() < 4:
        return None
    at, pose = joints.stamp[known] - delay, recording.tip
    inside = _seen(at, pose.stamp) & np.isfinite(np.hstack([pose.position, pose.orientation])).all(axis=1)
    if inside.sum() < 4:
        return None
    theta = _theta(recording, model, at, joints.position[known], pose.stamp[inside])
    x, w = pose.orientation[inside, 0], pose.orientation[inside, 3]
    roll = 2.0 * np.arctan2(x, w)
    roll = np.mod(roll + np.pi, 2 * np.pi) - np.pi
    heading = theta.sum(axis=1)
    roll += 2 * np.pi * np.round((heading - roll) / (2 * np.pi))
    return TipData(model.arm, pose.stamp[inside], theta, np.column_stack([pose.position[inside, 1:3], roll]))


def _theta(recording: Recording, model: Model, at: Array, measured: Array, stamp: Array) -> Array:
    """(n, joints) angles at ``stamp``: what the model says, and what was measured ``at`` other moments beyond
    that, which is smooth.
    """
    both = angles_between(recording, model, np.concatenate([at, stamp]))
    told = np.zeros((len(at) + len(stamp), measured.shape[1])) if both is None else both
    return np.asarray(Akima1DInterpolator(at, measured - told[: len(at)])(stamp) + told[len(at) :])


def _seen(at: Array, stamp: Array) -> np.ndarray:
    """(n,) whether samples at stamps ``at`` lie close on both sides of each of ``stamp`` (n,)."""
    before = np.clip(np.searchsorted(at, stamp, side="right") - 1, 0, len(at) - 2)
    inside = (stamp >= at[0]) & (stamp <= at[-1])
    return np.asarray(inside & (at[before + 1] - at[before] <= longest_gap(at)))


class ArmProblem:
    """Forward selection of arm effects by linear least squares, relinearised."""

    def __init__(self, data: list[TipData], lasting: Array | None = None):
        """``lasting`` (joints,) rad: standard deviations of joint noise that lasts from sample to sample,
        which the tip's own scatter does not show.
        """
        self.data = data
        self.arm = data[0].arm
        self.from_joints = np.zeros(len(SIGNALS)) if lasting is None else self._at_the_tip(lasting)
        self.count = sum(len(d.stamp) for d in data)
        self.noise: list[float] = []
        self.memory = 0.0
        self.estimate_noise({})

    def estimate_noise(self, values: dict[tuple[str, int], float]) -> None:
        """Size and memory of the noise from what some values leave."""
        rests = self.residual(values)
        found = [self._noise([rest[:, k] for rest in rests]) for k in range(len(SIGNALS))]
        own = np.array([noise.std for noise in found])
        self.noise = [float(n) for n in np.sqrt(own**2 + self.from_joints**2)]
        self.memory = max(noise.correlation for noise in found)

    def _at_the_tip(self, lasting: Array) -> Array:
        """(3,) what lasting noise of the joints comes to at the tip."""
        power = np.zeros(len(SIGNALS))
        for d in self.data:
            told = self._predict(d, {})
            for joint in np.flatnonzero(lasting):
                theta = d.theta.copy()
                theta[:, joint] += lasting[joint]
                power += np.mean((self._predict(replace(d, theta=theta), {}) - told) ** 2, axis=0)
        return np.asarray(np.sqrt(power / len(self.data)))

    def _noise(self, residuals: list[Array]) -> Noise:
        step = float(np.median(np.concatenate([np.diff(d.stamp) for d in self.data])))
        masks = [np.ones(len(r), dtype=bool) for r in residuals]
        return noise_of(residuals, masks, strides_within(step))

    def _predict(self, d: TipData, values: dict[tuple[str, int], float]) -> Array:
        dt = np.diff(d.stamp, prepend=d.stamp[:1])
        now = Now(d.stamp, dt, d.theta, d.theta, d.theta, d.theta, d.theta, self.arm.joints, self.arm.ratio)
        return tip_pass(self.arm, _bound(values, len(self.arm.joints)), d.theta, now)

    def residual(self, values: dict[tuple[str, int], float]) -> list[Array]:
        """(n, 3) measured less predicted, one a recording."""
        return [d.tip - self._predict(d, values) for d in self.data]

    def whitened(self, values: dict[tuple[str, int], float], keep: list[np.ndarray] | None = None) -> Array:
        """All residuals over their noise, in one vector."""
        parts = [r / self.noise for r in self.residual(values)]
        return np.concatenate([(p if keep is None else p[keep[i]]).ravel() for i, p in enumerate(parts)])

    def solve(
        self, keys: list[tuple[str, int]], keep: list[np.ndarray] | None = None
    ) -> tuple[dict[tuple[str, int], float], Array, float]:
        """Values, their covariance and the squares left."""
        values = dict.fromkeys(keys, 0.0)
        covariance: Array = np.zeros((0, 0))
        for _ in range(TURNS if keys else 0):
            rest = self.whitened(values, keep)
            jacobian: Array = np.column_stack(
                [(self.whitened({**values, k: values[k] + _step(k)}, keep) - rest) / _step(k) for k in keys]
            )
            covariance = np.asarray(np.linalg.pinv(jacobian.T @ jacobian))
            values = {
                k: values[k] - float(d) for k, d in zip(keys, covariance @ jacobian.T @ rest, strict=True)
            }
        rest = self.whitened(values, keep)
        return values, covariance, float(rest @ rest)

    def run(self) -> ArmFit:
        """What pays; looked at again with the noise that it leaves."""
        self.estimate_noise(self.solve(self._chosen())[0])
        keys = self._chosen()
        values, covariance, cost = self.solve(keys)
        spread = np.sqrt(np.maximum(np.diag(covariance), 0.0) * max(1.0, cost / (3 * self.count)))
        gain = {k: self.solve([x for x in keys if x != k])[2] - cost for k in keys}
        return ArmFit(values, {k: float(s) for k, s in zip(keys, spread, strict=True)}, gain)

    def _chosen(self) -> list[tuple[str, int]]:
        """Add while it pays, then leave out what is not missed."""
        candidates = [
            (name, c)
            for name, kind in registry().items()
            if kind.stage == "arm"
            for c in (range(len(self.arm.joints)) if not kind.everywhere else [-1])
        ]
        keys: list[tuple[str, int]] = []
        cost = self.solve([])[2]
        # Noise with a memory repeats itself: so many samples are worth one.
        alike = (1.0 + self.memory) / (1.0 - self.memory)
        need = max((SIGNIFICANT + FURTHER) * alike, RELEVANT * self.count)
        while True:
            trials = {k: self.solve([*keys, k])[2] for k in candidates if k not in keys}
            best = min(trials, key=lambda k: trials[k], default=None)
            if best is None or cost - trials[best] < need:
                break
            keys, cost = [*keys, best], trials[best]
            for gone in [k for k in keys if self.solve([x for x in keys if x != k])[2] - cost < need]:
                keys = [k for k in keys if k != gone]
                cost = self.solve(keys)[2]
        return keys

    def held_out(self, keys: list[tuple[str, int]]) -> Array:
        """(n, 3) residuals of all recordings, each half of the blocks predicted by a fit to the other
        half.
        """
        folds = [np.arange(len(d.stamp)) * BLOCKS // max(len(d.stamp), 1) % 2 for d in self.data]
        fits = [self.solve(keys, [f != half for f in folds])[0] for half in (0, 1)]
        parts = [self.residual(values) for values in fits]
        return np.concatenate(
            [np.where((f == 0)[:, None], a, b) for f, a, b in zip(folds, *parts, strict=True)]
        )


def _step(key: tuple[str, int]) -> float:
    return STEP * effect(key[0]).parameters[0].typical


def _bound(values: dict[tuple[str, int], float], joints: int) -> list[Effect]:
    blocks: list[Effect] = []
    for name in registry():
        mine = {c: v for (n, c), v in values.items() if n == name}
        if mine:
            numbers = np.array([mine.get(c, mine.get(-1, 0.0)) for c in range(joints)])
            blocks.append(effect(name)({effect(name).parameters[0].name: numbers}))
    return blocks
