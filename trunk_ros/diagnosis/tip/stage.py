"""Joint angles against the tip: the arm's geometry, which is nearly linear in its few values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import permutations

import numpy as np
from scipy.ndimage import median_filter

from trunk_ros.arm.body import Body
from trunk_ros.arm.geometry import changed
from trunk_ros.compiled import Array
from trunk_ros.data.noise import alike, noise_of, strides_within
from trunk_ros.data.sensor_faults import BESIDE, FEW
from trunk_ros.diagnosis.evidence.cross_validation import fold_of
from trunk_ros.diagnosis.search.fit import GAINED
from trunk_ros.diagnosis.search.score import CURVE, FURTHER, RELEVANT, SIGNIFICANT, naming
from trunk_ros.diagnosis.tip.data import SIGNALS, UNITS, TipData, signals_of
from trunk_ros.diagnosis.tip.lasting import Lasting, lasting_on
from trunk_ros.diagnosis.tip.linear import Linear, Normal
from trunk_ros.diagnosis.tip.slopes import Slopes
from trunk_ros.diagnosis.tip.values import (
    NAMELESS,
    SHIFT,
    ZERO,
    Key,
    Point,
    bound,
    candidates,
    credible,
    owner,
    parameter_of,
    point_of,
    told_otherwise,
)
from trunk_ros.effect_values import Values, zeros_in
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.levels import ROUGH, SCATTER, TENFOLD, TURNS
from trunk_ros.stage import core_of

SMALL = {"m": 1e-5, "rad": 1e-4}  # steps of what has no name
RESOLVED = 1e-6  # m, rad: descriptions of arms have six decimals, and no tracker of a tip sees less


@dataclass
class ArmFit:
    """Values that the recordings want changed or added, with spreads; and what is left."""

    values: Point = field(default_factory=dict)
    std: Point = field(default_factory=dict)
    gain: Point = field(default_factory=dict)


class ArmProblem:
    """Forward selection of arm effects by linear least squares, relinearised."""

    def __init__(
        self, data: list[TipData], lasting: Lasting | None = None, effects: Mapping[str, Values] | None = None
    ):
        """``lasting``: joint noise that the tip's own scatter does not show. ``effects``: what the model has
        already.
        """
        self.data, self.arm = data, data[0].arm
        self.signals = signals_of(data)
        self.rows = [SIGNALS.index(signal) for signal in self.signals]
        self.known = point_of(effects or {}, len(self.arm.joints))
        self.zeros = np.zeros(len(self.arm.joints)) + zeros_in(effects or {})
        """(joints,) rad by which the readings of joints and gearbox disagree."""
        self.candidates = candidates(self.arm, len(self.signals))
        self.told_otherwise = told_otherwise(self.arm)
        self.strays, self.alike = 0, 1.0
        self.noise = np.ones(len(self.signals))
        self._normals: dict[bytes, Normal] = {}
        self._scores: dict[frozenset[Key], float] = {}
        self.linearise(self.known)
        lasting = lasting or lasting_on(self.arm.joints, {})
        counted = lasting.counted([d.stamp for d in data])
        self.from_joints, self.standing = self._at_the_tip(np.stack([lasting.std, counted]))
        self.estimate_noise(self.known)
        free = self._free()
        self.estimate_noise(free)
        if self._leave_out_strays(self.residual(free)):
            self.estimate_noise(self._free())
        self.linearise(self.known)

    @property
    def count(self) -> int:
        """Poses that count."""
        return sum(len(d.stamp) for d in self.data)

    @property
    def need(self) -> float:
        """What a value must gain: noise with a memory repeats itself, so many samples are worth one."""
        return max((SIGNIFICANT + FURTHER) * self.alike, RELEVANT * self.count)

    def price(self, keys: list[Key]) -> float:
        """Of some values, as in the wires: a cause, and less for its further values. What has no name is
        dearer; a frame that is off comes before a link that looks the same.
        """
        causes = {(owner(key), key[1]) for key in keys}
        dear = sum(CURVE if name in NAMELESS else 1.0 if c < 0 else 1.0 + ROUGH for name, c in causes)
        further = FURTHER * (len(keys) - len(causes)) + naming("arm") * len({name for name, _ in causes})
        return self.need * dear + self.alike * further

    # Noise

    def estimate_noise(self, values: Point) -> None:
        """Size and memory of the noise from what some values leave."""
        rests = self.residual(values)
        longest = strides_within(float(np.median(np.concatenate([np.diff(d.stamp) for d in self.data]))))
        masks = [np.ones(len(rest), dtype=bool) for rest in rests]
        own = [noise_of([rest[:, k] for rest in rests], masks, longest).std for k in range(len(self.signals))]
        self.noise = np.maximum(np.sqrt(np.square(own) + self.from_joints**2), RESOLVED)
        of_rest = [alike([rest[:, k] for rest in rests]) for k in range(len(self.signals))]
        self.alike = max(*of_rest, *np.square(self.standing / self.noise).tolist())
        self._normals.clear()
        self._scores.clear()

    def _leave_out_strays(self, rests: list[Array]) -> bool:
        """Poses that are far from those beside them do not count, unless that is the sensor's noise; whether
        there are any.
        """
        off = [np.abs(rest - median_filter(rest, (2 * BESIDE + 1, 1))) / self.noise for rest in rests]
        stray = [np.any(each > TENFOLD, axis=1) for each in off]
        self.strays = int(sum(each.sum() for each in stray))
        if self.strays > FEW * self.count:
            self.strays = 0
        elif self.strays:
            self.data = [d.rows(~each) for d, each in zip(self.data, stray, strict=True)]
            self.linearise(self.origin)
        return self.strays > 0

    def _at_the_tip(self, lasting: Array) -> Array:
        """(k, signals) what lasting noises of the joints (k, joints) come to at the tip."""
        body, _ = self._bent(self.data[0], self.known)
        power = np.zeros((len(lasting), len(self.signals)))
        for d in self.data:
            ways = np.mean(body.jacobian(d.theta)[:, self.rows] ** 2, axis=0)
            power += lasting**2 @ ways.T
        return np.asarray(np.sqrt(power / len(self.data)))

    # Prediction

    def _bent(self, d: TipData, values: Point) -> tuple[Body, Array]:
        """The body with some values, and the joint angles (n, joints) that its tip shows."""
        core = self._core(d, values)
        zeros = np.array([values.get((ZERO, c), 0.0) for c in range(len(self.arm.joints))])
        return changed(self.arm.body, core.geometry), d.theta + core.bent + zeros

    def _core(self, d: TipData, values: Point) -> Core:
        core, none = core_of(self.arm.body), np.empty(0)
        blocks = bound({k: v for k, v in values.items() if k[0] not in NAMELESS}, len(self.arm.joints))
        load = d.load if any("weight" in block.needs for block in blocks) else none
        speeds = d.speed if any(block.regime == "high_speed" for block in blocks) else none
        now = Now(
            d.stamp, none, d.theta, speeds, load, d.theta, d.theta, self.arm.joints, none, speeds=speeds
        )
        for block in blocks:
            block.adjust(core, now)
        return core

    def residual(self, values: Point) -> list[Array]:
        """(n, signals) measured less predicted, one a recording."""
        return [self._off(d, values) for d in self.data]

    def _off(self, d: TipData, values: Point) -> Array:
        body, theta = self._bent(d, values)
        shift = [values.get((SHIFT, k), 0.0) for k in range(len(self.signals))]
        return np.asarray(d.off(body.poses(theta))[:, self.rows] - shift)

    def linearise(self, values: Point) -> None:
        """Take residuals and slopes from these values on."""
        self.origin = dict(values)
        parts = []
        for d in self.data:
            body, theta = self._bent(d, values)
            slopes = Slopes(body, theta)
            rows = np.stack([self._slope(slopes, d, key) for key in self.candidates], axis=2)
            moved = np.array([values.get(k, 0.0) - self.known.get(k, 0.0) for k in self.candidates])
            parts.append((self._off(d, values) + rows @ moved, rows))
        rest, slope = (np.concatenate(each) for each in zip(*parts, strict=True))
        self.linear = Linear(rest, slope, np.array([self._step(key) for key in self.candidates]))
        self._normals.clear()
        self._scores.clear()

    def _slope(self, slopes: Slopes, d: TipData, key: Key) -> Array:
        """(n, signals) per unit of a value."""
        name, c = key
        if name == SHIFT:
            return np.tile(np.eye(len(self.signals))[c], (len(d.stamp), 1))
        if name == ZERO:
            return slopes.jacobian[:, self.rows, c]
        return slopes.of(self._core(d, {key: 1.0}))[:, self.rows]

    def _step(self, key: Key) -> float:
        if key[0] in NAMELESS:
            return SMALL["rad" if key[0] == ZERO else UNITS[self.signals[key[1]]]]
        return parameter_of(key).typical

    # Fit

    def normal(self, keep: np.ndarray | None = None) -> Normal:
        """Normal equations of all poses, or of some (count,)."""
        keep = np.ones(self.count, dtype=bool) if keep is None else keep
        key = keep.tobytes()
        if key not in self._normals:
            self._normals[key] = self.linear.normal(self.noise, keep)
        return self._normals[key]

    def solve(self, keys: list[Key], keep: np.ndarray | None = None) -> tuple[Point, Array, float]:
        """Values, those of ``keys`` fitted and the others as the model has them; the covariance of the
        fitted ones, and the squares left.
        """
        chosen = [self._column[key] for key in keys]
        more, covariance, cost = self.normal(keep).solve(chosen)
        fitted = {k: self.known.get(k, 0.0) + float(v) for k, v in zip(keys, more, strict=True)}
        return {**self.known, **fitted}, covariance, cost

    @property
    def _column(self) -> dict[Key, int]:
        return {key: column for column, key in enumerate(self.candidates)}

    def _free(self) -> Point:
        """All values as the data have them together, whatever is told apart."""
        values = self.known
        for _ in range(TURNS):
            self.linearise(values)
            before, values = values, self.solve(self.candidates)[0]
            if self._moved(before, values) < GAINED:
                break
        return values

    def _moved(self, before: Point, after: Point) -> float:
        """Squares of unit noise that the prediction has changed by."""
        step = np.array([after.get(k, 0.0) - before.get(k, 0.0) for k in self.candidates]) / self.linear.step
        return float(step @ self.normal().curvature @ step)

    def run(self) -> ArmFit:
        """What pays, with spreads."""
        keys: list[Key] = []
        for _ in range(TURNS):
            before, keys = self.origin, self._chosen()
            values, covariance, cost = self.solve(keys)
            if self._moved(before, values) < GAINED:
                break
            self.linearise(values)
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
        """Add, leave out, put one in the place of another, or do with one cause fewer, while it pays."""
        keys: list[Key] = []
        while better := next((k for k in self._steps(keys) if self.score(k) < self.score(keys)), None):
            keys = better
        return keys

    def _steps(self, keys: list[Key]) -> Iterator[list[Key]]:
        """The best of each kind of change."""
        others = [k for k in self.candidates if k not in keys and k not in self.told_otherwise]
        fewer = [[x for x in keys if x != k] for k in keys]
        yield self._best([[*keys, k] for k in others] + fewer)
        yield self._best([[*rest, k] for rest in fewer for k in others])
        yield self._best([*self._merged(keys)])

    def _merged(self, keys: list[Key]) -> Iterator[list[Key]]:
        """One cause fewer: what another one that is there can do in its place, value by value."""
        for gone, other in permutations(dict.fromkeys(map(owner, keys)), 2):
            found = [k for k in keys if owner(k) != gone]
            free = [k for k in self.candidates if owner(k) == other and k not in self.told_otherwise]
            while more := [[*found, k] for k in free if k not in found]:
                found = self._best(more)
                if self.score(found) >= self.score(found[:-1]):
                    break
                yield found

    def _best(self, trials: list[list[Key]]) -> list[Key]:
        return min(trials, key=self.score, default=[])

    def held_out(self, keys: list[Key]) -> Array:
        """(n, signals) residuals of all recordings, each half of the blocks predicted by a fit to the other
        half.
        """
        folds = np.concatenate([fold_of(len(d.stamp)) for d in self.data])
        parts = [np.concatenate(self.residual(self.solve(keys, folds != half)[0])) for half in (0, 1)]
        return np.where((folds == 0)[:, None], *parts)
