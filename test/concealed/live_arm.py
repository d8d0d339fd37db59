"""The concealed arm a tick at a time: the laws of the plant, with what they remember kept between ticks."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, field

import numpy as np
from scipy.signal import cont2discrete, lfilter

from test.concealed.behind import BEHIND, LOADED
from test.concealed.drive import driven
from test.concealed.friction import WIDTH
from test.concealed.hidden import Hidden
from test.concealed.nominal import COUNT, HALF_WIDTH, KP, RATIO, STEP, TAU_V, V_MAX, Array, load, play
from test.concealed.plant import Effects, payload_of
from test.concealed.scene import Scene
from test.concealed.servo import SUB

FORMS = {  # those with a law that knows no future
    "presliding_hysteresis": ("uniform", "exponential", "maxwell"),
    "friction_wear": ("straight",),
    "viscoelastic_creep": ("one_mode",),
    "viscous_lag": ("first_order",),
    "link_resonance": ("absolute_damping",),
}
ROUNDS = (
    3  # of the circle of load and coupling through the joint angles; each shrinks the error to a hundredth
)
REMEMBERED = 100  # steps of joint angle, for a late sensor


def can_be_live(h: Hidden) -> bool:
    """Whether this form of an effect is one that ``LiveArm`` plays."""
    return h.stage != "arm" and h.form in FORMS.get(h.effect, (h.form,)) and h.effect != "x_rough_patch"


@dataclass
class Sample:
    """The arm at the end of a tick, (5,) each; ``shown``: joint angle of an ideal, perhaps late, sensor."""

    phi: Array
    v: Array
    theta: Array
    shown: Array
    tau: Array


@dataclass
class _Servo:
    """The position and velocity loop of ``servo.py`` with its state."""

    hidden: Effects
    payload: float
    p: Array = field(default_factory=lambda: np.zeros(COUNT))
    v: Array = field(default_factory=lambda: np.zeros(COUNT))
    asked: list[Array] = field(default_factory=list)

    def __post_init__(self) -> None:
        own = {h.effect: h for h in self.hidden}
        nothing = Hidden("", (), "", {})
        self.kp = KP * (1 + own.get("servo_bandwidth", nothing).column("relative"))
        self.top = own.get("velocity_saturation", nothing).column("v_max", V_MAX)
        self.late = own.get("servo_delay", nothing).column("delay")[0] / STEP
        self.droop = own.get("load_droop", nothing).column("gain")
        teeth = own.get("cogging", nothing)
        self.cog, self.cycles, self.phase = map(teeth.column, ("amplitude", "cycles_per_rev", "phase"))
        self.dead = own.get("x_servo_dead_zone", nothing).column("width")

    def tick(self, setpoint: Array) -> tuple[Array, Array]:
        """Angle and speed (SUB, 5) after each of the steps in which a setpoint (5,) acts."""
        first = SUB * len(self.asked)
        self.asked.append(setpoint)
        phi, v = np.empty((SUB, COUNT)), np.empty((SUB, COUNT))
        for n in range(SUB):
            error = self._wanted(first + n) - self.p
            error = np.where(np.abs(error) < self.dead, 0.0, error)
            self.v = self.v + STEP * (np.clip(self.kp * error, -self.top, self.top) - self.v) / TAU_V
            self.p = self.p + STEP * self.v
            phi[n], v[n] = self.p, self.v
        return phi, v

    def _wanted(self, step: int) -> Array:
        whole, share = divmod(step - self.late, 1.0)
        before, after = (self.asked[max(int(whole) + n, 0) // SUB] for n in (0, 1 if share else 0))
        tau = load((RATIO * self.p)[None], self.payload)[0]
        out: Array = (1 - share) * before + share * after + self.droop * tau
        return out + self.cog * np.sin(self.cycles * self.p + self.phase)


class LiveArm:
    """The arm from rest at zero, its play at its centre."""

    def __init__(self, hidden: Effects):
        self.hidden, self.payload = hidden, payload_of(hidden)
        self.servo = _Servo(hidden, self.payload)
        self.friction = _Friction(hidden)
        self.filters = {h.effect: _Filters(h) for h in hidden if h.effect in _LAPLACE}
        self.late = max((h.parameters["delay"] for h in hidden if h.effect == "sensor_delay"), default=0.0)
        self.circle = any(h.effect in (*LOADED, "joint_coupling", "load_dependent_friction") for h in hidden)
        self.steps = 0
        self.phi = np.zeros((1, COUNT))
        self.theta = self._wire(self._scene(np.array([1e-9]), self.phi, self.phi, self.phi))
        self.past = np.repeat(self.theta, REMEMBERED, axis=0)

    def sample(self) -> Sample:
        """The arm now."""
        theta, v = self.theta[-1], self.servo.v
        return Sample(self.phi[-1], v, theta, self._shown(), load(theta[None], self.payload)[0])

    def tick(self, setpoint: Array) -> None:
        """Go on for 10 ms, in which a setpoint (5,) acts."""
        t = (self.steps + 1 + np.arange(SUB, dtype=np.float64)) * STEP
        phi, v = self.servo.tick(setpoint)
        theta = self.theta[-1] + RATIO * (phi - self.phi[-1])
        for _ in range(ROUNDS if self.circle else 0):
            kept = deepcopy((self.friction, self.filters))
            theta = self._wire(self._scene(t, phi, v, theta))
            self.friction, self.filters = kept
        self.theta = self._wire(self._scene(t, phi, v, theta))
        self.phi, self.steps = phi, self.steps + SUB
        self.past = np.vstack([self.past, self.theta])[-REMEMBERED:]

    def _scene(self, t: Array, phi: Array, v: Array, theta: Array) -> Scene:
        return Scene(t, phi, v, theta, load(theta, self.payload))

    def _wire(self, at: Scene) -> Array:
        x = self.friction.slide(at, driven(self.hidden, at))
        for name, law in BEHIND.items():
            for h in self.hidden:
                if h.effect == name:
                    x = self.filters[name].run(x) if name in self.filters else law(h, at, x)
        return x

    def _shown(self) -> Array:
        steps = np.arange(REMEMBERED) - (REMEMBERED - 1)
        out = [np.interp(-self.late / STEP, steps, column) for column in self.past.T]
        return np.array(out)


class _Friction:
    """The play, or plays side by side where the loop is rounded, with where they stand."""

    def __init__(self, hidden: Effects):
        self.hidden = hidden
        self.last = np.zeros(COUNT)
        rounded = [h for h in hidden if h.effect == "presliding_hysteresis"]
        self.loops = [
            (h, n, j, np.zeros(len(h.extra["place"]))) for h in rounded for n, j in enumerate(h.joints)
        ]

    def slide(self, at: Scene, u: Array) -> Array:
        """u (n, 5) rad -> joint angle behind the friction (n, 5)."""
        width = np.broadcast_to(HALF_WIDTH, u.shape).copy()
        for h in self.hidden:
            if h.effect in WIDTH:
                width += WIDTH[h.effect](h, at)
        width = np.maximum(width, 0.0)
        out: Array = play(u, width, width, self.last)
        self.last = out[-1].copy()
        for h, n, j, stand in self.loops:
            place, weight = (np.asarray(h.extra[key]) for key in ("place", "weight"))
            wide = width[:, [j]] + float(h.parameters["width"][n]) * place
            elements = _side_by_side(np.repeat(u[:, [j]], place.size, axis=1), wide, stand)
            stand[:] = elements[-1]
            out[:, j] = elements @ weight
        return out


def _side_by_side(u: Array, wide: Array, last: Array) -> Array:
    out: Array = play(u, wide, wide, last)
    return out


def _creep(h: Hidden, j: int) -> tuple[list[float], list[float]]:
    late, gain = h.parameters["time_constant"], h.column("gain")[j]
    return [late, 1.0 - gain], [late, 1.0]


def _lag(h: Hidden, j: int) -> tuple[list[float], list[float]]:
    return [1.0], [h.column("time_constant")[j], 1.0]


def _resonance(h: Hidden, j: int) -> tuple[list[float], list[float]]:
    w = 2 * np.pi * h.column("frequency")[j]
    return [w * w], [1.0, 2 * h.parameters["damping"] * w, w * w]


_LAPLACE = {"viscoelastic_creep": _creep, "viscous_lag": _lag, "link_resonance": _resonance}


class _Filters:
    """Linear laws behind the friction, discretised exactly for ramps, from rest at zero."""

    def __init__(self, h: Hidden):
        self.parts = {}
        for j in h.joints:
            above, below, _ = cont2discrete(_LAPLACE[h.effect](h, j), STEP, method="foh")
            self.parts[j] = [np.ravel(above), below, np.zeros(len(below) - 1)]

    def run(self, x: Array) -> Array:
        """x (n, 5) rad -> (n, 5)."""
        out = x.copy()
        for j, part in self.parts.items():
            out[:, j], part[2] = lfilter(part[0], part[1], x[:, j], zi=part[2])
        return out
