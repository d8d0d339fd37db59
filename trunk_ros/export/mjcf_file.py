"""An MJCF file, read and written by MuJoCo's MjSpec."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.bodies.found import Bodies
from trunk_ros.errors import TrunkError
from trunk_ros.export.last_link import told
from trunk_ros.export.markup import commented, parse, to_text
from trunk_ros.export.mjcf_actuator import Drive, drive_of, tag_of
from trunk_ros.export.mjcf_bodies import write_last_link
from trunk_ros.export.sheet import Writer
from trunk_ros.model import Model

OFF = "{}: its friction lets it stand up to {:.3g} rad off its actuator's command"
STIFF = (0.999, 0.9999, 0.001, 0.5, 2.0)  # solimp of friction and of stops that hold


class MjcfFile(Writer):
    """What is read of an MJCF file, and what is written into its joints and bodies whatever the effect."""

    def __init__(self, model: Model, path: Path):
        """Raises TrunkError where MuJoCo is not installed or cannot read the file."""
        super().__init__(model)
        mujoco = the_engine()
        try:
            self.spec = mujoco.MjSpec.from_file(str(path))
            self.spec.compile()
        except (ValueError, OSError) as error:
            raise TrunkError(f"{path}: MuJoCo cannot read it: {' '.join(str(error).split())}") from None
        self.mujoco = mujoco
        self.drives = {joint: drive_of(mujoco, self.spec, joint) for joint in self.joints}
        absent = [joint for joint in self.joints if self.spec.joint(joint) is None]
        if len(absent) == len(self.joints):
            there = ", ".join(joint.name for joint in self.spec.joints if joint.name)
            raise TrunkError(f"{path}: none of the joints {', '.join(absent)} is in it (there are {there})")
        self.remarks += [f"{joint}: not in the file" for joint in absent]

    def text(self) -> str:
        try:
            self.spec.compile()
        except ValueError as error:
            raise TrunkError(f"what was written does not compile in MuJoCo: {error}") from None
        root = parse(self.spec.to_xml(), "MuJoCo's own file")
        commented(root, self.lines)
        return to_text(root)

    def lags(self) -> list[float]:
        """How far each joint's own position loop is behind a steady command [s]; 0 where it has none."""
        return [drive.lag(self._damping(joint)) if drive else 0.0 for joint, drive in self.drives.items()]

    def last_link(self, bodies: Bodies) -> None:
        """Mass and centre of the body that the last joint moves; its inertia about the centre stays."""
        name, why = write_last_link(self.mujoco, self.spec, self.model.arm, bodies)
        if name:
            self.note("body", name, told(bodies))
        else:
            self.remarks.append(why)

    def term(self, joint: str, name: str, value: float) -> str:
        """The joint's own ``frictionloss``, ``damping`` or ``armature``."""
        own, drive = self.spec.joint(joint), self.drives[joint]
        if own is None:
            return ""
        if name == "armature":
            own.armature = value
            return name
        if name == "damping":
            self._damp(joint, value)
            return name
        self._rub(joint, value)
        if drive is not None:
            self.remarks.append(OFF.format(joint, value / drive.stiffness))
        return "frictionloss"

    def _actuators(self) -> list[Any]:
        drives = list(self.drives.values())
        return [drive.actuator for drive in drives if drive] if all(drives) else []

    def _damping(self, joint: str) -> float:
        return float(np.atleast_1d(self.spec.joint(joint).damping)[0])

    def _damp(self, joint: str, damping: float) -> None:
        own = self.spec.joint(joint)
        values = np.atleast_1d(own.damping).copy()
        values[0] = damping
        own.damping = values if np.ndim(own.damping) else damping

    def _rub(self, joint: str, friction: float) -> None:
        own = self.spec.joint(joint)
        own.frictionloss = friction
        own.solref_friction = [2.0 * self.spec.option.timestep, 1.0]
        own.solimp_friction = list(STIFF)

    def _told(self, drive: Drive, text: str) -> bool:
        self.note(tag_of(drive.actuator), drive.actuator.name, text)
        return True


def the_engine() -> Any:
    """The module ``mujoco``. Raises TrunkError where it is not installed."""
    try:
        import mujoco
    except ImportError:
        raise TrunkError("MuJoCo is not installed: pip install mujoco, or trunk_ros[mujoco]") from None
    return mujoco
