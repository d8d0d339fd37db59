"""How many of a joint's readings count, and why the others do not."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from trunk_ros.data.span import Span
from trunk_ros.levels import NEARLY, SLIGHT
from trunk_ros.recording.recording import Recording

WHY = (
    "are missing",
    "lie where readings of its motor are missing",
    "come before it has moved far enough to tell where it lay in its play",
    "follow gaps in which its motor may have turned, until it has moved on",
)
"""Why readings do not count, in the order in which it is asked."""


def with_counting(recordings: list[Recording], spans: list[Span]) -> list[Recording]:
    """Recordings with what is to be said of the readings of their spans; as they are where there are none."""
    told = zip(recordings, spans, strict=True)
    return [replace(r, notes=(*r.notes, *counting_told(s))) for r, s in told] if spans else recordings


def counting_told(span: Span) -> list[str]:
    """A remark on each joint that moves of which clearly less than all readings count."""
    told = []
    for c, joint in enumerate(span.joints):
        left = [1.0, *(float(shares[c]) for shares in span.counting)]
        if 0.0 < left[-1] < NEARLY:
            lost = [before - after for before, after in pairwise(left)]
            why = [f"{share:.0%} {reason}" for share, reason in zip(lost, WHY, strict=True) if share > SLIGHT]
            told.append(f"{left[-1]:.0%} of the readings of {joint} count: {', '.join(why)}")
    return told
