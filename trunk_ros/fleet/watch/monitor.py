"""An arm against its model as its samples come: what leaves its usual range, where, since when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.noise import noise_of
from trunk_ros.fleet.watch.detector import Detector
from trunk_ros.fleet.watch.regimes import REGIMES, SCATTER, Motion
from trunk_ros.fleet.watch.streams import Piece, Stage
from trunk_ros.model import Model

WEEK = 604_800.0  # s
LOOK = 0.5  # s between two looks
BLOCK = 50.0  # weight that makes one number of a test
NOISE = 1000  # samples that tell the noise
TOLERATED = 1.0  # noise that a mean may change by and be usual still
GLITCH = 8.0  # noise that one sample counts for at most: a sensor's glitch is no change
EXPLAINS = 0.4  # of the power that the residual grew by
COUNT = 2 * np.pi / 2**17 / np.sqrt(12.0)  # rad: noise is no less than an encoder's


@dataclass(frozen=True)
class Change:
    """What has left its usual range. ``size`` in ``unit`` (rad, or 1 for scatter: times the noise's power);
    ``since`` and ``seen`` [s of the samples' stamps]; ``evidence``: logarithm of the e-value.
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

    @property
    def statement(self) -> str:
        """In words."""
        if self.regime == "scatter":
            return (
                f"{self.stage}, {self.joint}: the residual scatters {self.size:+.1f} times its noise's power"
            )
        times = abs(self.size) / self.noise
        return (
            f"{self.stage}, {self.joint}: the residual has left its usual range ({self.regime}): "
            f"{self.size * 1e3:+.3g} mrad, {times:.1f} times the noise"
        )


class Watched:
    """One stage: its joints times regimes are the tests."""

    def __init__(self, model: Model, name: str, alpha: float):
        joints = len(model.arm.joints)
        self.name, self.joints = name, model.arm.joints
        self.stage = Stage(model, name)
        self.motion = Motion(np.zeros(joints))
        self.detector = Detector(joints * len(REGIMES), alpha, TOLERATED, 1.0 / np.sqrt(BLOCK))
        self.noise = np.full(joints, np.nan)
        self._first: list[Piece] = []
        self._sum, self._weight = np.zeros((joints, len(REGIMES))), np.zeros((joints, len(REGIMES)))
        self._begun = np.full((joints, len(REGIMES)), np.nan)

    @property
    def ready(self) -> float:
        """Share of the tests that know what is usual."""
        return float(np.mean(self.detector.learnt))

    def restart(self) -> None:
        """Time jumped: the memory of the motion is lost, what is usual is not."""
        self.stage.restart()
        self._sum[:] = self._weight[:] = 0.0

    def look(self) -> list[Change]:
        """What the samples since the last look show."""
        piece = self.stage.piece(LOOK)
        if piece is None:
            return []
        if np.isnan(self.noise).any():
            self._learn_noise(piece)
            return []
        return self._tested(piece)

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
        z = np.clip(piece.residual / self.noise, -GLITCH, GLITCH)
        weights = self.motion.weights(piece.angle, piece.speed) * piece.valid[:, :, None]
        fresh = self._weight == 0.0
        self._begun[fresh] = piece.stamp[0]
        self._sum[:, :SCATTER] += np.einsum("nj,njk->jk", z, weights)
        self._weight[:, :SCATTER] += np.einsum("njk,njk->jk", weights, weights)
        self._sum[:, SCATTER] += (z**2).sum(axis=0)
        self._weight[:, SCATTER] += piece.valid.sum(axis=0)
        full = self._weight >= BLOCK
        number = self._sum / np.maximum(self._weight, 1e-12)
        passed = self.detector.update(number.ravel(), full.ravel(), self._begun.ravel())
        found = self._changes(passed.reshape(full.shape), number, float(piece.stamp[-1]))
        self._sum[full] = self._weight[full] = 0.0
        return found

    def _named(self, j: int, off: Array, surest: int) -> int:
        """The regime that a joint's change is told by: the surest, but scatter only where no other explains
        what it grew by.
        """
        power = (off**2 * self._weight[j])[:SCATTER]
        most = int(np.argmax(power))
        grown = off[SCATTER] * self._weight[j, SCATTER]
        return most if surest == SCATTER and power[most] > EXPLAINS * grown else surest

    def _changes(self, passed: np.ndarray, number: Array, seen: float) -> list[Change]:
        """One change per joint; the joint then learns anew."""
        evidence = self.detector.mixed().reshape(passed.shape)
        off = number - self.detector.mean.reshape(passed.shape)
        out = []
        for j in np.flatnonzero(passed.any(axis=1)).tolist():
            surest = int(np.argmax(np.where(passed[j], evidence[j], -np.inf)))
            k = self._named(j, off[j], surest)
            scale, unit = (1.0, "1") if k == SCATTER else (float(self.noise[j]), "rad")
            since = self.detector.begun(j * len(REGIMES) + surest)
            place = (self.name, self.joints[j], REGIMES[k], scale * float(off[j, k]), float(self.noise[j]))
            out.append(Change(*place, unit, since, seen, float(evidence[j, surest])))
            again = np.zeros(passed.shape, dtype=bool)
            again[j] = True
            self.detector.forget(again.ravel())
        return out


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

    def restart(self) -> None:
        """Time jumped."""
        self.wire.restart()
        self.servo.restart()

    @property
    def learnt(self) -> dict[str, float]:
        """Share of the tests of each stage that know what is usual."""
        return {"wire": self.wire.ready, "servo": self.servo.ready}
