"""The joint goes on creeping while the gearbox stands."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.filters import lowpass
from trunk_ros.parameter import Parameter


class ViscoelasticCreep(Effect):
    """theta = p - gain lowpass(p), one or two time constants."""

    id = "viscoelastic_creep"
    stage, place, regime = "wire", 300, "hold"
    signature = "After a move the residual goes on for seconds, against the deflection, while the gearbox stands."
    source = "Standard linear solid (Zener), one or two Maxwell branches: Palli et al. (2012), Mechatronics 22(6)."
    forms = ("one_mode", "two_modes")
    parameters = (
        Parameter("gain", "1", (-0.5, 0.9), "share of the position that creeps back", typical=0.01),
        Parameter("time_constant", "s", (0.15, 300.0), "time constant of the creep", typical=5.0, null=5.0, scale="log", shared=True,
                  scan=(0.5, 2.0, 6.0, 20.0)),
        Parameter("gain_2", "1", (-0.5, 0.9), "share of the second mode", typical=0.005),
        Parameter("time_constant_2", "s", (0.15, 300.0), "time constant of the second mode", typical=1.0, null=1.0, scale="log",
                  shared=True, scan=(1.0,)),
    )
    confused_with = (("thermal_drift", "hold at zero and far from it: creep follows the deflection"),
                     ("viscous_lag", "hold still after a move: a lag is over in a fraction of a second"))

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        state = self._memory(x, state)
        low = np.empty_like(x)
        out = x.copy()
        for mode, (gain, constant) in enumerate(self._modes()):
            lowpass(x, now.dt, constant, state[mode, 0], state[mode, 1], low)
            out -= gain * low
        return out, state

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        """Step by step: what is known of the low-pass before the sample, and its share of the sample itself."""
        state = self._memory(y / (1.0 - self._total()), state)
        modes = self._modes()
        out = np.empty_like(y)
        for k, dt in enumerate(now.dt):
            known, share = np.zeros(y.shape[1]), np.zeros(y.shape[1])
            for mode, (gain, constant) in enumerate(modes):
                x0, y0 = state[mode]
                decay = np.exp(-dt / constant)
                ramp = 1.0 - constant / dt * (1.0 - decay) if dt > 0 else np.zeros_like(decay)
                known += gain * (decay * y0 + (1.0 - decay - ramp) * x0)
                share += gain * ramp
            out[k] = (y[k] + known) / (1.0 - share)
            low = np.empty((1, y.shape[1]))
            for mode, (_, constant) in enumerate(modes):
                lowpass(out[k : k + 1], now.dt[k : k + 1], constant, state[mode, 0], state[mode, 1], low)
        return out, state

    def _modes(self) -> list[tuple[Array, Array]]:
        first = [(self["gain"], self["time_constant"])]
        return first + [(self["gain_2"], self["time_constant_2"])] if self.form == "two_modes" else first

    def _total(self) -> Array:
        return np.asarray(sum(gain for gain, _ in self._modes()))

    def _memory(self, x: Array, state: Any) -> Array:
        """(modes, 2, columns): input and output of each low-pass at the sample before; settled at the start."""
        if state is not None:
            return np.asarray(state).copy()
        return np.tile(x[0], (2, 2, 1))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "two_modes" else cls.parameters[:2]
