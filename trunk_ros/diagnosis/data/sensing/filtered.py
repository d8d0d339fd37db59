"""Joint readings that were low-pass filtered: from one to the next they tell nothing new."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.noise import is_none
from trunk_ros.diagnosis.data.sensing.physics import CLOCKED
from trunk_ros.diagnosis.levels import SEVERAL, TENFOLD
from trunk_ros.guards import BLIND, TINY
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.fill import fill
from trunk_ros.recording.signal.resample import SLOW, longest_gap, resample

BANDS = 2  # of an octave


@dataclass(frozen=True)
class Filtered:
    """The ``frequency`` [Hz] at which readings have half the noise that they have below, and how many of them
    tell as much as one.
    """

    frequency: float
    alike: int


def filtered(gearbox: JointSeries, shown: JointSeries) -> Filtered | None:
    """How readings of series with the same joints were filtered; None where no edge shows.

    What motors do not say of a joint, linearly, by frequency, is noise and the rest of physics. Noise is
    level, or that of a lag of first order, and friction falls with the fourth power of the frequency at most:
    nothing but a filter of more poles makes what hardly falls for two octaves fall by 10^4 over the next two.
    What readings of the motors scatter is no noise of the joints.
    """
    shown = _in_one_run(shown.rows((shown.stamp >= gearbox.stamp[0]) & (shown.stamp <= gearbox.stamp[-1])))
    if len(shown.stamp) < CLOCKED:
        return None
    step = float(np.mean(np.diff(shown.stamp)))
    driven, read = resample(gearbox, shown.stamp)[0], fill(shown.position)
    lives = np.ptp(read, axis=0) > 0.0
    if not lives.any() or step >= SLOW / SEVERAL:
        return None
    frequency, left, motors = densities(driven, read[:, lives], step)
    level, wide = np.log10(left + TINY).mean(axis=1), SEVERAL * BANDS
    for k in range(wide, len(level) - wide):
        before, after = level[k - wide] - level[k], level[k] - level[k + wide]
        plain = abs(before) <= SEVERAL and after >= SEVERAL**2
        own = 10.0 ** level[k - wide] > TENFOLD * motors[k + wide]
        if plain and own and not is_none(10.0 ** (level[k - wide] / 2) * frequency[k] ** 0.5):
            half = _half(np.log2(frequency), level, k)
            alike = min(int(0.5 / (half * step)), ceil(SLOW / step) - 1)
            return Filtered(half, alike) if alike > 1 else None
    return None


def densities(driven: Array, read: Array, step: float) -> tuple[Array, Array, Array]:
    """(bands,) Hz, (bands, joints) rad²/Hz of what motors (n, motors) do not say linearly of joints
    (n, joints), and (bands,) of what the motors' own readings are on the joints' side, in the mean.
    """
    window = np.hanning(len(read))[:, None]
    own, asked = (np.fft.rfft((each - each.mean(axis=0)) * window, axis=0) for each in (read, driven))
    gain = np.linalg.lstsq(asked, own, rcond=BLIND)[0]
    unit = 2.0 * step / float(np.sum(window**2))
    octaves = int(BANDS * np.log2(len(own)))
    ends = np.rint((len(own) - 1) * 2.0 ** (-np.arange(octaves)[::-1] / BANDS)).astype(int)
    out = []
    for first, last in zip(ends[:-1], ends[1:], strict=True):
        free = last - first - asked.shape[1]
        if free > asked.shape[1]:
            one, other = own[first:last], asked[first:last] / np.maximum(_size(asked[first:last]), TINY)
            rest = one - other @ np.linalg.lstsq(other, one, rcond=BLIND)[0]
            moved = _size(asked[first:last] @ gain) ** 2 / (last - first)
            middle = np.sqrt(first * last) / (len(read) * step)
            out.append((middle, unit * _size(rest) ** 2 / free, unit * np.exp(np.log(moved + TINY).mean())))
    if not out:
        return np.empty(0), np.empty((0, own.shape[1])), np.empty(0)
    return tuple(np.array(each) for each in zip(*out, strict=True))  # type: ignore[return-value]


def _size(waves: Array) -> Array:
    """(k,) of waves (bins, k)."""
    return np.asarray(np.linalg.norm(waves, axis=0))


def _half(octave: Array, level: Array, k: int) -> float:
    """Hz where a ``level`` (bands,), decades over octaves (bands,), is half of what it was as it went on
    before the edge at band ``k``.
    """
    wide = SEVERAL * BANDS
    slope = min((level[k - wide // 2] - level[k - wide]) / (octave[k - wide // 2] - octave[k - wide]), 0.0)
    below = level[k - wide] + slope * (octave - octave[k - wide]) - np.log10(2.0) - level
    last = k - wide // 2 + int(np.argmax(below[k - wide // 2 :] > 0.0))
    share = below[last] / (below[last] - below[last - 1])
    return float(2.0 ** (octave[last] - share * (octave[last] - octave[last - 1])))


def _in_one_run(series: JointSeries) -> JointSeries:
    """The most readings that follow each other without a gap."""
    ends = np.concatenate([[0], 1 + np.flatnonzero(np.diff(series.stamp) > longest_gap(series.stamp)),
                           [len(series.stamp)]])  # fmt: skip
    longest = int(np.argmax(np.diff(ends)))
    return series.rows(slice(int(ends[longest]), int(ends[longest + 1])))
