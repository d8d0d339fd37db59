"""One piece of hidden physics, as it is drawn and as it is told in truth.json."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from test.concealed.nominal import COUNT, JOINTS, Array

REGIME = {
    "ratio_error": "posture", "transmission_ripple": "posture", "joint_coupling": "posture",
    "thermal_drift": "time", "wire_slip": "time", "backlash": "reversal", "tension_error": "reversal",
    "load_dependent_friction": "reversal", "stribeck_friction": "low_speed", "friction_wear": "reversal",
    "presliding_hysteresis": "reversal", "load_elasticity": "posture", "wire_slack": "posture",
    "wire_stiffening": "posture", "viscoelastic_creep": "hold", "viscous_lag": "high_speed",
    "link_resonance": "high_speed", "hard_stop": "posture", "sensor_delay": "high_speed",
    "zero_offset": "always", "servo_delay": "high_speed", "servo_bandwidth": "high_speed",
    "velocity_saturation": "high_speed", "load_droop": "posture", "cogging": "posture",
    "link_length_error": "always", "base_tilt": "always",
    "x_bump": "posture", "x_gain_wear": "time", "x_one_sided_lag": "high_speed", "x_cubic": "posture",
    "x_quadratic": "posture", "x_intermittent": "time", "x_centrifugal": "high_speed",
    "x_velocity_coupling": "high_speed", "x_vibration": "time", "x_breathing": "time",
    "x_rough_patch": "reversal", "x_servo_dead_zone": "hold", "x_link_bending": "posture",
}  # fmt: skip
SERVO = ("servo_delay", "servo_bandwidth", "velocity_saturation", "load_droop", "cogging",
         "x_servo_dead_zone")  # fmt: skip
ARM = ("link_length_error", "base_tilt", "x_link_bending")
KNOWN = tuple(name for name in REGIME if not name.startswith("x_"))
UNKNOWN = tuple(name for name in REGIME if name.startswith("x_"))
DEPENDS_ON = {
    "x_bump": "position", "x_gain_wear": "time", "x_one_sided_lag": "speed", "x_cubic": "position",
    "x_quadratic": "position", "x_intermittent": "time", "x_centrifugal": "speed",
    "x_vibration": "time", "x_breathing": "time", "x_rough_patch": "position",
    "x_servo_dead_zone": "speed", "x_link_bending": "position",
}  # fmt: skip


@dataclass(frozen=True)
class Hidden:
    """Physics on some joints. Parameters: (len(joints),) arrays, shared floats, or the source joint's index.

    ``same`` names the parameters that mean the same as in the contract whatever the form.
    """

    effect: str
    joints: tuple[int, ...]
    form: str
    parameters: dict[str, Any]
    same: tuple[str, ...] = ()
    extra: dict[str, Any] = field(default_factory=dict)

    @property
    def stage(self) -> str:
        """Stage in which the physics sits."""
        return "servo" if self.effect in SERVO else "arm" if self.effect in ARM else "wire"

    def column(self, name: str, other: float = 0.0) -> Array:
        """A parameter for all five joints, ``other`` where the effect is absent."""
        out = np.full(COUNT, other)
        out[list(self.joints)] = self.parameters.get(name, other)
        return out

    def told(self) -> dict[str, Any]:
        """The entry of truth.json."""
        names = [JOINTS[j] for j in self.joints]
        per_joint: dict[str, dict[str, Any]] = {name: {} for name in names}
        shared: dict[str, Any] = {}
        for key, value in self.parameters.items():
            if key == "source":
                shared[key] = JOINTS[int(value)]
            elif isinstance(value, np.ndarray) and value.size != len(names):
                shared[key] = value.tolist()
            elif isinstance(value, np.ndarray):
                for name, one in zip(names, value, strict=True):
                    per_joint[name][key] = float(one)
            else:
                shared[key] = float(value)
        return {
            "effect": self.effect, "stage": self.stage, "regime": REGIME[self.effect], "form": self.form,
            "joints": [] if self.effect == "base_tilt" else names,
            "parameters": {k: v for k, v in {**per_joint, "arm": shared}.items() if v},
            "same": list(self.same), "known": not self.effect.startswith("x_"),
            "depends_on": shared.get("source", DEPENDS_ON.get(self.effect, "")), "extra": self.extra,
        }  # fmt: skip
