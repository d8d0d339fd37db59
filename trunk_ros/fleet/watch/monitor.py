"""An arm against its model as its samples come: what leaves its usual range, where, since when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.noise import noise_of
from trunk_ros.fleet.watch.detector import Detector
from trunk_ros.fleet.watch.looks import GLITCH, Alarm, Usual, in_words, names
from trunk_ros.fleet.watch.regimes import REGIMES, SCATTER, Motion
from trunk_ros.fleet.watch.streams import Piece, Stage
from trunk_ros.model import Model
from trunk_ros.units import sized
from trunk_ros.words import significant

WEEK = 604_800.0  # s
LOOK = 0.5  # s between two looks
BLOCK = 50.0  # weight that makes one number of a test
NOISE = 1000  # samples that tell the noise
TOLERATED = 1.0  # noise that a mean may change by and be usual still
COUNT = 2 * np.pi / 2**17 / np.sqrt(12.0)  # rad: noise is no less than an encoder's


@dataclass(frozen=True)
class Change:
    """What has left its usual range. ``size``: of the deviation where it looks like ``regime``, in ``unit``
    (that of the joint, or 1 for scatter: times the noise's power); ``rivals``: regimes that the motion does
    not tell from it; ``since`` and ``seen`` [s of the samples' stamps]; ``evidence``: logarithm of the
    e-value.
    """

    stage: str
    joint: str
    regime: str
    size: float
    noise: float
    unit: str
    since: float
    seen: float
    evidence: float
    rivals: tuple[str, ...] = ()
    position: str = "rad"
    """Unit of the joint's position."""

    @property
    def statement(self) -> str:
        """In words."""
        size, sign = self.size, "+" if self.size > 0.0 else ""
        if self.regime == "scatter":  # of which nothing but the power is known
            size, sign = np.sqrt(abs(size)) * self.noise, "" if size > 0.0 else "less by "
        said = sized(size, self.position) + (" rms" if self.regime == "scatter" else "")
        return (
            f"{self.stage}, {self.joint}: the residual has left its usual range "
            f"({in_words(self.regime, self.rivals)}): {sign}{said}, "
            f"{significant(abs(size) / self.noise, 2)} times the noise"
        )


class Watched:
    """One stage: its joints times regimes are the tests."""

    def __init__(self, model: Model, name: str, alpha: float):
        joints = len(model.arm.joints)
        self.name, self.joints, self.units = name, model.arm.joints, model.arm.units
        self.stage = Stage(model, name)
        self.motion = Motion(np.zeros(joints))
        self.detector = Detector(joints * len(REGIMES), alpha, TOLERATED, 1.0 / np.sqrt(BLOCK))
        self.noise = np.full(joints, np.nan)
        self.usual = Usual(joints)
        self.alarms: dict[int, Alarm] = {}
        """By joint: what has left its usual range, and is said once its regime shows."""
        self._said: list[Change] = []
        self._first: list[Piece] = []
        self._sum, self._weight = np.zeros((joints, len(REGIMES))), np.zeros((joints, len(REGIMES)))
        self._begun = np.full((joints, len(REGIMES)), np.nan)

    @property
    def ready(self) -> float:
        """Share of the tests that know what is usual."""
        return float(np.mean(self.detector.learnt))

    def restart(self) -> None:
        """Time jumped: the memory of the motion is lost, what is usual is not."""
        self._said += self.settle()
        self.stage.restart()
        self._sum[:] = self._weight[:] = 0.0

    def look(self) -> list[Change]:
        """What the samples since the last look show."""
        said, self._said = self._said, []
        piece = self.stage.piece(LOOK)
        if piece is None:
            return said
        if np.isnan(self.noise).any():
            self._learn_noise(piece)
            return said
        return said + self._tested(piece)

    def settle(self) -> list[Change]:
        """What has left its usual range, with what is known of it by now: no more samples come."""
        return [self._change(j) for j in list(self.alarms)]

    def _learn_noise(self, piece: Piece) -> None:
        """The noise of each joint from the residual itself, once there is enough of it."""
        self._first.append(piece)
        valid = np.concatenate([each.valid for each in self._first])
        if valid.sum(axis=0).min() < NOISE and len(valid) < 20 * NOISE:
            return
        rest = np.concatenate([each.residual for each in self._first])
        self.noise = np.array(
            [max(noise_of([rest[:, j]], [valid[:, j]], 1).std, COUNT) for j in range(len(self.joints))]
        )
        self._first.clear()

    def _tested(self, piece: Piece) -> list[Change]:
        off = piece.residual / self.noise
        z = np.clip(off, -GLITCH, GLITCH)
        weights = self.motion.weights(piece.angle, piece.speed) * piece.valid[:, :, None]
        fresh = self._weight == 0.0
        self._begun[fresh] = piece.stamp[0]
        self._sum[:, :SCATTER] += np.einsum("nj,njk->jk", z, weights)
        self._weight[:, :SCATTER] += np.einsum("njk,njk->jk", weights, weights)
        self._sum[:, SCATTER] += (z**2).sum(axis=0)
        self._weight[:, SCATTER] += piece.valid.sum(axis=0)
        full = self._weight >= BLOCK
        number = self._sum / np.maximum(self._weight, 1e-12)
        unknown = ~self.detector.learnt.reshape(full.shape)[:, :SCATTER] & weights.any(axis=0)
        self.usual.learn(off, weights, np.flatnonzero(unknown.any(axis=1)))
        passed = self.detector.update(number.ravel(), full.ravel(), self._begun.ravel())
        self._sum[full] = self._weight[full] = 0.0
        now = float(piece.stamp[-1])
        self._begin(passed.reshape(full.shape), now)
        for j, alarm in self.alarms.items():
            alarm.add(off[:, j], weights[:, j], piece.valid[:, j])
        return [self._change(j) for j, alarm in list(self.alarms.items()) if alarm.over(now)]

    def _begin(self, passed: np.ndarray, seen: float) -> None:
        """Joints whose tests pass; each then learns anew what is usual."""
        evidence = self.detector.mixed().reshape(passed.shape)
        for j in np.flatnonzero(passed.any(axis=1)).tolist():
            surest = int(np.argmax(np.where(passed[j], evidence[j], -np.inf)))
            since = self.detector.begun(j * len(REGIMES) + surest)
            scatter = float(self.detector.mean.reshape(passed.shape)[j, SCATTER])
            self.alarms[j] = Alarm(since, seen, float(evidence[j, surest]), self.usual.of(j), scatter)
            self.usual.forget(j)
            again = np.zeros(passed.shape, dtype=bool)
            again[j] = True
            self.detector.forget(again.ravel())

    def _change(self, j: int) -> Change:
        """What an alarm has come to."""
        alarm, joint, noise = self.alarms.pop(j), self.joints[j], float(self.noise[j])
        look, position = alarm.look(), self.units.get(joint, "rad")
        scale, unit = (1.0, "1") if look.regime == SCATTER else (noise, position)
        place = (self.name, joint, REGIMES[look.regime], scale * look.size, noise, unit)
        told = (alarm.since, alarm.seen, alarm.evidence, names(look.rivals), position)
        return Change(*place, *told)


class Monitor:
    """All stages of an arm. Stamps are s, rising, of one clock; samples (joints,) rad in the model's order,
    NaN where a joint is missing.
    """

    def __init__(self, model: Model, false_alarms: float = 0.1):
        """``false_alarms``: a week of motion, over all tests together."""
        joints = len(model.arm.joints)
        tests = 2 * joints * len(REGIMES)
        alpha = false_alarms / (tests * WEEK / LOOK)
        self.wire, self.servo = Watched(model, "wire", alpha), Watched(model, "servo", alpha)

    def setpoints(self, stamp: float, value: Array) -> None:
        """Gearbox angles asked of the servo, (joints,) rad, at ``stamp`` s."""
        self.servo.stage.given.add(stamp, value)

    def gearbox(self, stamp: float, value: Array) -> None:
        """Gearbox angles, (joints,) rad, at ``stamp`` s."""
        self.servo.stage.shown.add(stamp, value)
        self.wire.stage.given.add(stamp, value)

    def joint_states(self, stamp: float, value: Array) -> None:
        """Joint angles, (joints,) rad, at ``stamp`` s."""
        self.wire.stage.shown.add(stamp, value)

    def look(self) -> list[Change]:
        """What has left its usual range since the last look."""
        return [*self.wire.look(), *self.servo.look()]

    def settle(self) -> list[Change]:
        """What has left its usual range and is not yet said: no more samples come."""
        return [*self.wire.settle(), *self.servo.settle()]

    def restart(self) -> None:
        """Time jumped."""
        self.wire.restart()
        self.servo.restart()

    @property
    def learnt(self) -> dict[str, float]:
        """Share of the tests of each stage that know what is usual."""
        return {"wire": self.wire.ready, "servo": self.servo.ready}
