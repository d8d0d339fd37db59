"""Another model at run time: parameters in, a model of the same arm out, or the reason why not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.urdf import joint_limits
from trunk_ros.errors import ModelError, TrunkError
from trunk_ros.model import Model, declared_parameters, load_model
from trunk_ros.nodes.graph import parameters
from trunk_ros.nodes.graph.ros import SetParametersResult

CLOSE = 1e-6  # rad and relative, for numbers that went through text


class ModelSwap:
    """Watches a node's parameters and hands a changed model to ``use``, if it is of the running arm."""

    def __init__(self, node: Any, use: Callable[[Model], None]):
        self.node, self.use = node, use
        self.describing = False
        node.add_on_set_parameters_callback(self._asked)
        node.add_post_set_parameters_callback(self._taken)

    def stop(self) -> None:
        """Watch no longer."""
        self.node.remove_on_set_parameters_callback(self._asked)
        self.node.remove_post_set_parameters_callback(self._taken)

    def _asked(self, changes: list[Any]) -> Any:
        """Take a new model, or refuse it with the reason."""
        if self.describing:
            return SetParametersResult(successful=True)
        try:
            model = self._changed({change.name: change.value for change in changes})
        except TrunkError as error:
            return SetParametersResult(successful=False, reason=str(error))
        if model is not None and model.hash() != self.node.model.hash():
            self.use(model)
        return SetParametersResult(successful=True)

    def _taken(self, changes: list[Any]) -> None:
        """Let the other parameters show the model that ``model`` has loaded."""
        if not self.describing and any(change.name == parameters.MODEL.name for change in changes):
            self.describing = True
            try:
                parameters.describe_model(self.node, self.node.model)
            finally:
                self.describing = False

    def _changed(self, changes: dict[str, Any]) -> Model | None:
        """The model that changed parameters describe, None where they are not about it. Raises TrunkError."""
        if parameters.MODEL.name in changes:
            return self._fitting(load_model(changes[parameters.MODEL.name]))
        names = {d.name for d in declared_parameters()}
        if not names & changes.keys():
            return None
        flat = {name: changes.get(name, self.node.value(name)) for name in names}
        return self._fitting(Model.from_parameters(flat))

    def _fitting(self, model: Model) -> Model:
        """The model if it is of the running arm. Raises TrunkError where it is another arm's."""
        running = self.node.model.arm
        if model.any_joints:
            model = model.for_joints(running.joints)
        check_same_arm(model.arm, running)
        return model


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
