"""The joint goes on creeping while the gearbox stands."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Motion, Now
from trunk_ros.effects.filters import lowpass
from trunk_ros.effects.swing import Decays, Transients
from trunk_ros.effects.wire.creeping import creep, creep_before, creep_inverse
from trunk_ros.effects.wire.on_both_sides import UPSTREAM, OnBothSides
from trunk_ros.guards import ROUNDED
from trunk_ros.parameter import Parameter

MODES = 6  # of a spectrum: two decades of it creep as smoothly as more would
LONGEST = 300.0  # s
CREEPS_BEFORE = ("upstream", "upstream_two_modes")
MODES_2 = ("two_modes", "upstream_two_modes")
AGES = np.geomspace(0.4, LONGEST, 9)  # s, of a power law, as closely: what is sooner is a lag


class ViscoelasticCreep(OnBothSides):
    """theta = p - gain lowpass(p), one or two time constants, or (spectrum) six with equal shares, evenly
    in the logarithm between two, or (power_law) nine from 0.4 s to longer than anybody records, whose shares
    go with a power of the time constant; load: theta = p + compliance lowpass(tau), of a wire that goes on
    giving way under weight, before the friction, behind it, or in part on either side; flow: likewise of
    what gives way without end, theta = p + flow integral of tau dt; upstream: the wire creeps before the
    friction, in one time constant or two, under the friction as well, theta = play(u - lowpass(q gain theta +
    rubbing z)) with the stretch z that bears the friction, where the play is q = rubbing/(rubbing + gain) of
    what it would be: the spring by whose pull the wire creeps takes its part of the friction.
    """

    id = "viscoelastic_creep"
    stage, place, regime = "wire", 300, "hold"
    signature = (
        "After a move the residual goes on for seconds, against the deflection, while the gearbox stands."
    )
    remembers = True
    source = (
        "Standard linear solid (Zener), one or two Maxwell branches: Palli et al. (2012), Mechatronics "
        "22(6). spectrum: Neubert (1963), Aeronaut. Q. 14(2); Fung (1972), for tendons. power_law: Findley "
        "(1944), ASTM Proc. 44, of plastics. upstream: the solid in series with dry friction. flow: the "
        "dashpot in series of Maxwell's fluid: oil past a piston, a belt that creeps over its wheel."
    )
    forms = (
        "one_mode", "two_modes", "spectrum", "power_law", "upstream", "upstream_two_modes", "load", "flow"
    )  # fmt: skip
    refined = ("two_modes", "spectrum", "power_law", "upstream_two_modes")
    parameters = (
        Parameter("gain", "1", (-0.45, 0.45), "share of the position that creeps back", typical=0.01),
        Parameter(
            "time_constant",
            "s",
            (0.15, LONGEST),
            "time constant of the creep",
            typical=5.0,
            null=5.0,
            scale="log",
            shared=True,
            scan=(0.5, 2.0, 6.0, 20.0),
        ),
        Parameter(
            "share_2", "1", (0.0, 1.0), "the second mode's share of the gain", typical=0.3, scan=(0.4,)
        ),
        Parameter(
            "time_constant_2",
            "s",
            (0.15, LONGEST),
            "time constant of the second mode, or the other end of the spectrum",
            typical=1.0,
            null=1.0,
            scale="log",
            shared=True,
            scan=(1.0,),
        ),
        Parameter(
            "rubbing", "1", (0.0, 5.0), "creep of the wire over its stretch, under the friction", typical=0.2
        ),
        Parameter(
            "compliance",
            "rad/(N*m)",
            (0.0, 1e3),
            "what it gives way by in the end, per moment",
            typical=0.01,
        ),
        UPSTREAM,
        Parameter(
            "exponent",
            "1",
            (-0.3, 1.0),
            "power of the time constant that the shares go with",
            typical=0.2,
            null=0.0,
            shared=True,
        ),
        Parameter("flow", "rad/(N*m*s)", (0.0, 10.0), "how fast it gives way, per moment", typical=1e-3),
    )
    confused_with = (
        ("thermal_drift", "hold at zero and far from it: creep follows the deflection"),
        ("viscous_lag", "hold still after a move: a lag is over in a fraction of a second"),
    )

    @classmethod
    def bears(cls, form: str) -> bool:
        return form in ("load", "flow")

    @property
    def acts_at(self) -> int:
        return self.CORE if self.form in CREEPS_BEFORE else self.place

    def adjust(self, core: Core, now: Now) -> None:
        if self.form not in CREEPS_BEFORE:
            return
        gain, rubbing = self["gain"], self["rubbing"]
        lets = np.where(gain == 0.0, 1.0, rubbing / np.maximum(rubbing + np.abs(gain), ROUNDED))
        core.width = core.width * lets
        u = now.gearbox * now.ratio + core.middle
        crept = lets * gain * u[0]
        share, constants = self._shares()
        begun = np.array([u[0], *[crept] * (1 + len(share))])
        memory = begun if core.old.get(self.id) is None else core.old[self.id].copy()
        out, width = np.empty_like(u), np.ascontiguousarray(np.broadcast_to(core.width, u.shape))
        creep_before(u, width, lets * gain, rubbing, share, constants, now.dt, memory, out)
        core.new[self.id] = memory
        core.middle = core.middle - out

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        if self.bears(self.form):
            given, state = self._given(x.shape, now, state)
            return x + given, state
        gains, constants = self._modes()
        state = np.tile(x[0], (len(gains), 2, 1)) if state is None else state.copy()
        out = np.empty_like(x)
        creep(x, now.dt, gains, constants, state, out)
        return out, state

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        if self.bears(self.form):
            given, state = self._given(y.shape, now, state)
            return y - given, state
        gains, constants = self._modes()
        state = (
            np.tile(y[0] / (1.0 - gains.sum(axis=0)), (len(gains), 2, 1)) if state is None else state.copy()
        )
        out = np.empty_like(y)
        creep_inverse(y, now.dt, gains, constants, state, out)
        return out, state

    def _given(self, shape: tuple[int, ...], now: Now, state: Any) -> tuple[Array, Array]:
        """(n, columns) rad by which the load has made the wire give way so far; what lies before the friction
        and what lies behind it remember the same.
        """
        load = np.ascontiguousarray(np.broadcast_to(now.load, shape))
        if self.form == "flow":
            before, so_far = (load[0], np.zeros(shape[1])) if state is None else state
            mean = (load + np.concatenate([before[None], load[:-1]])) / 2.0
            flown = so_far + np.cumsum(mean * now.dt[:, None], axis=0)
            return self["flow"] * flown, np.stack([load[-1], flown[-1]])
        state, low = np.tile(load[0], (2, 1)) if state is None else state.copy(), np.empty_like(load)
        lowpass(load, now.dt, self["time_constant"], state, low)
        return self["compliance"] * low, state

    def _modes(self) -> tuple[Array, Array]:
        """Gains and time constants, (modes, columns) each."""
        if self.form == "spectrum":
            constants = np.geomspace(self["time_constant"], self["time_constant_2"], MODES)
            return np.tile(self["gain"] / MODES, (MODES, 1)), constants
        if self.form == "power_law":
            shares = AGES[:, None] ** self["exponent"]
            return self["gain"] * shares / shares.sum(axis=0), np.tile(AGES[:, None], len(self["gain"]))
        share, constants = self._shares()
        return self["gain"] * share, constants

    def _shares(self) -> tuple[Array, Array]:
        """Shares of one mode or two, and time constants, (modes, columns) each."""
        second = self["share_2"]
        if self.form not in MODES_2:
            return np.ones((1, len(second))), self["time_constant"][None]
        constants = np.stack([self["time_constant"], self["time_constant_2"]])
        return np.stack([1.0 - second, second]), constants

    def transients(self, now: Now) -> Transients | None:
        """What the wire still creeps by from before the first sample, by as much as motion like that of the
        recording leads to, where most of it dies away in the recording: else it were no more than a zero. A
        load is taken to have been there before.
        """
        if self.bears(self.form):
            return None
        gains, constants = (each[:, 0] for each in self._modes())
        most = float(np.abs(gains).sum() * np.ptp(now.gearbox[:, 0] * now.ratio[0]))
        dies = 2.0 * constants <= now.stamp[-1] - now.stamp[0]
        if most == 0.0 or len(gains) > 2 or not dies.any():
            return None
        return Decays(now.stamp[:1], constants[dies], np.array([most]))

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Slower than a lag, and not so slow that it is no more than another ratio."""
        _, constants = self._modes()
        return self.form in ("power_law", "flow") or bool(
            np.all((constants > 0.4) & (constants < 2.0 * (now.stamp[-1] - now.stamp[0])))
        )

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """What goes with the load, of a joint that bears one that is known."""
        return tuple(f for f in super().forms_shown(motion) if motion.bears or not cls.bears(f))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        gain, constant, share, constant_2, rubbing, compliance, upstream, exponent, flow = cls.parameters
        if cls.bears(form):
            return (flow, upstream) if form == "flow" else (compliance, constant, upstream)
        if form == "power_law":
            return gain, exponent
        second = {"spectrum": (constant_2,)} | dict.fromkeys(MODES_2, (share, constant_2))
        return (gain, constant, *second.get(form, ()), *((rubbing,) if form in CREEPS_BEFORE else ()))
