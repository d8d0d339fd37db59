"""A recording in memory: one array per quantity, all stamps in seconds since the recording's first sample."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy.typing as npt

from trunk_ros.errors import RecordingError
from trunk_ros.recording.arrays import Arrays, from_arrays, from_pandas, from_xarray
from trunk_ros.recording.check import checked
from trunk_ros.recording.identity import digest, identity
from trunk_ros.recording.observed import Observed
from trunk_ros.recording.series import Counts as Counts
from trunk_ros.recording.series import Floats as Floats
from trunk_ros.recording.series import JointSeries as JointSeries
from trunk_ros.recording.series import PoseSeries as PoseSeries
from trunk_ros.recording.topics import TIP, TOPICS


@dataclass(frozen=True)
class Recording:
    """All that one bag says about one arm.

    name: what to call it in messages. start_ns: stamp of its first sample, ns since the epoch. duration: s to
    its last sample; both hold for the whole recording, also when only a part of it was asked for.
    series: by `reference`, `setpoints`, `gearbox_states`, `joint_states`, `wire_states`, where recorded.
    notes: damage and oddities, in sentences. units: SI unit of position per joint that is not in rad.
    custom: what the writer noted in the bag. counts: per key of `series`, what the reader saw.
    description: the URDF of `robot_description`, where that was recorded.
    observed: what clocks and sensors were seen to do; mostly it was put right in `series`.
    asked: (first, end) s of the part that was asked for, where not all was.
    """

    name: str
    start_ns: int
    duration: float
    series: dict[str, JointSeries]
    tip: PoseSeries | None = None
    notes: tuple[str, ...] = ()
    units: dict[str, str] = field(default_factory=dict)
    custom: dict[str, str] = field(default_factory=dict)
    counts: dict[str, Counts] = field(default_factory=dict)
    description: str = ""
    observed: tuple[Observed, ...] = ()
    asked: tuple[float, float] | None = None
    content: str = ""
    """A digest of the samples as they were read; it stays that of the whole whatever is left out later."""

    def __post_init__(self) -> None:
        if not self.content:
            object.__setattr__(self, "content", digest(self.series))

    @property
    def stamped(self) -> str:
        """When it began and how long it is, in ns, and the digest: what tells it from other recordings."""
        return identity(self.start_ns, self.duration, self.content)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints of `joint_states`, else of the first other topic that has joints."""
        for key in ("joint_states", "gearbox_states", "setpoints", "reference"):
            if key in self.series:
                return self.series[key].joints
        return ()

    def unit(self, joint: str) -> str:
        """SI unit of this joint's position."""
        return self.units.get(joint, "rad")

    def require(self, key: str) -> JointSeries:
        """The series `key`, or RecordingError with the topics that are there."""
        if key in self.series:
            return self.series[key]
        there = ", ".join(TOPICS[each] for each in self.series) or "none that describe joints"
        raise RecordingError(f"{self.name}: no topic {TOPICS.get(key, key)}; topics there: {there}")

    @staticmethod
    def from_arrays(t: npt.ArrayLike, motor: Any = None, joint: Any = None, **others: Any) -> "Recording":
        """A recording of arrays with common stamps.

        t: (n,) s, rising. motor: (n, joints) motor-side angles; joint: (n, joints) joint angles, NaN where
        not known; one joint may come as (n,). setpoint, torque: likewise, of the motor. joints: their names,
        by default joint_1 and so on. unit: rad, deg, m, mm or 1. name: what to call it in messages.
        RecordingError where shapes do not fit.
        """
        return Recording._of(from_arrays(t, motor, joint, **others))

    @staticmethod
    def from_pandas(table: Any, motor: Any = None, joint: Any = None, **others: Any) -> "Recording":
        """A recording of the columns of a pandas table (or any that is like it).

        motor, joint, setpoint, torque: a column, a list of them, or {joint: column}; joints are named by
        `joint`. time: column of the stamps in s or as dates, by default the index. unit, name: as in
        `from_arrays`. RecordingError names a column that is not there.
        """
        return Recording._of(from_pandas(table, motor, joint, **others))

    @staticmethod
    def from_xarray(data: Any, motor: str = "motor", joint: str = "joint", **others: Any) -> "Recording":
        """A recording of the variables (time, joint) of an xarray data set.

        motor, joint, setpoint, torque: names of variables; time: name of their dimension of time. Joints are
        named by the coordinate of the other dimension, if it has one.
        """
        return Recording._of(from_xarray(data, motor, joint, **others))

    @staticmethod
    def _of(given: Arrays) -> "Recording":
        duration = float(given.stamp[-1])
        return Recording(given.name, 0, duration, given.series, units=given.units).checked()

    def checked(self) -> "Recording":
        """The recording without velocities and efforts that say nothing; RecordingError for a joint without
        a single finite value.
        """
        return replace(self, series=checked(self.name, self.series, self.tip))

    def part(self, first: float, end: float) -> "Recording":
        """The samples with first <= stamp < end; stamps, start and duration stay those of the whole."""
        series = {key: each.between(first, end) for key, each in self.series.items()}
        kept = {key: each for key, each in series.items() if len(each.stamp)}
        tip = self.tip.between(first, end) if self.tip else None
        tip = tip if tip is not None and len(tip.stamp) else None
        lost = [key for key in series if key not in kept]
        lost += [TIP] if self.tip and not tip else []
        notes = tuple(f"{TOPICS[key]}: no sample from {first:g} to {end:g} s" for key in lost)
        asked = None if first <= 0.0 and end > self.duration else (first, min(end, self.duration))
        return replace(self, series=kept, tip=tip, notes=self.notes + notes, asked=asked)
