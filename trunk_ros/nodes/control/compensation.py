"""The model run backward, tamed: no jumps, no chatter, nothing that the servo cannot do."""

from __future__ import annotations

import math

import numpy as np

from trunk_ros.chain import Chain, State
from trunk_ros.model import Model
from trunk_ros.nodes.bus import between, gearbox_limits, within
from trunk_ros.nodes.control.lead import Lead
from trunk_ros.trajectory import Array

NUDGE = 1e-4  # rad, tells a new model in which direction a joint came
FADE = 0.3  # s in which a difference at the start or at a change of model fades out


class Compensation:
    """Reference (joint angle) to setpoint (gearbox angle), all (joints,) rad, one call per control period."""

    def __init__(self, model: Model, reversal: float, position: Array | None = None):
        """``reversal``: rad that a reference must turn back before that counts as a change of direction.

        ``position``: gearbox angle that the motors hold, the first setpoint. None: start at the reference.
        """
        self.reversal = reversal
        self.out: Array | None = None
        self._lead: Lead | None = None
        self._fresh = True
        self._time = 0.0
        self._use(model)
        self._led = self._fade
        self.limited = np.zeros(len(model.arm.joints), dtype=bool)
        if position is not None:
            self._begin(position.copy())

    def _begin(self, at: Array) -> Lead:
        """The motors stand ``at`` (joints,) rad."""
        self._aim = self.out = at
        self._lead = Lead(at, *self._servo)
        return self._lead

    def _use(self, model: Model) -> None:
        self.model = model
        self.chain = Chain(model, "wire", hold_time=True)
        self.lower, self.upper = gearbox_limits(model.arm)
        self.tops, self.gain = model.at_end().top_speeds, position_gain(model)
        self._asked = np.minimum(self.tops, model.arm.v_max)  # what it is told to stay below
        ends = model.at_end()
        tau_v, fed, delay = (ends.number(name) for name in ("tau_v", "feedforward", "delay"))
        self._servo = self.gain, tau_v, self.tops, fed, model.arm.ahead, delay, ends.ki
        if self._lead is not None:
            self._lead.use(*self._servo)
        self._state: State | None = None
        self._fade = np.zeros(len(model.arm.joints))

    def swap(self, model: Model) -> None:
        """Change the model; the setpoint goes over to the new one's smoothly, direction is remembered."""
        began = self._state is not None
        self._use(model)
        self._fresh = True
        if began:
            for angle in (self._held - NUDGE * self._direction, self._held):
                (wanted,), self._state = self.chain.invert(angle[None], np.array([self._time]), self._state)
            self._fade, self._fresh = self._aim - self._led - wanted, False

    def joint_angle(self, gearbox: Array) -> Array:
        """Where the model believes the joints stand after a start at ``gearbox``, memory at its centre."""
        shown, _ = self.chain.run(gearbox[None], np.zeros(1))
        return np.clip(shown[0], self.model.arm.lower, self.model.arm.upper)

    @property
    def sight(self) -> float:
        """s from now for which a reference with derivatives is taken."""
        return 0.0 if self._lead is None else self._lead.sight

    def step(
        self, reference: Array, dt: float, velocity: Array | None = None, acceleration: Array | None = None
    ) -> Array:
        """The setpoint for ``dt`` s after the last one; of a reference whose derivatives (joints,) are known,
        in ``sight``, the servo's lag is made up for. ``limited`` tells which joints a limit held back.
        """
        if dt == 0.0 and self._state is not None and self.out is not None:
            return self.out  # no time has passed for a motor to have a speed
        wanted, asked = self.ideal(reference, dt), self.model.arm.asked
        lead = self._lead or self._begin(np.clip(wanted, self.lower, self.upper))
        lead.elapse(dt)
        assert self.out is not None
        if led := velocity is not None and acceleration is not None:
            self._led = lead.ahead(asked(velocity), asked(acceleration))
        else:
            self._led = np.zeros_like(wanted)
        if self._fresh:
            self._fade, self._fresh = self._aim - self._led - wanted, False
        else:
            self._fade = self._fade * math.exp(-dt / FADE)
        target = wanted + self._led + self._fade
        self._aim = self._towards(target, self._aim, dt)
        goes = lead.setpoint(self._aim) if led else lead.follow(self._aim)
        self.out = lead.sent(self._towards(goes, self.out, dt))
        self.limited = self._clipped | self._moved(np.abs(self._aim - target) + np.abs(self.out - goes))
        return self.out

    def _moved(self, back: Array) -> Array:
        """Which joints are moved by motors that are held ``back`` (joints,) rad."""
        coupling = self.model.arm.coupling
        return np.asarray((back if coupling is None else np.abs(coupling) @ back) > 1e-12)

    def _towards(self, target: Array, last: Array, dt: float) -> Array:
        """The next of ``last`` (joints,) rad: no faster than its servo, and within the limits."""
        up, down = self._asked
        there = last + between(between(target, self.lower, self.upper) - last, -down * dt, up * dt)
        return within(there, self.model.arm)

    def ideal(self, reference: Array, dt: float) -> Array:
        """What the inverse alone asks for, with memory of direction."""
        arm = self.model.arm
        self._time += dt
        allowed = between(reference, arm.lower, arm.upper)
        self._clipped = allowed != reference
        steady = self._steady(allowed)
        (wanted,), self._state = self.chain.invert(steady[None], np.array([self._time]), self._state)
        return wanted

    def _steady(self, reference: Array) -> Array:
        """The reference without turns below ``reversal``, which would make the dead band's inverse swing."""
        if self._state is None:
            self._held, self._direction = reference.copy(), np.zeros_like(reference)
            return self._held
        step = reference - self._held
        passes = (step * self._direction >= 0) | (np.abs(step) > self.reversal)
        self._direction = np.where(passes & (step != 0), np.sign(step), self._direction)
        self._held = np.where(passes, reference, self._held)
        return self._held


def position_gain(model: Model) -> Array:
    """Gain of the position loop [1/s] per joint, with what was found."""
    return np.asarray(model.at_end().number("kp") * np.ones(len(model.arm.joints)))
