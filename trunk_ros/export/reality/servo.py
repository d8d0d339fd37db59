"""What a servo lacks, before the command goes to the simulator's own."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.core import up_and_down
from trunk_ros.effects.effect import Effect
from trunk_ros.effects.filters import lag_step, oscillator
from trunk_ros.effects.servo.speed import led_on
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.export.reality.blocks import Block, core_of
from trunk_ros.export.reality.past import Past
from trunk_ros.export.reality.scene import Scene
from trunk_ros.sine import sines


class Servo:
    """Delay, top speeds, another loop, droop, cogging and dead zone, on commands (environments, joints).

    The simulator's own position loop stays in its place: only what it lacks is put before it.
    """

    def __init__(self, model: ArmModel, environments: int, steps_loop: bool = False):
        """``steps_loop``: whoever asks steps the loops as well, with ``hardest`` and ``dry``."""
        arm, effects = model.arm, model.bound("servo")
        self.blocks = [Block(e, arm, environments) for e in effects if e.acts_at == Effect.CORE]
        self.behind = [Block(e, arm, environments) for e in effects if e.acts_at > Effect.CORE]
        scene = Scene(arm, model.duration, 0.0, *(np.zeros((1, len(arm.joints))),) * 3)
        core = core_of(scene.gearbox)
        core.delay, core.feedforward = np.atleast_1d(arm.delay), np.atleast_1d(arm.feedforward)
        for block in [Block(e, arm, 1) for e in effects if e.acts_at <= Effect.CORE]:
            block.adjust(core, scene)
        columns = environments * len(arm.joints)

        def spread(values: Array) -> Array:
            return np.tile(np.broadcast_to(values, len(arm.joints)), environments)

        even = (core.uneven == 0.0) & (core.ramp == np.inf)  # top speeds that are the simulator's matter
        nominal = np.where(even, np.inf, arm.v_max)
        top = np.where(np.isfinite(core.v_max), core.v_max, nominal)
        led = np.ravel(core.quickest)
        ways = up_and_down(top, core.uneven)
        profiled = np.ravel(core.ramp) < np.inf  # it keeps to its top speed, and the loop has none
        up, down = (spread(np.where(profiled, np.inf, np.minimum(np.ravel(way), led))) for way in ways)
        self.fastest = up, down
        self.bounds = (
            (spread(np.asarray(core.lowest)), spread(np.asarray(core.highest))) if core.bounded else None
        )
        self.hardest = np.broadcast_to(np.ravel(core.hardest), len(arm.joints))
        """(joints,) rad/s^2: for who steps the loop; no command shows another one's speed its limit."""
        self.dry = np.broadcast_to(np.ravel(core.dry), len(arm.joints))
        """(joints,) rad that friction holds: commands that lag by it have another loop go alike, slowly."""
        self.short = np.zeros_like(self.dry) if steps_loop else self.dry
        self.ki = np.broadcast_to(np.ravel(core.ki), len(arm.joints))
        """(joints,) 1/s^2, likewise: summed up without ``beside`` (columns,) rad, loads and what is fed."""
        self.windup = np.broadcast_to(np.ravel(core.windup), len(arm.joints))
        """(joints,) rad/s, likewise."""
        self.speed_ki = np.broadcast_to(np.ravel(core.speed_ki), len(arm.joints))
        """(joints,) 1/s, likewise."""
        self.beside: Array = np.zeros(columns)
        self.ramp, self.pace = spread(np.ravel(core.ramp)), spread(np.minimum(np.ravel(top), led))
        limited = core.bounded or bool(np.isfinite(np.minimum(led, core.ramp)).any())
        self.passes = not (self.blocks or limited)
        self.gain = spread(core.kp)
        self.kp = spread(np.asarray(arm.kp))
        self.tau = spread(np.asarray(arm.tau_v))
        self.slower = spread(core.tau_v)
        self.swing: Array | None = None
        self.cogging = core.cogging[:, 0] if core.cogging.any() else None
        self.rub = spread(core.rub)
        self.reach = np.maximum(spread(np.abs(arm.dead_band / arm.ratio)), self.rub)
        self.held: Array | None = None
        late = np.maximum(spread(core.delay), 0.0)  # stamps that are late are none of a simulator's
        self.past = Past(late) if np.any(late > 0.0) else None
        self.early = spread(core.feedforward) / (self.gain * self.kp)
        self.asked: Array | None = None
        self.before: Array | None = None
        self.profile: Array | None = None
        """(2, columns) rad and rad/s: how far each drive leads its shaft now, and how fast."""
        self.low: Array = np.zeros(columns)
        self.stuck: Array | None = None

    def step(self, command: Array, scene: Scene, now: float, anew: np.ndarray | None) -> Array:
        """The command (environments, joints) as it reaches the simulator's servo."""
        if self.passes and not self.behind and self.past is None and not self.early.any():
            return command
        shape = command.shape
        x: Array = command.reshape(-1)
        x = x if self.bounds is None else np.clip(x, *self.bounds)
        columns = None if anew is None else np.repeat(anew, shape[1])
        if self.past is not None:
            if columns is not None:
                self.past.restart(columns, x)
            x = self.past.step(now, x)
        if self.before is None:
            self.before, self.low = x.copy(), x.copy()
        elif columns is not None:
            self.before[columns] = self.low[columns] = x[columns]
            if self.swing is not None:
                self.swing[:, columns] = np.stack([x, x, 0.0 * x])[:, columns]
        shaped = self._shaped(self._led(x, scene, columns), scene.dt)
        x = self._fed(shaped, scene.dt, columns).reshape(shape)
        core = core_of(x)
        for block in self.blocks:
            block.adjust(core, scene)
        pulled = x + core.load
        x = pulled + core.pull
        if self.cogging is not None:
            size, cycles, phase = self.cogging
            x = x + size * sines(np.ascontiguousarray(cycles * x), phase)
        held = self._held_back(x, core.load, columns)
        self.beside, x = (pulled + (held - x)).ravel() - shaped, held
        zone = np.maximum(core.dead_zone, self.short)  # what one of them holds, the other one need not
        x = self._stopped_short(x, zone, columns)
        for block in self.behind:
            x = block.run(x, scene, anew)
        return x

    def _fed(self, x: Array, dt: float, anew: np.ndarray | None) -> Array:
        """As far ahead as a loop would have to be asked that is told how fast commands move."""
        if dt <= 0.0 or not self.early.any():
            return x
        before = x if self.asked is None else self.asked if anew is None else np.where(anew, x, self.asked)
        self.asked = x.copy()
        return x + self.early * (x - before) / dt

    def _led(self, x: Array, scene: Scene, anew: np.ndarray | None) -> Array:
        """Along profiles from where shafts stand to commands; between two steps as far as in the middle."""
        if not np.isfinite(self.ramp).any():
            return x
        begun = np.stack([scene.gearbox.reshape(-1), 0.0 * x])
        self.profile = begun if self.profile is None else self.profile
        if anew is not None:
            self.profile[:, anew] = begun[:, anew]
        if scene.dt <= 0.0:
            return x
        out = np.empty_like(x)
        lead_commands(x, scene.dt, self.pace, self.ramp, self.profile, out)
        return out

    def _shaped(self, x: Array, dt: float) -> Array:
        """No faster than the top speed, and K'/K + (1 - K'/K) lag of 1/K' in the place of what K leaves."""
        assert self.before is not None
        out, alike = np.empty_like(x), bool(np.all(self.slower == 1.0))
        gain = self.gain if alike else np.ones_like(self.gain)
        shape_commands(x, dt, *self.fastest, gain, self.kp, self.before, self.low, out)
        return out if alike else self._as_quick(out, dt)

    def _as_quick(self, x: Array, dt: float) -> Array:
        """What has a loop of K and tau go as one of K' and tau' would, which is z: its equation,
        tau z'' + z' + K z = K u, solved for the command u.
        """
        if self.swing is None:
            self.swing = np.stack([x, x, 0.0 * x])
        gain, slow = self.kp * self.gain, self.tau * self.slower
        omega, zeta = np.sqrt(gain / slow), 0.5 / np.sqrt(gain * slow)
        oscillator(x[None], np.array([dt]), omega, zeta, False, self.swing, np.empty_like(x)[None])
        _, z, rate = self.swing
        return np.asarray(z + (rate + self.tau * (omega**2 * (x - z) - rate / slow)) / self.kp)

    def _held_back(self, x: Array, load: Array, anew: np.ndarray | None) -> Array:
        """Behind a command by what wires that slide pull; one that sticks keeps what the load pulls away.
        At first friction bears the load, as far as it goes.
        """
        if not self.rub.any():
            return x
        share = self.rub / np.where(self.reach > 0.0, self.reach, 1.0)
        more = np.divide(1.0, share, out=np.ones_like(share), where=share > 0.0) - 1.0
        flat, bears = x.reshape(1, -1), (load + np.zeros_like(x)).reshape(1, -1)
        leans = flat + more * bears
        holds = np.divide(bears, self.rub, out=np.zeros_like(bears), where=self.rub > 0.0)
        begun = (leans - self.reach * np.clip(holds, -1.0, 1.0))[0]
        if self.held is None:
            self.held = begun
        elif anew is not None:
            self.held = np.where(anew, begun, self.held)
        stuck, self.held = SharpPlay().run(leans, self.reach[None], self.held)
        return (flat - share * (leans - stuck)).reshape(x.shape)

    def _stopped_short(self, x: Array, zone: Array, anew: np.ndarray | None) -> Array:
        """What a loop makes of errors that it does not answer to, or that friction holds: it stops short."""
        if not zone.any():
            return x
        flat = x.reshape(1, -1)
        if self.stuck is not None and anew is not None:
            self.stuck = np.where(anew, flat[0], self.stuck)
        out, self.stuck = SharpPlay().run(flat, zone.reshape(1, -1), self.stuck)
        return out.reshape(x.shape)


