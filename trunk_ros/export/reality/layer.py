"""A layer around a simulator: it adds what the simulator lacks, for one arm or for thousands at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError
from trunk_ros.export.missing import missing
from trunk_ros.export.reality.scene import Scene
from trunk_ros.export.reality.servo import Servo
from trunk_ros.export.reality.wire import wire_of
from trunk_ros.model import Model, load_model

OF_THE_LOOP = {
    "acceleration_limit": "limit it in the simulator: no command before its servos does",
    "integral_action": "give the simulator's servos an integral part: no command before them is one",
    "speed_integral": "give the loops of the simulator's speeds an integral part: no command is one",
}


class RealityLayer:
    """Commands go to the simulator through ``step``, and its joint states come back through it.

    ::

        layer = RealityLayer("verdict/model.yaml", environments=4096, simulation="verdict/simulation.yaml")
        command, shown = layer.step(command, state, dt)     # (4096, joints) each

    What is between setpoint and motor (servo) and between motor and joint (wire) changes the command, so that
    the simulator's links are where the arm's are; what is the sensors' changes the state that is shown.
    """

    def __init__(
        self,
        model: Model | str | Path,
        environments: int = 1,
        simulation: Model | str | Path | None = None,
        lag: float | ArrayLike = 0.0,
    ):
        """``model``: the arm. ``simulation``: what the simulator has of it already (``simulation.yaml`` of
        ``diagnose --against``); by default its ratios and nothing else. ``lag`` [s], (joints,) or one: how
        far the simulator's own position loop is behind a steady command (damping over stiffness of a PD
        loop).

        Raises ModelError where the model names no joints.
        """
        arm, theirs = _model(model), None if simulation is None else _model(simulation)
        if arm.any_joints:
            raise ModelError("the reality layer wants a model with joints: one that diagnose has written")
        if environments < 1:
            raise ModelError(f"{environments} environments: give 1 or more")
        lacking = missing(arm, theirs)
        self.model = lacking.model
        """What is added."""
        unable = [f"{e}: {OF_THE_LOOP[e]}" for e in lacking.model.effects if e in OF_THE_LOOP]
        self.remarks = (*lacking.remarks, *unable)
        """What cannot be."""
        self.joints = arm.arm.joints
        self._shape = environments, len(self.joints)
        self._lag = np.maximum(np.broadcast_to(np.asarray(lag, dtype=float), len(self.joints)), 1e-9)
        self._lags = bool(np.any(np.asarray(lag) > 0.0))
        self._anew: np.ndarray | None = None
        self.reset()

    def reset(self, which: ArrayLike | None = None) -> None:
        """Begin anew with the next step: all environments, or those ``which`` (environments,) says."""
        if which is None:
            self._begin()
        elif self._gearbox is not None:
            asked = np.asarray(which, dtype=bool)
            self._anew = asked if self._anew is None else self._anew | asked

    def _begin(self) -> None:
        environments = self._shape[0]
        self._servo, self._wire = Servo(self.model, environments), wire_of(self.model, environments)
        self._arm, self._time = self.model.loaded_arm(), 0.0
        self._gearbox: Array | None = None
        self._theta: Array = np.empty(0)
        self._speed: Array = np.empty(0)
        self._anew = None

    def step(self, command: ArrayLike, state: ArrayLike, dt: float) -> tuple[Array, Array]:
        """What to command the simulator for the next ``dt`` s, and what the joints' sensors show now.

        ``command``: setpoints [rad, motor side]; ``state``: the simulator's joint angles now [rad]. Both
        (environments, joints), or (joints,) for one. Raises ModelError for other shapes, and for what is no
        number.
        """
        asked, true = self._given(command, "command"), self._given(state, "state")
        anew, self._anew = self._anew, None
        self._time += dt
        before = self._gearbox = self._started(asked, anew)
        arm, held = self._arm, self.model.duration
        decay = np.exp(-dt / self._lag) if self._lags else None
        here = Scene(arm, held, dt, before, true, self._speed if self._speed.size else 0.0 * true)
        gearbox = self._servo.step(asked, here, self._time, anew)
        if decay is not None:
            gearbox = gearbox + decay * (before - gearbox)
        moved = (gearbox - before) * arm.ratio
        speed = moved / dt if dt > 0.0 else 0.0 * moved
        scene = Scene(arm, held, dt, gearbox, true + moved, speed)
        clock = Scene(arm, self._time, dt, gearbox, true, speed)
        theta = sent = self._wire.drive(scene, clock, anew)
        if decay is not None:
            sent = self._ahead(theta, decay, anew)
        self._gearbox, self._speed, form = gearbox, speed, np.shape(command)
        shown = self._wire.show(true, scene, clock, anew)
        return (sent / arm.ratio).reshape(form), shown.reshape(form)

    def _started(self, asked: Array, anew: np.ndarray | None) -> Array:
        """Gearbox angles (environments, joints) before this step; at their command where they begin."""
        if self._gearbox is None:
            self._theta = np.empty(0)
            return asked.copy()
        return self._gearbox if anew is None else np.where(anew[:, None], asked, self._gearbox)

    def _ahead(self, theta: Array, decay: Array, anew: np.ndarray | None) -> Array:
        """What a loop that is behind by the lag has to be told to be at ``theta`` after this step."""
        before = self._theta if self._theta.size else theta
        if anew is not None:
            before = np.where(anew[:, None], theta, before)
        self._theta = theta
        return np.asarray(theta + decay / (1.0 - decay) * (theta - before))

    def _given(self, values: ArrayLike, name: str) -> Array:
        """(environments, joints) of what was given."""
        array = np.asarray(values, dtype=float)
        if array.size != self._shape[0] * self._shape[1] or array.shape[-1:] != self._shape[1:]:
            wanted = f"{self._shape[0]} environments of {', '.join(self.joints)}"
            raise ModelError(f"{name} has the shape {array.shape}: it must be for {wanted}")
        array = np.ascontiguousarray(array.reshape(self._shape))
        if not np.isfinite(array).all():
            place, joint = np.argwhere(~np.isfinite(array))[0]
            raise ModelError(f"{name} of {self.joints[joint]} in environment {place} is no number")
        return array


def _model(given: Model | str | Path) -> Model:
    return given if isinstance(given, Model) else load_model(given)
