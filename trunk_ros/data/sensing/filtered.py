"""Joint readings that were low-pass filtered: from one to the next they tell nothing new."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.noise import is_none
from trunk_ros.data.sensing.physics import CLOCKED, while_driven
from trunk_ros.guards import BLIND, TINY
from trunk_ros.levels import HALF, PART, ROUGHLY, SEVERAL, TENFOLD
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.encoder import counts
from trunk_ros.recording.signal.fill import fill
from trunk_ros.recording.signal.gaps import runs
from trunk_ros.recording.signal.resample import SLOW, longest_gap, resample

OCTAVE = 2  # bands
FREE = 4  # values that a wave takes in a while of which it is asked how strong it is


@dataclass(frozen=True)
class Filtered:
    """The ``frequency`` [Hz] at which readings have half the noise that they have below, and how many of them
    tell as much as one.
    """

    frequency: float
    alike: int


def filtered(gearbox: JointSeries, shown: JointSeries) -> Filtered | None:
    """How readings of series with the same joints were filtered; None where that does not show.

    What motors do not say of a joint, linearly, by frequency, is noise and the rest of physics. Noise that is
    level over two octaves and falls by 100 over the next two has more than one pole (asked of two joints at
    least), and nothing that falls a little before falls by 10^4, but by a filter. A link that swings on its
    wire does so as well, but with a peak, with noise of its sensor below all that it does, at any frequency,
    and it comes to rest. What readings of the motors scatter is no noise of the joints.
    """
    shown = _in_one_run(while_driven(gearbox, shown))
    if len(shown.stamp) < CLOCKED:
        return None
    step, read = float(np.mean(np.diff(shown.stamp))), _smoothly(shown.position)
    lives = np.ptp(read, axis=0) > 0.0
    if not lives.any() or step >= SLOW / SEVERAL:
        return None
    read = read if lives.all() else read[:, lives]
    seen = Densities.of(resample(gearbox, shown.stamp)[0], read, step)
    level, wide = np.log10(seen.left + TINY).mean(axis=1), SEVERAL * OCTAVE
    if len(level) <= 2 * wide or not _falls(level, counts(shown)[lives], step):
        return None
    for k in range(wide, len(level) - wide):
        before, after = level[k - wide] - level[k], level[k] - level[k + wide]
        peak = np.diff(level[k - wide : k + wide + 1]).max() > np.log10(SEVERAL)
        steep = after >= SEVERAL**2
        two_poles = after >= SEVERAL and before <= HALF and lives.sum() >= SEVERAL
        if peak or not (two_poles or (steep and before <= SEVERAL)):
            continue
        size = 10.0 ** level[k - wide]
        own = size > TENFOLD * seen.driven[k + wide] and not is_none(float(np.sqrt(size * seen.middle[k])))
        if own and seen.goes_on(k):
            half = _half(np.log2(seen.middle), level, k)
            alike = min(int(0.5 / (half * step)), ceil(SLOW / step) - 1)
            return Filtered(half, alike) if alike > SEVERAL else None
    return None


def _falls(level: Array, steps: Array, step: float) -> bool:
    """Whether a ``level`` (bands,), decades of rad²/Hz, falls on to half the rate as no noise of one pole
    does, or to nothing, or to what ``steps`` (joints,) rad of the readings make.
    """
    rounded = np.log10(step * steps**2 / 6.0 + TINY).mean()
    nothing = is_none(10.0 ** (level[-1] / 2) / np.sqrt(2.0 * step))
    return bool(level[-1 - OCTAVE] - level[-1] > np.log10(TENFOLD) or nothing or level[-1] < rounded + HALF)


@dataclass(frozen=True)
class Densities:
    """By bands of frequency, with their ``middle`` (bands,) Hz: what is ``left`` (bands, joints) rad²/Hz of
    joints but for what motors say linearly, and what the motors' readings do on the joints' side, ``driven``
    (bands,).

    ``rest`` (frequencies, joints), waves of what is left; ``ends`` (bands, 2) of the bands among these.
    """

    middle: Array
    left: Array
    driven: Array
    rest: np.ndarray
    ends: np.ndarray

    @classmethod
    def of(cls, driven: Array, read: Array, step: float) -> Densities:
        """Of readings (n, motors) and (n, joints) that are a ``step`` s apart."""
        window = np.hanning(len(read))
        own, asked = (_waves(each, window) for each in (read, driven))
        gain = np.linalg.lstsq(asked, own, rcond=BLIND)[0]
        unit = 2.0 * step / float(np.sum(window**2))
        octaves = int(OCTAVE * np.log2(len(own)))
        edges = np.rint((len(own) - 1) * 2.0 ** (-np.arange(octaves)[::-1] / OCTAVE)).astype(int)
        each = np.column_stack([edges[:-1], edges[1:]])
        each = each[np.diff(each, axis=1)[:, 0] > 2 * asked.shape[1]]
        rest, left, moved = np.zeros_like(own), np.empty((len(each), own.shape[1])), np.empty(len(each))
        for k, (first, last) in enumerate(each):
            one, size = asked[first:last], np.maximum(_size(asked[first:last]), TINY)
            told = np.linalg.lstsq(one / size, own[first:last], rcond=BLIND)[0]
            rest[first:last] = own[first:last] - one / size @ told
            left[k] = unit * _size(rest[first:last]) ** 2 / (last - first - asked.shape[1])
            moved[k] = np.exp(np.log(unit * _size(one @ gain) ** 2 / (last - first) + TINY).mean())
        return cls(np.sqrt(each.prod(axis=1)) / (len(read) * step), left, moved, rest, each)

    def goes_on(self, k: int) -> bool:
        """Whether what is left in two octaves from a band on is there all the time, as noise is."""
        first, last = self.ends[k, 0], self.ends[k + SEVERAL * OCTAVE, 0]
        count, joints = 2 * (len(self.rest) - 1), self.rest.shape[1]
        near = np.ones(FREE**2) / FREE**2  # bins, so that a steep edge leaves as many waves as there are
        size = np.column_stack([np.convolve(np.abs(each) ** 2, near, "same") for each in self.rest.T])
        wave = np.zeros((count, joints), dtype=complex)
        wave[first:last] = self.rest[first:last] / np.sqrt(size[first:last] + TINY)
        whole = slice(count // 4, -(count // 4))
        wave = np.fft.ifft(wave, axis=0)[whole] / np.hanning(count)[whole, None]
        length = FREE * count // (last - first)
        parts = np.abs(wave[: len(wave) // length * length].reshape(-1, length, joints)) ** 2
        power = parts.mean(axis=1)
        quiet = np.quantile(power, PART, axis=0) / power.mean(axis=0)
        return bool(np.log(quiet).mean() > np.log(ROUGHLY))


def _smoothly(values: Array) -> Array:
    """(n, joints) with missing values on a cubic spline through the others: corners of a straight line there
    are noise above any edge.
    """
    from scipy.interpolate import CubicSpline  # of few recordings: importing it takes 0.3 s

    out = fill(values)
    rows, known = np.arange(len(values)), np.isfinite(values)
    for j in np.flatnonzero(~known.all(axis=0) & (known.sum(axis=0) > 1)):
        inner = slice(*np.flatnonzero(known[:, j])[[0, -1]])
        missing = rows[inner][~known[inner, j]]
        out[missing, j] = CubicSpline(rows[known[:, j]], values[known[:, j], j])(missing)
    return out


def _waves(signals: Array, window: Array) -> np.ndarray:
    """(frequencies, k) of signals (n, k) but for their means, seen through a ``window`` (n,)."""
    pairs = zip(signals.T, signals.mean(axis=0), strict=True)
    return np.column_stack([np.fft.rfft((signal - mean) * window) for signal, mean in pairs])


def _size(waves: np.ndarray) -> Array:
    """(k,) of waves (bins, k)."""
    return np.asarray(np.linalg.norm(waves, axis=0))


def _half(octave: Array, level: Array, k: int) -> float:
    """Hz where a ``level`` (bands,), decades over octaves (bands,), is half of what it was as it went on
    before the edge at band ``k``.
    """
    wide = SEVERAL * OCTAVE
    slope = min((level[k - wide // 2] - level[k - wide]) / (octave[k - wide // 2] - octave[k - wide]), 0.0)
    below = level[k - wide] + slope * (octave - octave[k - wide]) - np.log10(2.0) - level
    last = k - wide // 2 + int(np.argmax(below[k - wide // 2 :] > 0.0))
    share = below[last] / (below[last] - below[last - 1])
    return float(2.0 ** (octave[last] - share * (octave[last] - octave[last - 1])))


def _in_one_run(series: JointSeries) -> JointSeries:
    """The most readings that follow each other without a gap."""
    near = runs(np.diff(series.stamp) <= longest_gap(series.stamp))
    first, last = max(near, key=np.ptp, default=(0, 0))
    rows = np.arange(len(series.stamp))
    return series.rows((rows >= first) & (rows <= last))
