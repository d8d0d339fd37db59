"""What clocks, sensors and knocks did to a recording that showed only beside the physics: it is said, and the
tones are taken out of what else is compared.
"""

from __future__ import annotations

from dataclasses import replace

from trunk_ros.diagnosis.data.sensing.readings import taken_out
from trunk_ros.diagnosis.knocks import knocks_told
from trunk_ros.diagnosis.pace import skew_told
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.recording.recording import Recording


def put_right_beside(recordings: list[Recording], state: Fit) -> list[Recording]:
    """The recordings of a fit's spans, with what was seen of them since."""
    return [_put_right(recording, state, index) for index, recording in enumerate(recordings)]


def _put_right(recording: Recording, state: Fit, index: int) -> Recording:
    context = state.context
    for columns, hum in context.views[index].hums:
        recording = taken_out(recording, [context.joints[c] for c in columns], hum)
    seen = (*skew_told(context, state.hypothesis, index), *knocks_told(context, state.hypothesis, index))
    return replace(recording, observed=recording.observed + seen)
