"""The series of a recording from arrays and tables in memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from trunk_ros.errors import RecordingError
from trunk_ros.recording.importing.units import UNITS
from trunk_ros.recording.series import Floats, JointSeries

ELSEWHERE = (
    "arrays (.mat, .npz, .h5, .parquet) come in by Recording.from_arrays or from_pandas of "
    "trunk_ros.recording.recording in Python, or saved as CSV by `trunk_ros import`"
)
"""Where to go with a file that no reader takes."""

Columns = str | Sequence[str] | Mapping[str, str]


@dataclass(frozen=True)
class Arrays:
    """What arrays make of a recording: stamps (n,) s, its series, the units of joints that are not in rad."""

    name: str
    stamp: Floats
    series: dict[str, JointSeries]
    units: dict[str, str]


def from_arrays(
    t: npt.ArrayLike,
    motor: npt.ArrayLike | None = None,
    joint: npt.ArrayLike | None = None,
    *,
    setpoint: npt.ArrayLike | None = None,
    torque: npt.ArrayLike | None = None,
    joints: Sequence[str] | None = None,
    unit: str = "rad",
    name: str = "arrays",
) -> Arrays:
    """The series of arrays with common stamps ``t`` (n,) s; see ``Recording.from_arrays``."""
    stamp = _stamps(t)
    if unit not in UNITS or UNITS[unit][0] not in ("rad", "m", "1"):
        raise RecordingError(f"{name}: unit {unit!r} is none of a joint: rad, deg, m, mm or 1")
    si, factor = UNITS[unit]
    given = {"setpoints": setpoint, "gearbox_states": motor, "joint_states": joint}
    known = {key: each for key, each in given.items() if each is not None}
    values = {key: factor * _columns(key, each, len(stamp)) for key, each in known.items()}
    if not values:
        raise RecordingError(f"{name}: give motor and joint, or setpoint and motor")
    count = next(iter(values.values())).shape[1]
    names = tuple(joints or (f"joint_{number + 1}" for number in range(count)))
    for key, each in values.items():
        if each.shape[1] != len(names):
            raise RecordingError(f"{name}: {key} has {each.shape[1]} columns for {len(names)} joints")
    effort = None if torque is None else _columns("torque", torque, len(stamp))
    series = {
        key: JointSeries(stamp, names, each, None, effort if key == "gearbox_states" else None).positioned()
        for key, each in values.items()
    }
    units = {} if si == "rad" else dict.fromkeys(names, si)
    return Arrays(name, stamp, series, units)


def from_pandas(
    table: Any,
    motor: Columns | None = None,
    joint: Columns | None = None,
    *,
    time: str | None = None,
    setpoint: Columns | None = None,
    torque: Columns | None = None,
    unit: str = "rad",
    name: str = "table",
) -> Arrays:
    """The series of the columns of a table; see ``Recording.from_pandas``."""
    stamp = table.index if time is None else table[time]
    chosen = {"motor": motor, "joint": joint, "setpoint": setpoint, "torque": torque}
    given = {key: _named(each) for key, each in chosen.items() if each is not None}
    missing = [c for each in given.values() for c in each.values() if c not in table.columns]
    if missing:
        there = ", ".join(map(str, table.columns))
        raise RecordingError(f"{name}: no column {missing[0]!r}: there are {there}")
    joints = list(given.get("joint") or next(iter(given.values()), {}))
    arrays = {key: np.column_stack([table[c] for c in each.values()]) for key, each in given.items()}
    return from_arrays(_seconds(np.asarray(stamp)), **arrays, joints=joints, unit=unit, name=name)


def from_xarray(
    data: Any,
    motor: str = "motor",
    joint: str = "joint",
    *,
    time: str = "time",
    unit: str = "rad",
    **others: str,
) -> Arrays:
    """The series of the variables of a data set; see ``Recording.from_xarray``."""
    chosen = {"motor": motor, "joint": joint, **others}
    there = {key: data[each] for key, each in chosen.items() if each in data}
    arrays = {key: each.transpose(time, ...).to_numpy() for key, each in there.items()}
    along = [dim for each in there.values() for dim in each.dims if dim != time]
    named = bool(along) and along[0] in data.coords
    joints = [str(label) for label in data[along[0]].to_numpy()] if named else None
    return from_arrays(_seconds(data[time].to_numpy()), **arrays, joints=joints, unit=unit, name="data set")


def _named(columns: Columns) -> dict[str, str]:
    """Column by joint."""
    if isinstance(columns, Mapping):
        return dict(columns)
    names = [columns] if isinstance(columns, str) else list(columns)
    return {name: name for name in names}


def _seconds(stamp: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Dates as s since the first."""
    if np.issubdtype(stamp.dtype, np.datetime64) or np.issubdtype(stamp.dtype, np.timedelta64):
        return np.asarray((stamp - stamp[0]) / np.timedelta64(1, "s"))
    return stamp


def _stamps(t: npt.ArrayLike) -> Floats:
    stamp = np.asarray(t, dtype=np.float64)
    if stamp.ndim != 1 or len(stamp) < 2:
        raise RecordingError(f"t has the shape {stamp.shape}: give the time of each sample, (n,) s")
    if not np.isfinite(stamp).all() or (np.diff(stamp) <= 0.0).any():
        raise RecordingError("t must rise from sample to sample, in s")
    return np.asarray(stamp - stamp[0])


def _columns(key: str, values: npt.ArrayLike, rows: int) -> Floats:
    """(n, joints); one joint may come as (n,)."""
    array = np.asarray(values, dtype=np.float64)
    array = array[:, None] if array.ndim == 1 else array
    if array.ndim != 2 or len(array) != rows:
        raise RecordingError(f"{key} has the shape {array.shape}: give ({rows}, joints), a row a stamp")
    return array
