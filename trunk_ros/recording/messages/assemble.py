"""Sorts what was decoded of a topic into a series: rising stamps, joints by name, duplicates counted."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from trunk_ros.recording.check import is_reading
from trunk_ros.recording.messages.block import DamageError, Whole
from trunk_ros.recording.messages.decode import Piece
from trunk_ros.recording.messages.layout import MOST_JOINTS
from trunk_ros.recording.recording import Counts, Floats, JointSeries
from trunk_ros.recording.restarts import began_anew

Bools: TypeAlias = npt.NDArray[np.bool_]

_LAST_NS = 2**62  # 2116: what a damaged file has beyond would overflow in differences
_SANE_NS = 10**17  # 1973: stamps beyond are wall clock, and a zero among them was never set


def sample_times(stamp_ns: Whole, log_ns: Whole) -> tuple[Whole, str]:
    """(n,) ns at which the samples were taken, and what had to be done about stamps that were never set."""
    log_ns = np.clip(log_ns, 0, _LAST_NS)
    unset = stamp_ns == 0
    if len(unset) > 1 and unset.all():
        return log_ns, "no message has a stamp: the time of recording is taken instead"
    if unset.any() and np.median(stamp_ns) > _SANE_NS:
        text = f"{int(unset.sum())} messages have no stamp: their time of recording is taken instead"
        return np.where(unset, log_ns, stamp_ns), text
    return stamp_ns, ""


def all_times(pieces: list[Piece]) -> Whole:
    """(n,) ns since the epoch of all samples, in the order of the pieces."""
    return sample_times(_joined(pieces, "stamp_ns"), _joined(pieces, "log_ns"))[0]


def first_stamp(pieces: list[Piece]) -> int:
    """The earliest sample, ns since the epoch."""
    return int(all_times(pieces).min())


def several_runs(pieces: list[Piece]) -> str:
    """Where the stamps of a piece begin anew, as a simulation's clock does, in one line; "" where none do."""
    for piece in pieces:
        times, since = sample_times(piece.stamp_ns, piece.log_ns)[0], _since(piece.log_ns)
        if anew := began_anew(times, since):
            return f"{anew}. Cut the bag there, one run per bag"
    return ""


def _since(log_ns: Whole) -> Callable[[int], str]:
    return lambda k: f"message {k + 1}, recorded {(log_ns[k] - log_ns[0]) / 1e9:.6g} s after the first"


def positioned(pieces: list[Piece]) -> tuple[list[Piece], int]:
    """The pieces without messages that have no position of any joint, and how many those are.

    Joints of which there is no position at all stay, so that they can be named.
    """
    known = [_positions(piece) for piece in pieces]
    there = {joint for piece, rows in zip(pieces, known, strict=True) for joint in piece.joints if rows.any()}
    kept, blank = [], 0
    for piece, rows in zip(pieces, known, strict=True):
        if rows.all() or not there.issuperset(piece.joints):
            kept.append(piece)
            continue
        blank += int((~rows).sum())
        kept += [piece.rows(rows)] if rows.any() else []
    return kept, blank


def _positions(piece: Piece) -> Bools:
    """(n,): the messages that have the position of a joint."""
    if piece.position is None:
        return np.zeros(len(piece.place), dtype=bool)
    return np.asarray(is_reading(piece.position).any(axis=1))


def within(pieces: list[Piece], first_ns: int, end_ns: int) -> list[Piece]:
    """The samples with first_ns <= time < end_ns."""
    times, begin, kept = all_times(pieces), 0, []
    for piece in pieces:
        part = times[begin : begin + len(piece.place)]
        begin += len(part)
        rows = (part >= first_ns) & (part < end_ns)
        if rows.any():
            kept.append(piece if rows.all() else piece.rows(rows))
    return kept


def table_bytes(pieces: list[Piece]) -> int:
    """Bytes of one quantity of all pieces: each message is a row, each joint of any message a column."""
    joints = {joint for piece in pieces for joint in piece.joints}
    return 8 * len(joints) * sum(len(piece.place) for piece in pieces)


def joint_series(pieces: list[Piece], start_ns: int) -> tuple[JointSeries, Counts, str]:
    """One series of all pieces with stamps since `start_ns`, what was counted, and a remark or "".

    A message that repeats a stamp counts only for joints that no earlier message of that stamp has given.
    """
    joints = tuple(dict.fromkeys(joint for piece in pieces for joint in piece.joints))
    if len(joints) > MOST_JOINTS:
        raise DamageError(f"names {len(joints)} different joints in one topic")
    stamp_ns, remark = sample_times(_joined(pieces, "stamp_ns"), _joined(pieces, "log_ns"))
    place = _joined(pieces, "place")
    order = np.lexsort((place, stamp_ns))
    unique, row = np.unique(stamp_ns[order], return_inverse=True)
    source, used = _sources(_named(pieces, joints)[order], row, len(unique))
    position, velocity, effort = (
        _values(pieces, joints, order, source, which) for which in ("position", "velocity", "effort")
    )
    counts = Counts(
        messages=len(place),
        duplicates=int((~used).sum()),
        out_of_order=int((np.diff(stamp_ns[np.argsort(place)]) < 0).sum()),
        not_finite=sum(_not_finite(piece) for piece in pieces),
    )
    if position is None:
        position = np.full((len(unique), len(joints)), np.nan)
    return JointSeries((unique - start_ns) / 1e9, joints, position, velocity, effort), counts, remark


def _joined(pieces: list[Piece], name: str) -> Whole:
    whole: Whole = np.concatenate([getattr(piece, name) for piece in pieces])
    return whole


def _named(pieces: list[Piece], joints: tuple[str, ...]) -> Bools:
    """(messages, joints): which joints each message names."""
    return np.concatenate(
        [np.tile([joint in piece.joints for joint in joints], (len(piece.place), 1)) for piece in pieces]
    )


def _sources(named: Bools, row: Whole, rows: int) -> tuple[Whole, Bools]:
    """(rows, joints): the sorted message that gives each value, -1 for none; and which messages give any."""
    source = np.full((rows, named.shape[1]), -1, dtype=np.int64)
    used = np.zeros(len(named), dtype=bool)
    for joint in range(named.shape[1]):
        messages = np.flatnonzero(named[:, joint])
        at, first = np.unique(row[messages], return_index=True)
        source[at, joint] = messages[first]
        used[messages[first]] = True
    return source, used


def _values(
    pieces: list[Piece], joints: tuple[str, ...], order: Whole, source: Whole, which: str
) -> Floats | None:
    """(rows, joints) of one quantity, NaN where no message gives it; None where no message gives any."""
    if all(getattr(piece, which) is None for piece in pieces):
        return None
    whole = np.full((len(order), len(joints)), np.nan)
    begin = 0
    for piece in pieces:
        end = begin + len(piece.place)
        if (values := getattr(piece, which)) is not None:
            whole[begin:end, [joints.index(joint) for joint in piece.joints]] = values
        begin = end
    out = np.empty(source.shape)
    for joint, (found, message) in enumerate(zip(whole.T, source.T, strict=True)):  # all at once is much
        picked = found[order[message]]
        out[:, joint] = np.where((message < 0) | ~is_reading(picked), np.nan, picked)
    return out


def _not_finite(piece: Piece) -> int:
    values = [each for each in (piece.position, piece.velocity, piece.effort) if each is not None]
    return sum(int(each.size - is_reading(each).sum()) for each in values)
