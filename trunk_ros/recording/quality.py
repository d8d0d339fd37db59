"""How evenly a topic was sampled: rate, gaps, losses, jitter."""

from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.recording.recording import Counts, Floats, JointSeries, Recording
from trunk_ros.recording.signal.encoder import MEDIAN_TO_STD
from trunk_ros.recording.staggered import apart
from trunk_ros.recording.topics import TIP, TOPICS

_GAP = 2.5  # periods
_EVEN = 0.3  # of the period: with more spread than this, nothing was expected at a certain time


@dataclass(frozen=True)
class Quality:
    """Of a topic. period: median s between samples; jitter: its robust spread; longest_gap: s, at `gap_at` s.

    gaps: intervals of more than 2.5 periods. expected, lost: messages, from the period; None if it is uneven.
    """

    messages: int
    samples: int
    duplicates: int
    out_of_order: int
    not_finite: int
    unreadable: int
    period: float
    jitter: float
    longest_gap: float
    gap_at: float
    gaps: int
    expected: int | None
    lost: int | None

    @property
    def rate(self) -> float:
        """Samples per s, from the median period; 0 for a single sample."""
        return 1 / self.period if self.period else 0.0


def quality_of(stamp: Floats, counts: Counts | None = None) -> Quality:
    """Quality of a topic with these stamps (n,) s, rising; counts: what the reader saw of it."""
    counts = counts or Counts(messages=len(stamp))
    step = np.diff(stamp)
    seen = (counts.messages, len(stamp), counts.duplicates, counts.out_of_order, counts.not_finite)
    if not len(step):
        return Quality(*seen, counts.unreadable, 0.0, 0.0, 0.0, 0.0, 0, None, None)
    period = float(np.median(step))
    jitter = float(MEDIAN_TO_STD * np.median(np.abs(step - period)))
    missing = np.maximum(np.rint(step / period) - 1, 0)
    even = jitter < _EVEN * period
    lost = int(missing[step > 1.5 * period].sum()) if even else None
    longest = int(step.argmax())
    return Quality(
        *seen,
        counts.unreadable,
        period,
        jitter,
        float(step[longest]),
        float(stamp[longest]),
        int((step > _GAP * period).sum()) if even else 0,
        None if lost is None else len(stamp) + lost,
        lost,
    )


def quality_of_series(series: JointSeries, counts: Counts | None = None) -> Quality:
    """Quality of a topic; of one whose joints come at different times the worst, with the losses of all."""
    parts = [quality_of(part.stamp, counts) for part in apart(series)]
    worst = max(parts, key=lambda part: part.lost or 0)
    if len(parts) == 1 or any(part.lost is None for part in parts):
        return replace(worst, samples=len(series.stamp))
    lost = sum(part.lost or 0 for part in parts)
    found = {"samples": len(series.stamp), "expected": len(series.stamp) + lost, "lost": lost}
    return replace(worst, gaps=sum(part.gaps for part in parts), **found)


def of_one_stamp(recording: Recording) -> str:
    """What is said of topics whose messages all have one stamp; "" where there are none."""
    seen = {
        TOPICS[key]: recording.counts.get(key)
        for key, each in recording.series.items()
        if len(each.stamp) == 1
    }
    alike = [topic for topic, counts in seen.items() if counts is not None and counts.duplicates]
    if not alike:
        return ""
    return f"all messages of {', '.join(alike)} have one stamp: stamp each with the time of its readings"


def quality(recording: Recording) -> dict[str, Quality]:
    """Quality of every topic of a recording, by its key."""
    counts = recording.counts
    seen = {key: quality_of_series(each, counts.get(key)) for key, each in recording.series.items()}
    return seen if recording.tip is None else {**seen, TIP: quality_of(recording.tip.stamp, counts.get(TIP))}
