"""What the data are like: rates, gaps, losses, damage."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from trunk_ros.diagnosis.torque import torque_remarks
from trunk_ros.model import Model
from trunk_ros.recording.quality import quality
from trunk_ros.recording.recording import Recording


def quality_of_recording(recording: Recording, model: Model) -> dict[str, Any]:
    """Rates and gaps by topic, what the reader had to say, and what the motors' torque says of the load."""
    topics = {key: asdict(value) for key, value in quality(recording).items()}
    notes = [*recording.notes, *torque_remarks(recording, model)]
    return {"duration": recording.duration, "topics": topics, "notes": notes}
