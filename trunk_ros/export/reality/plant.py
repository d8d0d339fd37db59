"""The arm that a model describes, run tick by tick, for one environment or for thousands at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from trunk_ros.arm.arm import SERVO_OF_EACH, STEP
from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array, compiled
from trunk_ros.effects import effect
from trunk_ros.effects.servo.loop import CLOSE
from trunk_ros.effects.servo.speed import held_back, rise, towards
from trunk_ros.effects.servo.summed import gathered, summed_up
from trunk_ros.errors import ModelError
from trunk_ros.export.missing import missing
from trunk_ros.export.reality.scene import Scene
from trunk_ros.export.reality.servo import Servo
from trunk_ros.export.reality.wire import Wire


class Plant:
    """Setpoints in, joint readings out: servo, wire and sensors of a model, without a simulator.

    ::

        plant = load_model("verdict/model.yaml").plant(environments=1024)
        reading = plant.reset()                 # (1024, joints) rad
        reading = plant.step(setpoints, 0.01)   # what the sensors show 0.01 s later
    """

    _gearbox: Array
    _velocity: Array
    _total: Array
    _theta: Array
    _anew: np.ndarray

    def __init__(self, model: ArmModel, environments: int = 1):
        """Raises ModelError where the model names no joints, has motors that move several joints, or an
        effect that cannot act on many environments.
        """
        if model.any_joints:
            raise ModelError("a plant wants a model with joints: one that diagnose has written, or an arm's")
        if model.arm.coupling is not None:
            raise ModelError("wire.coupling: a plant of motors that move several joints is not there yet")
        if environments < 1:
            raise ModelError(f"{environments} environments: give 1 or more")
        # No command that is shaped beforehand has a loop at its top speed go as one with other numbers.
        own = model.at_end().with_numbers(SERVO_OF_EACH)
        self._tops = own.top_speeds
        beside = {
            name: values for name, values in own.effects.items() if effect(name).changes != "top_speeds"
        }
        self.model, self.joints = missing(replace(own, effects=beside)).model, model.arm.joints
        self._shape = environments, len(self.joints)
        self._push: Array = np.zeros(self._shape)
        self.reset()

    @property
    def motors(self) -> Array:
        """(environments, joints) motor-side angles now [rad]."""
        return self._gearbox.copy()

    def reset(self, which: ArrayLike | None = None, posture: ArrayLike = 0.0) -> Array:
        """Joint readings (environments, joints) [rad] of arms that stand at ``posture`` [rad, joint side,
        (joints,) or (environments, joints)]: all, or those ``which`` (environments,) says.

        Wires lie in the centre of their backlash, and effects of time begin anew where all are reset.
        """
        stands = np.broadcast_to(np.asarray(posture, dtype=float), self._shape)
        chosen = np.ones(self._shape[0], bool) if which is None else np.asarray(which, dtype=bool)
        if which is None:
            self._begin()
        else:
            self._anew = self._anew | chosen
        self._gearbox = np.where(chosen[:, None], stands / self.model.arm.ratio, self._gearbox)
        self._velocity = np.where(chosen[:, None], 0.0, self._velocity)
        self._total = np.where(chosen[:, None], np.nan, self._total)
        self._push = np.where(chosen[:, None], 0.0, self._push)
        self._theta = np.where(chosen[:, None], stands, self._theta)
        return self._theta.copy()

    def _begin(self) -> None:
        environments = self._shape[0]
        self._servo, self._wire = Servo(self.model, environments, True), Wire(self.model, environments)
        self._arm, self._time = self.model.loaded_arm(), 0.0
        tops = np.where(self._servo.ramp[: self._shape[1]] < np.inf, np.inf, self._tops)
        self._loop = [np.full(self._shape[1], n) for n in (self._arm.kp, self._arm.tau_v, *tops)]
        self._gearbox, self._velocity, self._theta = (np.zeros(self._shape) for _ in range(3))
        self._push = np.zeros(self._shape)
        self._total = np.full(self._shape, np.nan)
        self._anew = np.zeros(environments, bool)

    def step(self, setpoints: ArrayLike, dt: float) -> Array:
        """Joint readings (environments, joints) [rad] after ``dt`` s under ``setpoints`` [rad, motor side].

        Both have the shape (joints,) for one environment as well. Raises ModelError for other shapes.
        """
        asked, before = self._given(setpoints), self._gearbox
        anew, self._anew = (self._anew if self._anew.any() else None), np.zeros(self._shape[0], bool)
        speed = self._velocity * self._arm.ratio
        here = Scene(self._arm, self.model.duration, dt, before, self._theta, speed)
        wanted = self._servo.step(asked, here, self._time, anew)
        gearbox, velocity = before.copy(), self._velocity.copy()
        arm = self._arm
        kp, tau_v, up, down = self._loop
        servo = self._servo
        limits = np.stack([servo.hardest, servo.dry, servo.windup, servo.speed_ki])
        beside, sums = servo.beside.reshape(self._shape), (self._push, self._total)
        ki = np.ascontiguousarray(servo.ki)
        follow(wanted, beside, dt, kp, tau_v, up, down, limits, ki, arm.ahead, gearbox, velocity, *sums)
        self._time += dt
        theta = self._theta + (gearbox - before) * arm.ratio
        now = Scene(arm, self.model.duration, dt, gearbox, theta, velocity * arm.ratio)
        clock = Scene(arm, self._time, dt, gearbox, theta, velocity * arm.ratio)
        self._gearbox, self._velocity = gearbox, velocity
        self._theta = self._wire.drive(now, clock, anew)
        shown = self._wire.show(self._theta, now, clock, anew)
        return np.asarray(shown.reshape(np.shape(setpoints)))

    def _given(self, setpoints: ArrayLike) -> Array:
        array = np.asarray(setpoints, dtype=float)
        if array.size != self._shape[0] * self._shape[1] or array.shape[-1:] != self._shape[1:]:
            wanted = f"{self._shape[0]} environments of {', '.join(self.joints)}"
            raise ModelError(f"setpoints have the shape {array.shape}: they must be for {wanted}")
        return np.ascontiguousarray(array.reshape(self._shape))


@compiled
def follow(
    setpoints: Array,
    beside: Array,
    dt: float,
    kp: Array,
    tau_v: Array,
    up: Array,
    down: Array,
    limits: Array,
    ki: Array,
    ahead: float,
    gearbox: Array,
    velocity: Array,
    push: Array,
    total: Array,
) -> None:
    """Move motor-side angles and velocities (environments, joints) by ``dt`` s under setpoints, in place, by
    servos with these numbers (joints,), ``up`` and ``down`` being top speeds; ``limits`` (4, joints), ``ki``,
    ``push``, ``total``, ``ahead`` and ``beside`` as in ``servo_loop``.
    """
    hardest, dry, windup, restores = limits[0], limits[1], limits[2], limits[3]
    for j in range(setpoints.shape[1]):
        steps = max(int(np.ceil(dt / min(STEP, CLOSE / kp[j]) - 1e-9)), 1)
        h = dt / steps
        smooth = rise(h, tau_v[j], ahead)
        for e in range(setpoints.shape[0]):
            used = 0.0
            if ki[j] != 0.0 and total[e, j] != total[e, j]:
                total[e, j] = -kp[j] * beside[e, j]  # it stood at its setpoint and bore its load
            for _ in range(steps):
                before = velocity[e, j]
                error = setpoints[e, j] - (gearbox[e, j] + ahead * h * before)
                if ki[j] != 0.0:
                    own = h * ki[j] * (error - beside[e, j])
                    used = total[e, j] + ahead * own
                    below, above = -down[j] - used, up[j] - used
                    least, most = below - windup[j], above + windup[j]
                    total[e, j] = summed_up(total[e, j], own, kp[j] * error, least, most)
                wanted = min(max(kp[j] * error, -down[j] - used), up[j] - used) + used
                after = towards(before, before + smooth * (wanted + push[e, j] - before), hardest[j] * h)
                velocity[e, j] = held_back(after, smooth * kp[j] * dry[j])
                meant = velocity[e, j] + ahead * (before - velocity[e, j])
                if restores[j] != 0.0:
                    off, change = h * restores[j] * (wanted - meant), velocity[e, j] - before
                    push[e, j] += gathered(off, change, hardest[j] * h)
                gearbox[e, j] += h * meant
