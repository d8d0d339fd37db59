"""Two recordings of the same run, sample by sample: where they differ, and by how much."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from trunk_ros.recording.recording import Floats, JointSeries, PoseSeries, Recording
from trunk_ros.recording.topics import TIP_TOPIC, TOPICS

_AXES = ("x", "y", "z", "qx", "qy", "qz", "qw")


@dataclass(frozen=True)
class Difference:
    """One quantity of a topic. compared: samples of the same stamp, of so many recorded ones.

    largest: NaN where nothing could be compared; of `name`, at `stamp` s since the start. rms: over all.
    """

    topic: str
    quantity: str
    unit: str
    recorded: int
    compared: int
    largest: float
    rms: float
    name: str
    stamp: float


def differences(recorded: Recording, computed: Recording) -> list[Difference]:
    """Every quantity that both have, joints matched by name, samples by stamp [ns since the epoch]."""
    found = []
    for key in computed.series:
        if key in recorded.series:
            found += list(_of_joints(recorded, computed, key))
    if recorded.tip is not None and computed.tip is not None:
        found += list(_of_tip(recorded, computed, recorded.tip, computed.tip))
    return found


def _of_joints(recorded: Recording, computed: Recording, key: str) -> Iterator[Difference]:
    one, other = recorded.series[key], computed.series[key]
    joints = tuple(joint for joint in one.joints if joint in other.joints)
    if not joints:
        return
    here, there = _same_stamps(_ns(recorded, one.stamp), _ns(computed, other.stamp))
    for quantity in ("position", "velocity", "effort"):
        left, right = (_values(each.select(joints), quantity) for each in (one, other))
        if left is not None and right is not None:
            unit = _unit(key, quantity)
            yield _difference(TOPICS[key], quantity, unit, joints, one.stamp, left, right, here, there)


def _of_tip(
    recorded: Recording, computed: Recording, one: PoseSeries, other: PoseSeries
) -> Iterator[Difference]:
    here, there = _same_stamps(_ns(recorded, one.stamp), _ns(computed, other.stamp))
    for quantity, unit, axes in (("position", "m", _AXES[:3]), ("orientation", "1", _AXES[3:])):
        left, right = getattr(one, quantity), getattr(other, quantity)
        yield _difference(TIP_TOPIC, quantity, unit, axes, one.stamp, left, right, here, there)


def _difference(
    topic: str,
    quantity: str,
    unit: str,
    names: Sequence[str],
    stamp: Floats,
    left: Floats,
    right: Floats,
    here: "np.typing.NDArray[np.intp]",
    there: "np.typing.NDArray[np.intp]",
) -> Difference:
    error = np.abs(left[here] - right[there])
    known = np.isfinite(error).any(axis=1)
    if not known.any():
        return Difference(topic, quantity, unit, len(stamp), 0, np.nan, np.nan, "", np.nan)
    row, column = np.unravel_index(int(np.nanargmax(error)), error.shape)
    largest, rms = float(error[row, column]), float(np.sqrt(np.nanmean(error**2)))
    at = float(stamp[here][row])
    return Difference(
        topic, quantity, unit, len(stamp), int(known.sum()), largest, rms, names[int(column)], at
    )


def _values(series: JointSeries, quantity: str) -> Floats | None:
    values: Floats | None = getattr(series, quantity)
    return values


def _unit(key: str, quantity: str) -> str:
    units = {"position": "rad", "velocity": "rad/s", "effort": "N*m"}
    return {"position": "m", "effort": "N"}.get(quantity, "m/s") if key == "wire_states" else units[quantity]


def _ns(recording: Recording, stamp: Floats) -> "np.typing.NDArray[np.int64]":
    return recording.start_ns + np.rint(stamp * 1e9).astype(np.int64)


def _same_stamps(
    one: "np.typing.NDArray[np.int64]", other: "np.typing.NDArray[np.int64]"
) -> "tuple[np.typing.NDArray[np.intp], np.typing.NDArray[np.intp]]":
    _, here, there = np.intersect1d(one, other, return_indices=True)
    return here, there


def table(found: Sequence[Difference]) -> list[str]:
    """Lines of a table, its head first."""
    rows = [("topic", "quantity", "compared", "largest difference", "rms", "where")]
    for each in found:
        where = f"{each.name} at {each.stamp:.3f} s" if each.largest > 0 else ""
        unit = each.unit
        values = (f"{each.largest:.3g} {unit}", f"{each.rms:.3g} {unit}") if each.compared else ("", "")
        rows.append((each.topic, each.quantity, f"{each.compared} of {each.recorded}", *values, where))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
