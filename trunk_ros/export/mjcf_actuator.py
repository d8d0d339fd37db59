"""Position actuators of an MJCF file: force = gear (kp (ctrl - length) - kv rate)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass
class Drive:
    """A joint's position actuator."""

    actuator: Any
    mujoco: Any
    """The module."""

    @property
    def stiffness(self) -> float:
        """N m/rad about the joint."""
        return float(self.actuator.gainprm[0]) * float(self.actuator.gear[0]) ** 2

    def lag(self, damping: float) -> float:
        """How far the loop is behind a steady command [s], with the joint's own ``damping`` [N m s/rad]."""
        rate = -float(self.actuator.biasprm[2]) * float(self.actuator.gear[0]) ** 2
        filters = self.actuator.dyntype in self._filters
        return (rate + damping) / self.stiffness + (float(self.actuator.dynprm[0]) if filters else 0.0)

    def gear(self, factor: float) -> None:
        """Another gear with the same stiffness about the joint."""
        gear = list(self.actuator.gear)
        self.actuator.gear = [gear[0] * factor, *gear[1:]]
        self._scale(factor**-2, factor**-2)

    def soften(self, compliance: float) -> None:
        """Put a spring of so many rad/(N m) in series; the loop is as fast as before."""
        factor = 1.0 / (1.0 + self.stiffness * compliance)
        self._scale(factor, factor)

    def strengthen(self, factor: float) -> None:
        """Another gain with the same damping."""
        self._scale(factor, 1.0)

    def damp(self, rate: float) -> None:
        """Another damping about the joint [N m s/rad]."""
        bias = list(self.actuator.biasprm)
        bias[2] = -rate / float(self.actuator.gear[0]) ** 2
        self.actuator.biasprm = bias

    def filter(self, constant: float) -> bool:
        """A first-order filter [s] of its command; False where its command goes through another one."""
        if self.actuator.dyntype != self.mujoco.mjtDyn.mjDYN_NONE:
            return False
        prm = list(self.actuator.dynprm)
        prm[0] = constant
        self.actuator.dyntype, self.actuator.dynprm = self.mujoco.mjtDyn.mjDYN_FILTEREXACT, prm
        return True

    @property
    def _filters(self) -> tuple[Any, ...]:
        kinds = self.mujoco.mjtDyn
        return kinds.mjDYN_FILTER, kinds.mjDYN_FILTEREXACT

    def couple(self, spec: Any, joint: str, source: str, gain: float) -> str:
        """Pull a tendon over the joint less ``gain`` of another; its name."""
        name = f"{joint}_wire"
        tendon = spec.add_tendon(name=name)
        tendon.wrap_joint(joint, 1.0)
        tendon.wrap_joint(source, -gain)
        self.actuator.trntype, self.actuator.target = self.mujoco.mjtTrn.mjTRN_TENDON, name
        return name

    def _scale(self, kp: float, kv: float) -> None:
        gain, bias = list(self.actuator.gainprm), list(self.actuator.biasprm)
        gain[0], bias[1], bias[2] = gain[0] * kp, bias[1] * kp, bias[2] * kv
        self.actuator.gainprm, self.actuator.biasprm = gain, bias


def drive_of(mujoco: Any, spec: Any, joint: str) -> Drive | None:
    """The position actuator of a joint; None where it has none, or more than one actuator."""
    on_joint = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    found = [a for a in spec.actuators if a.target == joint and a.trntype in on_joint]
    if len(found) != 1:
        return None
    actuator = found[0]
    affine = actuator.biastype == mujoco.mjtBias.mjBIAS_AFFINE
    kp = float(actuator.gainprm[0])
    if not affine or kp <= 0.0 or float(actuator.biasprm[1]) != -kp:
        return None
    actuator.name = actuator.name or f"{joint}_drive"
    return Drive(actuator, mujoco)


def tag_of(actuator: Any) -> str:
    """The element that MuJoCo writes an actuator as."""
    return "general" if hasattr(actuator, "gainprm") else "position"
