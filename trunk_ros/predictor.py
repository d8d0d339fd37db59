"""What a model says of recordings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trunk_ros.arm_model import ArmModel

if TYPE_CHECKING:
    from trunk_ros.export.reality.plant import Plant
    from trunk_ros.recording.recording import Recording


@dataclass(frozen=True)
class Predictor(ArmModel):
    """The part of a model that predicts and is scored."""

    def predict(self, recording: Recording, source: str = "gearbox_states") -> Recording:
        """The joint readings (and, from ``setpoints``, the gearbox) that the model expects in a recording;
        stamps are those of its ``joint_states``. Raises RecordingError where ``source`` is missing.
        """
        from trunk_ros.simulate import simulate

        return simulate(recording, self, source)

    def score(self, recording: Recording, after: float = 5.0) -> dict[str, float]:
        """Root mean square error [rad] of the predicted readings of each joint, ``after`` s from the start.

        Raises RecordingError where the recording has no ``joint_states``.
        """
        predicted = self.predict(recording).series["joint_states"]
        measured = recording.require("joint_states").select(predicted.joints)
        _, here, there = np.intersect1d(measured.stamp, predicted.stamp, return_indices=True)
        error = measured.position[here] - predicted.position[there]
        kept = measured.stamp[here] >= after
        rms = np.sqrt(np.nanmean(error[kept] ** 2, axis=0))
        return dict(zip(predicted.joints, rms.tolist(), strict=True))

    def plant(self, environments: int = 1) -> Plant:
        """The arm tick by tick, as many of it at once as asked for: ``reset`` and ``step`` take setpoints
        (environments, joints) [rad, motor side] to joint readings. Raises ModelError as ``Plant`` does.
        """
        from trunk_ros.export.reality.plant import Plant

        return Plant(self, environments)
