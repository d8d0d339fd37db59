"""A wheel out of round or out of centre."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Motion, Now
from trunk_ros.effects.periods import finest, periods, positive
from trunk_ros.guards import ROUNDED
from trunk_ros.parameter import Parameter
from trunk_ros.sine import sines

LEAST = 1.05  # periods within the motion
USUAL, MOST = 120.0, 1e6  # periods per turn that are looked for at any speed, and at any place


class TransmissionRipple(Effect):
    """u += amplitude sin(cycles_per_rev phi + phase), alone, with a second harmonic, or (two_orders) with
    another wheel's wave: harmonic amplitude sin(cycles_per_rev_2 phi + harmonic_phase).
    """

    id = "transmission_ripple"
    stage, place, regime = "wire", 20, "posture"
    begins = True
    signature = "The residual swings periodically over the motor-side angle, the same in both directions."
    source = (
        "Tuttle & Seering (1996), IEEE T. Robotics Autom. 12(3): "
        "kinematic error as a sum of sinusoids of the shaft angle."
    )
    parameters = (
        Parameter("amplitude", "rad", (-0.2, 0.2), "size of the swing", typical=3e-4),
        Parameter(
            "cycles_per_rev",
            "1",
            (0.05, MOST),
            "periods per turn of the gearbox shaft",
            typical=12.0,
            null=12.0,
            slide="1/(2 pi m)",
        ),
        Parameter(
            "phase",
            "rad",
            (-10.0, 10.0),
            "phase at motor-side angle 0",
            typical=1.0,
            scan=(0.0, 0.785, 1.571, 2.356),
            slide="rad",
            periodic=True,
        ),
        Parameter("harmonic", "1", (-2.0, 2.0), "size of the second wave over amplitude", typical=0.2),
        Parameter(
            "harmonic_phase",
            "rad",
            (-10.0, 10.0),
            "phase of it at motor-side angle 0",
            typical=1.0,
            scan=(0.0, 1.571),
            slide="rad",
            periodic=True,
        ),
        Parameter(
            "cycles_per_rev_2",
            "1",
            (0.05, MOST),
            "periods of it per turn, where they are not twice the first ones",
            typical=31.0,
            null=31.0,
            slide="1/(2 pi m)",
        ),
    )
    forms = ("sine", "two_harmonics", "two_orders")
    refined = ("two_harmonics", "two_orders")
    imitated_by = ("steps",)
    confused_with = (("ratio_error", "move over a wide range: a ripple turns back, a ratio error grows"),)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._ripple(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._ripple(now), None

    def _ripple(self, now: Now) -> Array:
        wave = sines(self["cycles_per_rev"] * now.gearbox, self["phase"])
        if self.form != "sine":
            wave += self["harmonic"] * sines(self._second() * now.gearbox, self["harmonic_phase"])
        return np.asarray(self["amplitude"] * wave)

    def _second(self) -> Array:
        """Periods per turn of the second wave."""
        return self["cycles_per_rev_2"] if self.form == "two_orders" else 2.0 * self["cycles_per_rev"]

    @classmethod
    def turning(cls, form: str) -> Mapping[str, tuple[str, float]]:
        first = {"phase": ("cycles_per_rev", 1.0)}
        if form == "sine":
            return first
        second = ("cycles_per_rev_2", 1.0) if form == "two_orders" else ("cycles_per_rev", 2.0)
        return {**first, "harmonic_phase": second}

    def credible(self, now: Now, beside: bool = False) -> bool:
        """A good period has to lie within the motion, or it is a bent curve; and two orders have to part by
        half of one there, or they are one wave that grows.
        """
        turns = np.ptp(now.gearbox, axis=0) / (2 * np.pi)
        within = self["cycles_per_rev"] * turns
        if self.form == "two_orders":
            second = self["cycles_per_rev_2"] * turns
            within = np.minimum(np.minimum(within, second), np.abs(second - within) + LEAST)
        if beside:
            return bool(np.all(within > LEAST))
        harmonic = (self.form == "two_harmonics") & (self["harmonic"] != 0.0)
        return bool(np.all(within > np.where(harmonic, 2.0, 1.6)))

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """None in a wide loop, or in one that is gone through once: a ripple is lost in its form, and can
        imitate it.
        """
        return () if motion.wide_loop or motion.once else super().forms_shown(motion)

    @classmethod
    def plain(cls, values: dict[str, float]) -> dict[str, float]:
        out = positive(values, "amplitude", "phase")
        if "harmonic" not in values:
            return out
        side = np.sign(values["amplitude"]) or 1.0
        out = positive({**out, "harmonic": side * values["harmonic"]}, "harmonic", "harmonic_phase")
        if "cycles_per_rev_2" in out and out["harmonic"] > 1.0 and cls._may_lead(out):
            size, order, phase, share, phase_2, order_2 = (out[p.name] for p in cls.parameters)
            turned = (size * share, order_2, phase_2, 1.0 / share, phase, order)
            out |= {p.name: value for p, value in zip(cls.parameters, turned, strict=True)}
        return out

    @classmethod
    def _may_lead(cls, values: dict[str, float]) -> bool:
        """Whether the second wave, the larger one, may come first."""
        return values["amplitude"] * values["harmonic"] <= cls.parameters[0].bounds[1]

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return {"two_harmonics": cls.parameters[:5], "two_orders": cls.parameters}.get(
            form, cls.parameters[:3]
        )

    def starts(self, now: Now, column: int, rest: Array | None = None) -> list[dict[str, Any]]:
        """Two orders: the strongest line, and the strongest of what it leaves."""
        if self.form != "two_orders" or rest is None:
            return super().starts(now, column, rest)
        phi, orders = now.gearbox[:, column], list[float]()
        left, waves = rest, np.zeros((0, 2))
        for _ in range(2):
            lines = self._lines(now, column, left)
            if not lines:
                return []
            orders.append(lines[0])
            seen = np.column_stack([f(order * phi) for order in orders for f in (np.sin, np.cos)])
            flat = np.column_stack([seen, np.ones_like(phi), phi])
            found = np.linalg.lstsq(flat, rest, rcond=None)[0]
            left, waves = rest - flat @ found, found[: 2 * len(orders)].reshape(-1, 2)
        size, phase = np.hypot(*waves.T), np.arctan2(waves[:, 1], waves[:, 0])
        values = (size[0], orders[0], phase[0], size[1] / max(size[0], ROUNDED), phase[1], orders[1])
        return [{p.name: float(v) for p, v in zip(self.parameters, values, strict=True)}]

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        """Only ripples of which the motion spans a period can be told from a bent curve."""
        if parameter.name != "cycles_per_rev" or rest is None:
            return super().grid(parameter, now, column, rest)
        return self._lines(now, column, rest)

    @classmethod
    def _lines(cls, now: Now, column: int, rest: Array) -> tuple[float, ...]:
        """None as fine as two steps of the joint's own encoder: those are what its rounding leaves."""
        phi = now.gearbox[:, column]
        least = next(p for p in cls.parameters if p.name == "cycles_per_rev").bounds[0]
        least = max(least, LEAST * 2 * np.pi / max(float(np.ptp(phi)), 1e-3))
        own = np.pi * abs(float(now.ratio[column])) / now.grain if now.grain else MOST
        return periods(phi, rest, least, min(max(USUAL, finest(phi)), own, MOST))
