"""Claims about logs with a row for each message of any topic: what is repeated in them counts once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from trunk_ros.compiled import Array
from trunk_ros.data.merged_readings import between_messages
from trunk_ros.data.repeated_readings import new_readings
from trunk_ros.recording.recording import JointSeries

DRAWN = np.random.default_rng(5)
STAMP = np.cumsum(DRAWN.exponential(0.006, 6000))  # s, of rows
AT = np.cumsum(DRAWN.uniform(0.02, 0.06, 900))  # s, of messages of two joints


def merged(at: Array, angles: Array) -> Array:
    """Angles (k, joints) of messages at times (k,), in rows that have the last of them."""
    return np.asarray(angles[np.clip(np.searchsorted(at, STAMP, side="right") - 1, 0, None)])


def moved(at: Array) -> Array:
    return np.column_stack([np.sin(at), np.where(at < 12.0, np.cos(0.7 * at), np.cos(8.4))])


def test_messages_that_come_as_they_like_count_once_each() -> None:
    """One of the joints rests for the second half."""
    position = merged(AT, moved(AT) + DRAWN.normal(0.0, 1e-4, (len(AT), 2)))
    new, usual = new_readings(JointSeries(STAMP, ("a", "b"), position, None, None))
    assert usual == pytest.approx(0.04, rel=0.2)
    came = np.count_nonzero((np.diff(position, axis=0) != 0.0).any(axis=1))
    assert came <= len(new.stamp) < 1.1 * came
    off = new.position - moved(new.stamp)
    assert np.sqrt(np.mean(off**2)) < np.sqrt(np.mean((position - moved(STAMP)) ** 2))


def test_joints_that_are_read_by_themselves_come_in_no_messages() -> None:
    """Each of a clockless sensor of its own: nothing tells their readings from motions by fits and starts."""
    own = [merged(np.sort(DRAWN.uniform(0.0, STAMP[-1], 900)), moved(AT))[:, k] for k in range(2)]
    assert between_messages(STAMP, own) == 0.0
    series = JointSeries(STAMP, ("a", "b"), np.column_stack(own), None, None)
    assert new_readings(series) == (series, 0.0)


def test_a_joint_alone_tells_of_no_messages() -> None:
    assert between_messages(STAMP, [merged(AT, moved(AT))[:, 0]]) == 0.0


def test_readings_that_are_new_in_every_row_are_no_repeats() -> None:
    series = JointSeries(STAMP, ("a", "b"), moved(STAMP), None, None)
    noisy = replace(series, position=series.position + DRAWN.normal(0.0, 1e-4, series.position.shape))
    assert new_readings(noisy) == (noisy, 0.0)
