"""What the data are like: rates, gaps, losses, damage."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from trunk_ros.recording.quality import quality
from trunk_ros.recording.recording import Recording


def quality_of_recording(recording: Recording) -> dict[str, Any]:
    """Rates and gaps by topic, and what the reader had to say."""
    topics = {key: asdict(value) for key, value in quality(recording).items()}
    return {"duration": recording.duration, "topics": topics, "notes": list(recording.notes)}
