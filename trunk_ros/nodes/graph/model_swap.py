"""Another model at run time: parameters in, a model of the same arm out, or the reason why not."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.urdf import joint_limits
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model
from trunk_ros.nodes.graph.parameters import changed_model
from trunk_ros.nodes.parameters import MODEL

CLOSE = 1e-6  # rad and relative, for numbers that went through text


class ModelSwap:
    """The running model and the file that it came from, for changes of both."""

    def __init__(self, model: Model, name: str):
        """``name``: of the file, or in config/."""
        self.model = model
        self._file = name, ""

    def changed(self, changes: dict[str, Any]) -> Model | None:
        """The model that changed parameters ask for, None where it stays. Raises TrunkError where it may not.

        A file that is named again is read again; where it says what it said, single values stay as they are.
        """
        model = self._loaded(str(changes[MODEL.name])) if MODEL.name in changes else None
        model = changed_model(model or self.model, changes) or model
        if model is None:
            return None
        check_same_arm(model.arm, self.model.arm)
        return None if model.hash() == self.model.hash() else model

    def _loaded(self, name: str) -> Model | None:
        model = load_model(name)
        if model.any_joints:
            model = model.for_joints(self.model.arm.joints)
        check_same_arm(model.arm, self.model.arm)
        before, self._file = self._file, (name, model.hash())
        unread = before == (name, "")  # what it says is the running model, or was overruled at the start
        return None if unread or before == self._file else model


def check_same_arm(new: Arm, running: Arm) -> None:
    """Raise ModelError where a model is not of the running arm; effects may differ, the arm may not."""
    if new.joints != running.joints:
        raise ModelError(f"the model has joints {', '.join(new.joints)}, the arm {', '.join(running.joints)}")
    for name in ("ratio", "lower", "upper"):
        if not np.allclose(getattr(new, name), getattr(running, name), rtol=CLOSE):
            raise ModelError(f"the model's {name} is not that of the running arm")


def check_description(text: str, arm: Arm) -> None:
    """Raise ModelError where a model's arm is not the one that ``robot_description`` (URDF) describes.

    It must have all the model's joints, and let each go as far as the model does, where that knows limits.
    """
    limits = joint_limits(text)
    if missing := [joint for joint in arm.joints if joint not in limits]:
        raise ModelError(
            f"the model is of another arm: robot_description has no {missing[0]}, but {', '.join(limits)}"
        )
    for j, joint in enumerate(arm.joints):
        lower, upper = limits[joint]
        if -np.inf < arm.lower[j] < lower - CLOSE or upper + CLOSE < arm.upper[j] < np.inf:
            raise ModelError(
                f"the model is of another arm: {joint} goes from {arm.lower[j]:.4g} to {arm.upper[j]:.4g} "
                f"rad, in robot_description from {lower:.4g} to {upper:.4g}"
            )
