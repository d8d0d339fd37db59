"""Signals of a recording: one array per quantity, stamps in seconds since the recording's first sample."""

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from trunk_ros.errors import RecordingError

Floats: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Counts:
    """What a reader saw of one topic before it was sorted and cleaned."""

    messages: int = 0
    duplicates: int = 0
    out_of_order: int = 0
    not_finite: int = 0
    unreadable: int = 0
    blank: int = 0


@dataclass(frozen=True)
class JointSeries:
    """One JointState topic.

    stamp: (n,) s since `Recording.start_ns`, rising, unique. position, velocity, effort: (n, joints), in the
    unit of the joint (rad unless the recording says otherwise), per s, and N m or N; NaN where not known.
    """

    stamp: Floats
    joints: tuple[str, ...]
    position: Floats
    velocity: Floats | None = None
    effort: Floats | None = None

    def select(self, joints: tuple[str, ...]) -> "JointSeries":
        """The same series with these joints in this order; RecordingError names a joint that is not there."""
        if joints == self.joints:
            return self
        missing = [joint for joint in joints if joint not in self.joints]
        if missing:
            raise RecordingError(f"no joint {', '.join(missing)}: there are {', '.join(self.joints)}")
        columns = [self.joints.index(joint) for joint in joints]
        position, velocity, effort = (
            None if values is None else values[:, columns]
            for values in (self.position, self.velocity, self.effort)
        )
        assert position is not None
        return JointSeries(self.stamp, joints, position, velocity, effort)

    def between(self, first: float, end: float) -> "JointSeries":
        """The samples with first <= stamp < end, stamps unchanged."""
        return self.rows((self.stamp >= first) & (self.stamp < end))

    def rows(self, keep: npt.NDArray[np.bool_]) -> "JointSeries":
        """The samples chosen by `keep` (n,), stamps unchanged."""
        if np.asarray(keep).dtype == bool and np.all(keep):
            return self
        position, velocity, effort = (
            None if values is None else values[keep] for values in (self.position, self.velocity, self.effort)
        )
        assert position is not None
        return JointSeries(self.stamp[keep], self.joints, position, velocity, effort)

    def restamped(self, stamp: Floats) -> "JointSeries":
        """The samples at other stamps (n,) s; those that then come before earlier ones are left out."""
        rising = np.concatenate([[True], np.diff(np.maximum.accumulate(stamp)) > 0.0])
        return replace(self.rows(rising), stamp=stamp[rising])

    def positioned(self) -> "JointSeries":
        """The samples that have the position of a joint; all of them where none has."""
        known = np.asarray(np.isfinite(self.position).any(axis=1))
        return self if known.all() or not known.any() else self.rows(known)


@dataclass(frozen=True)
class PoseSeries:
    """Poses of the tip: stamp (n,) s, position (n, 3) m, orientation (n, 4) as x, y, z, w, in `frame`."""

    stamp: Floats
    position: Floats
    orientation: Floats
    frame: str = "base_link"

    def between(self, first: float, end: float) -> "PoseSeries":
        """The samples with first <= stamp < end, stamps unchanged."""
        keep = (self.stamp >= first) & (self.stamp < end)
        return PoseSeries(self.stamp[keep], self.position[keep], self.orientation[keep], self.frame)
