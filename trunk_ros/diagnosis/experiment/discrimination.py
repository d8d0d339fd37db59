"""How far apart a motion brings a hypothesis and a rival of it that is refitted to that motion as well."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.data.align import servo_span, wire_span
from trunk_ros.data.noise import rms
from trunk_ros.data.span import Span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis, bounds
from trunk_ros.diagnosis.search.fit import ROUNDS, groups, minimise
from trunk_ros.diagnosis.search.residuals import Residuals
from trunk_ros.diagnosis.search.score import need
from trunk_ros.guards import BLIND, ROUNDED
from trunk_ros.levels import CLEARLY, TENFOLD
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.resample import SLOW
from trunk_ros.trajectory import Trajectory

CONTROL = 0.01  # s between setpoints, as bringup gives them


@dataclass
class Difference:
    """What is left between a hypothesis and its refitted rival where it shows most.

    ``time`` s, ``angle`` rad and ``speed`` rad/s of the joint, ``gap`` rad, ``noise`` rad; ``rms`` in units
    of the noise. ``ratio``: squared unit-noise misfit over what it takes to rule the rival out.
    """

    column: int
    time: float
    angle: float
    speed: float
    gap: float
    noise: float
    rms: float
    ratio: float

    @property
    def decides(self) -> bool:
        """Whether it rules the rival out."""
        return self.ratio >= CLEARLY


class Pinned(Residuals):
    """Residuals on a new motion; the values are held as firmly as earlier recordings hold them."""

    def __init__(self, there: Context, earlier: Residuals, normal: Array):
        """``normal`` (free, free): curvature of half the cost of the ``earlier`` recordings. What they free
        is free, also where the new motion hardly moves a joint that shares it.
        """
        super().__init__(there, earlier.hypothesis, earlier.columns)
        self.free, self.scale, self.turn = earlier.free, earlier.scale, earlier.turn
        self.at = np.clip(self.hypothesis.free_values(self.free), *bounds(self.free))
        values, directions = np.linalg.eigh(normal)
        self.root = np.sqrt(np.maximum(values, 0.0))[:, None] * directions.T

    def __call__(self, x: Array) -> Array:
        return np.concatenate([super().__call__(x), self.root @ (x - self.at)])

    def jacobian(self, x: Array) -> Array:
        return np.vstack([super().jacobian(x), self.root])

    def normal(self, x: Array) -> tuple[Array, Array]:
        return self._held(super().normal(x), self.root, x)

    def normal_about(self, x: Array) -> tuple[Array, Array]:
        return self._held(super().normal_about(x), self.root @ self.turned(np.eye(len(x))), x)

    def _held(self, free: tuple[Array, Array], root: Array, x: Array) -> tuple[Array, Array]:
        side, square = free
        return side + root.T @ (self.root @ (x - self.at)), square + root.T @ root

    def unfitted(self) -> float:
        """Squared misfit with the values as they are."""
        rest = self(self.at)
        return float(rest @ rest)

    def linear(self) -> float:
        """Squared misfit after one step of a refit."""
        rest = self(self.at)
        if not self.free:
            return float(rest @ rest)
        jacobian = self.jacobian(self.at)
        size = np.linalg.norm(jacobian, axis=0)
        scaled = jacobian[:, size > BLIND] / size[size > BLIND]
        slope = scaled.T @ rest
        step = np.linalg.solve(scaled.T @ scaled + ROUNDED * np.eye(len(slope)), slope)
        return max(float(rest @ rest - slope @ step), 0.0)

    def refitted(self) -> tuple[float, Hypothesis]:
        """Squared misfit after a full refit, and the values there."""
        x = minimise(self, self.at, ROUNDS) if self.free else self.at
        rest = self(x)
        return float(rest @ rest), self.hypothesis.put(self.free, x)


@dataclass
class Other:
    """A rival in one form, fitted to the recordings at hand."""

    context: Context
    hypothesis: Hypothesis
    loss: float
    """By how much it explains them worse, in squared unit noise."""

    @cached_property
    def groups(self) -> list[tuple[Residuals, Array]]:
        """What is refitted together, with how firmly the recordings at hand hold its values."""
        context, out = self.context.seen_with(self.hypothesis), []
        for group in groups(context, self.hypothesis):
            residuals = Residuals(context, self.hypothesis, group)
            x = np.clip(self.hypothesis.free_values(residuals.free), *bounds(residuals.free))
            out.append((residuals, residuals.normal(x)[1]))
        return out

    def pinned(self, there: Context, columns: list[int]) -> list[Pinned]:
        """The rival on an expected recording, by groups of joints."""
        return [Pinned(there, one, normal) for one, normal in self.groups if set(one.columns) & set(columns)]

    def refitted(self, there: Context, columns: list[int]) -> tuple[float, Hypothesis]:
        """Squared misfit after a full refit in the joint angles that it predicts itself, and the values
        there.
        """
        misfit, fitted, there = 0.0, self.hypothesis, there.seen_with(self.hypothesis)
        for pinned in self.pinned(there, columns):
            cost, values = pinned.refitted()
            misfit += cost
            for column in pinned.columns:
                fitted = _with(fitted, column, values)
        return misfit, fitted


@dataclass
class Duel:
    """An effect taken for the truth, and another one in its place that explains the recordings as well."""

    truth: str
    other: str
    true: Other
    """With the truth."""
    others: list[Other]
    """With the other, in the forms that explain the recordings as well."""

    @property
    def base(self) -> Hypothesis:
        """The hypothesis with the truth."""
        return self.true.hypothesis

    @cached_property
    def columns(self) -> list[int]:
        """Joints on which the two differ."""
        best = self.others[0]
        return [c for c in best.context.columns if self.base.key(c) != best.hypothesis.key(c)]

    def ratio(self, there: Context) -> float:
        """Squared misfit of the other on an expected recording over what it takes to rule it out, in the
        joint angles that the truth predicts.
        """
        return min(self._ratio(there, other) for other in self.others)

    def _ratio(self, there: Context, other: Other) -> float:
        pinned, wanted = other.pinned(there, self.columns), self.wanted(there, other)
        unfitted = sum(p.unfitted() for p in pinned) / wanted  # a refit can but lower it
        return unfitted if unfitted < 1.0 / TENFOLD else sum(p.linear() for p in pinned) / wanted

    def wanted(self, there: Context, other: Other) -> float:
        """The misfit at which it is no equivalent any more, both runs taken together."""
        contexts = (other.context, there)
        each = [need(p, c) for p in contexts for c in self.base[self.truth].columns if c in self.columns]
        return max(sum(each) - (other.loss - self.true.loss), 1.0)

    def seen_in(self, context: Context, motion: Trajectory) -> Difference:
        """Where it shows most in a motion, after a full refit of each form."""
        there = expected(context, self.base, span_of(context, motion))
        fits = [(other, *other.refitted(there, self.columns)) for other in self.others]
        ratio, fitted = min(
            ((misfit / self.wanted(there, other), fitted) for other, misfit, fitted in fits),
            key=lambda one: one[0],
        )
        there = there.seen_with(fitted)
        rests = {c: there.residual(0, fitted, c) / there.noise[c].std for c in self.columns}
        column = max(rests, key=lambda c: float(np.abs(rests[c]).max()))
        row = int(np.argmax(np.abs(rests[column])))
        time, noise = float(there.views[0].span.stamp[row]), there.noise[column].std
        angle, speed, _ = motion.sample([time])
        return Difference(
            column,
            time,
            float(angle[0, column]),
            float(speed[0, column]),
            float(rests[column][row] * noise),
            noise,
            rms(rests[column]),
            ratio,
        )


def _with(hypothesis: Hypothesis, column: int, values: Hypothesis) -> Hypothesis:
    out = hypothesis.copy()
    out.take(column, values)
    for name, term in out.items():
        if column in term.own:
            term.shared = dict(values[name].shared)
    return out


def span_of(context: Context, motion: Trajectory) -> Span:
    """The motion as the stage would see it; what is measured is left at 0."""
    recording = recorded(context, motion)
    return (servo_span if context.stage.name == "servo" else wire_span)(recording, context.stage.model)


def expected(context: Context, hypothesis: Hypothesis, span: Span) -> Context:
    """The stage with what a hypothesis leads to expect in the place of what is measured, free of noise."""
    there = context.over([span]).seen_with(hypothesis)
    target = span.target.copy()
    for column in context.columns:
        target[:, column] = there.predict(0, hypothesis, column)
    return replace(there, views=(replace(there.views[0], span=replace(span, target=target)),))


def recorded(context: Context, motion: Trajectory) -> Recording:
    """Setpoints and gearbox angles of a motion by the nominal servo, at the rates of the recordings."""
    often = context.step if context.step > SLOW else min(context.step, CONTROL)
    every = max(round(context.step / often), 1)
    stamp = np.arange(0.0, motion.duration, often)
    setpoints = motion.sample(stamp)[0] / context.arm.ratio
    phi, _ = Chain(Model(context.arm), "servo").run(setpoints, stamp)
    velocity = np.gradient(phi, stamp, axis=0)
    kept = slice(None, None, every if context.stage.name == "servo" else 1)
    seen = stamp[::every]
    series = {
        "setpoints": JointSeries(stamp, context.joints, setpoints),
        "gearbox_states": JointSeries(stamp[kept], context.joints, phi[kept], velocity[kept]),
        "joint_states": JointSeries(seen, context.joints, np.zeros((len(seen), len(context.joints)))),
    }
    return Recording("experiment", 0, motion.duration, series)