@compiled
def lead_commands(x: Array, dt: float, most: Array, ramp: Array, profile: Array, out: Array) -> None:
    """Commands (columns,) that a drive goes to along a ``profile`` (2, columns), as ``led_on`` has it."""
    steps = max(int(np.ceil(dt / STEP - 1e-9)), 1)
    for j in range(len(x)):
        out[j] = x[j]
        if ramp[j] < np.inf:
            led, pace, total = profile[0, j], profile[1, j], 0.0
            for _ in range(steps):
                came = led
                led, pace = led_on(led, pace, x[j], most[j], ramp[j], dt / steps)
                total += 0.5 * (came + led)
            out[j] = total / steps
            profile[0, j], profile[1, j] = led, pace


@compiled
def shape_commands(
    x: Array,
    dt: float,
    up: Array,
    down: Array,
    gain: Array,
    kp: Array,
    before: Array,
    low: Array,
    out: Array,
) -> None:
    """Commands (columns,) held back to speeds ``up`` and ``down``, then with the bandwidth ``gain``
    times ``kp`` instead of ``kp``; ``before`` and ``low`` (columns,) are the memory.
    """
    for j in range(len(x)):
        least, most = before[j] - down[j] * dt, before[j] + up[j] * dt
        y = min(max(x[j], least), most) if dt > 0.0 else before[j]
        if gain[j] != 1.0:
            ramp, decay = lag_step(dt, 1.0 / (kp[j] * gain[j]))
            low[j] = ramp * y + (1.0 - ramp - decay) * before[j] + decay * low[j]
            out[j] = gain[j] * y + (1.0 - gain[j]) * low[j]
        else:
            out[j] = y
        before[j] = y
