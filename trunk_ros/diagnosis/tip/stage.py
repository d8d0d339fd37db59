"""Joint angles against the tip: link lengths and the base's tilt, which are few and nearly linear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import median_filter

from trunk_ros.chain import tip_pass
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.noise import alike, noise_of, strides_within
from trunk_ros.diagnosis.data.sensor_faults import FEW
from trunk_ros.diagnosis.evidence.evidence import ROUGH, SCATTER
from trunk_ros.diagnosis.search.score import CURVE, FURTHER, RELEVANT, SIGNIFICANT
from trunk_ros.diagnosis.tip.data import TipData, roll_of
from trunk_ros.diagnosis.tip.values import NAMELESS, SHIFT, ZERO, Key, Point, bound, credible, point_of
from trunk_ros.effects import effect, registry
from trunk_ros.effects.effect import Now
from trunk_ros.model import Values

SIGNALS = ("y", "z", "roll")
UNITS = {"y": "m", "z": "m", "roll": "rad"}
STEP = 0.01
SMALL = {"y": 1e-5, "z": 1e-5, "roll": 1e-4}  # steps of what has no name
BLOCKS = 10
TURNS = 3
SETTLED = 0.1  # squared unit-noise residual: a slope need not be computed again for less
BLIND = 1e-10  # of the largest curvature: the data do not see it
FAR = 8.0  # times the noise that a single pose is off those beside it
BESIDE = 5


@dataclass
class ArmFit:
    """Values that the recordings want changed or added, with spreads; and what is left."""

    values: Point = field(default_factory=dict)
    std: Point = field(default_factory=dict)
    gain: Point = field(default_factory=dict)


class ArmProblem:
    """Forward selection of arm effects by linear least squares, relinearised."""

    def __init__(
        self, data: list[TipData], lasting: Array | None = None, effects: Mapping[str, Values] | None = None
    ):
        """``lasting`` (joints,) rad: standard deviations of joint noise that lasts from sample to sample,
        which the tip's own scatter does not show. ``effects``: what the model has already.
        """
        self.signals = SIGNALS[: min(d.tip.shape[1] for d in data)]
        self.data = [replace(d, tip=d.tip[:, : len(self.signals)]) for d in data]
        self.arm = data[0].arm
        self.known = point_of(effects or {}, len(self.arm.joints))
        self.zeros = (effects or {}).get("zero_offset", {}).get("offset", np.zeros(len(self.arm.joints)))
        """(joints,) rad by which the readings of joints and gearbox disagree."""
        self.candidates = self._candidates()
        self.from_joints = np.zeros(len(self.signals)) if lasting is None else self._at_the_tip(lasting)
        self.strays, self.alike = 0, 1.0
        self.estimate_noise(self.known)
        free = self.solve(self.candidates)[0]
        self.estimate_noise(free)
        self._leave_out_strays(self.residual(free))
        self.estimate_noise(self.solve(self.candidates)[0])
        self._scores: dict[frozenset[Key], float] = {}

    @property
    def count(self) -> int:
        """Poses that count."""
        return sum(len(d.stamp) for d in self.data)

    @property
    def need(self) -> float:
        """What a value must gain: noise with a memory repeats itself, so many samples are worth one."""
        return max((SIGNIFICANT + FURTHER) * self.alike, RELEVANT * self.count)

    def price(self, keys: list[Key]) -> float:
        """Of some values: what has no name is dearer."""
        return self.need * sum(CURVE if name in NAMELESS else 1.0 for name, _ in keys)

    def _candidates(self) -> list[Key]:
        joints = range(len(self.arm.joints))
        kinds = [kind for kind in registry().values() if kind.stage == "arm"]
        named = [(kind.id, c) for kind in kinds for c in ([-1] if kind.everywhere else joints)]
        return [*named, *((SHIFT, k) for k in range(len(self.signals))), *((ZERO, c) for c in joints[1:])]

    def estimate_noise(self, values: Point) -> None:
        """Size and memory of the noise from what some values leave."""
        rests = self.residual(values)
        longest = strides_within(float(np.median(np.concatenate([np.diff(d.stamp) for d in self.data]))))
        masks = [np.ones(len(rest), dtype=bool) for rest in rests]
        own = [noise_of([rest[:, k] for rest in rests], masks, longest).std for k in range(len(self.signals))]
        self.noise = [float(n) for n in np.sqrt(np.square(own) + self.from_joints**2)]
        self.alike = max(alike([rest[:, k] for rest in rests]) for k in range(len(self.signals)))

    def _leave_out_strays(self, rests: list[Array]) -> None:
        """Poses that are far from those beside them do not count, unless that is the sensor's noise."""
        off = [np.abs(rest - median_filter(rest, (BESIDE, 1))) / self.noise for rest in rests]
        stray = [np.any(each > FAR, axis=1) for each in off]
        self.strays = int(sum(each.sum() for each in stray))
        if self.strays > FEW * self.count:
            self.strays = 0
        elif self.strays:
            self.data = [_rows(d, ~each) for d, each in zip(self.data, stray, strict=True)]

    def _at_the_tip(self, lasting: Array) -> Array:
        """(signals,) what lasting noise of the joints comes to at the tip."""
        power = np.zeros(len(self.signals))
        for d in self.data:
            told = self._predict(d, self.known)
            for joint in np.flatnonzero(lasting):
                theta = d.theta.copy()
                theta[:, joint] += lasting[joint]
                power += np.mean((self._predict(replace(d, theta=theta), self.known) - told) ** 2, axis=0)
        return np.asarray(np.sqrt(power / len(self.data)))

    def _predict(self, d: TipData, values: Point) -> Array:
        joints = self.arm.joints
        dt, theta = np.diff(d.stamp, prepend=d.stamp[:1]), d.theta
        if any(name == ZERO for name, _ in values):
            theta = theta + [values.get((ZERO, c), 0.0) for c in range(len(joints))]
        now = Now(d.stamp, dt, theta, theta, theta, theta, theta, joints, self.arm.ratio)
        pose = tip_pass(self.arm, bound(values, len(joints)), theta, now)
        tip = np.column_stack([pose[:, 1:3], roll_of(pose[:, 3:], theta.sum(axis=1))])
        shift = [values.get((SHIFT, k), 0.0) for k in range(len(self.signals))]
        return np.asarray(tip[:, : len(self.signals)] + shift)

    def residual(self, values: Point) -> list[Array]:
        """(n, signals) measured less predicted, one a recording."""
        return [d.tip - self._predict(d, values) for d in self.data]

    def whitened(self, values: Point, keep: list[np.ndarray] | None = None) -> Array:
        """All residuals over their noise, in one vector."""
        parts = [r / self.noise for r in self.residual(values)]
        return np.concatenate([(p if keep is None else p[keep[i]]).ravel() for i, p in enumerate(parts)])

    def solve(self, keys: list[Key], keep: list[np.ndarray] | None = None) -> tuple[Point, Array, float]:
        """Values, those of ``keys`` fitted and the others as the model has them; the covariance of the
        fitted ones, and the squares left.
        """
        values = {**self.known, **{k: self.known.get(k, 0.0) for k in keys}}
        covariance, jacobian = np.zeros((0, 0)), np.zeros((0, 0))
        for turn in range(TURNS if keys else 0):
            rest = self.whitened(values, keep)
            if turn == 0 or _gain(covariance, jacobian.T @ rest) > SETTLED:
                jacobian = np.column_stack([self._slope(values, k, rest, keep) for k in keys])
                covariance = np.asarray(np.linalg.pinv(jacobian.T @ jacobian, rcond=BLIND, hermitian=True))
            step = covariance @ jacobian.T @ rest
            values |= {k: values[k] - float(d) for k, d in zip(keys, step, strict=True)}
        rest = self.whitened(values, keep)
        return values, covariance, float(rest @ rest)

    def _slope(self, values: Point, key: Key, rest: Array, keep: list[np.ndarray] | None) -> Array:
        step = self._step(key)
        return (self.whitened({**values, key: values[key] + step}, keep) - rest) / step

    def _step(self, key: Key) -> float:
        if key[0] in NAMELESS:
            return SMALL["roll" if key[0] == ZERO else self.signals[key[1]]]
        return STEP * effect(key[0]).parameters[0].typical

    def run(self) -> ArmFit:
        """What pays, with spreads; these as ``evidence.spreads`` has them."""
        keys = self._chosen()
        values, covariance, cost = self.solve(keys)
        power = self.alike * max(1.0, cost / (len(self.signals) * self.count))
        spread = SCATTER * np.sqrt(np.maximum(np.diag(covariance), 0.0) * power)
        std = {k: float(np.hypot(s, ROUGH * values[k])) for k, s in zip(keys, spread, strict=True)}
        gain = {k: self.solve([x for x in keys if x != k])[2] - cost for k in keys}
        return ArmFit({k: values[k] for k in keys}, std, gain)

    def score(self, keys: list[Key]) -> float:
        """Squares left and prices; no good where a value is not to be believed."""
        if frozenset(keys) not in self._scores:
            values, _, cost = self.solve(keys)
            believed = all(credible(k, v) for k, v in values.items())
            self._scores[frozenset(keys)] = cost + self.price(keys) if believed else np.inf
        return self._scores[frozenset(keys)]

    def _chosen(self) -> list[Key]:
        """Add, leave out or put one in the place of another, while it pays."""
        keys: list[Key] = []
        best = self.score(keys)
        while True:
            others = [k for k in self.candidates if k not in keys]
            fewer = [[x for x in keys if x != k] for k in keys]
            changes = [[*keys, k] for k in others] + fewer
            found, score = self._best(changes)
            if score >= best:
                found, score = self._best([[*rest, k] for rest in fewer for k in others])
            if score >= best:
                return keys
            keys, best = found, score

    def _best(self, trials: list[list[Key]]) -> tuple[list[Key], float]:
        scores = [self.score(keys) for keys in trials]
        return (trials[int(np.argmin(scores))], min(scores)) if trials else ([], np.inf)

    def held_out(self, keys: list[Key]) -> Array:
        """(n, signals) residuals of all recordings, each half of the blocks predicted by a fit to the other
        half.
        """
        folds = [np.arange(len(d.stamp)) * BLOCKS // max(len(d.stamp), 1) % 2 for d in self.data]
        fits = [self.solve(keys, [f != half for f in folds])[0] for half in (0, 1)]
        parts = [self.residual(values) for values in fits]
        return np.concatenate(
            [np.where((f == 0)[:, None], a, b) for f, a, b in zip(folds, *parts, strict=True)]
        )


def _gain(covariance: Array, pull: Array) -> float:
    """Squares that a linear step removes."""
    return float(pull @ covariance @ pull)


def _rows(d: TipData, keep: np.ndarray) -> TipData:
    return TipData(d.arm, d.stamp[keep], d.theta[keep], d.tip[keep])
