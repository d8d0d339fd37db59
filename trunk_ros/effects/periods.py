"""Where a residual swings periodically over something."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.cubic import cubic

CELLS = 8.0  # per shortest period
MOST = 1000  # cells per value: in wider ranges a line cannot be told from its neighbours
SAME = 1e-6  # of a step: a line at the edge of the range is outside, however that is rounded
ENOUGH = 2**17  # samples: more of them tell no more of how a residual is bent
SHOWN = 4  # samples per period, at least: so many show it
FINER = 8  # steps of the search per period that the range cannot hold
ALIKE = 0.9  # of the places: where so many show one phase of a wave, another one looks like it


def positive(values: dict[str, float], amplitude: str, phase: str) -> dict[str, float]:
    """A swing with a positive amplitude and a phase [rad] in (-pi, pi]."""
    turned = np.pi if values.get(amplitude, 0.0) < 0.0 else 0.0
    wrapped = np.pi - (np.pi - values[phase] - turned) % (2 * np.pi)
    return {**values, phase: float(wrapped)} | (
        {amplitude: abs(values[amplitude])} if amplitude in values else {}
    )


def finest(x: Array) -> float:
    """The most periods per turn that samples of a shaft (n,) rad show on half of its way, or per 2 pi m of a
    slide; no more than that there are samples.
    """
    moved = np.sort(np.abs(np.diff(x)))
    way = np.cumsum(moved)
    if not len(way) or way[-1] == 0.0:
        return 0.0
    usual = max(moved[np.searchsorted(way, way[-1] / 2.0)], float(np.ptp(x)) / len(x))
    return float(2 * np.pi / (SHOWN * usual))


def periods(x: Array, rest: Array, low: float, high: float, most: int = 3) -> tuple[float, ...]:
    """The strongest lines of ``rest`` (n,) over ``x`` (n,) rad, in periods per turn, between ``low`` and
    ``high``, or what the places of ``x`` show no finer than; the strongest first.

    Source: Schuster (1898), the periodogram, of the sums in narrow cells of ``x``.
    """
    cell = 2 * np.pi / (CELLS * high)
    if not 0.0 < np.ptp(x) < MOST * len(x) * cell or not np.any(rest):
        return ()
    some = slice(None, None, max(len(x) // ENOUGH, 1))
    place = ((x - x.min()) / cell).astype(int)
    many = _together(int(place.max()) + 1)
    turn = 2 * np.pi / (FINER * many * cell)
    high = min(high, turn * _folds_at(place, many, int(np.ceil(2.0 * high / turn))))
    sums = np.bincount(place, weights=rest - cubic(x[some], rest[some], x))
    power = np.zeros(int(np.ceil(high / turn - SAME)) + 2)
    power[:-2] = _lines(sums, many, len(power) - 2)
    power[: int(low / turn + SAME) + 1] = 0.0
    peaks = 1 + np.flatnonzero((power[1:-1] >= power[:-2]) & (power[1:-1] > power[2:]))
    return tuple((turn * peaks[np.argsort(-power[peaks])][:most]).tolist())


def _together(cells: int) -> int:
    """How many cells a spectrum is taken of: of long recordings as many as take no further memory."""
    if cells <= ENOUGH:
        return cells
    from scipy.fft import next_fast_len  # of searches alone: importing it takes a node 0.2 s

    return int(next_fast_len(cells))


def _lines(sums: Array | np.ndarray, many: int, most: int) -> Array:
    """The first ``most`` lines of a spectrum of ``many`` cells in FINER steps each, of ``sums`` (n,) and
    nothing behind them. One step after the other: all at once they take FINER times the memory.
    """
    from scipy.fft import fft  # of searches alone: importing it takes a node 0.2 s

    own, both = ("float64", "complex128") if many <= ENOUGH else ("float32", "complex64")
    step = np.zeros(len(sums), both)
    step.imag = np.arange(len(sums), dtype=own) * (-2.0 * np.pi / (FINER * many))
    np.exp(step, out=step)
    turned, out = np.zeros(many, both), np.empty((-(-most // FINER), FINER), own)
    turned[: len(sums)] = sums
    for k in range(FINER):
        out[:, k] = np.abs(fft(turned)[: len(out)])
        turned[: len(sums)] *= step
    return np.asarray(out.ravel()[:most])


def _folds_at(place: np.ndarray, many: int, most: int) -> float:
    """The frequency, in steps of the search, beyond which every wave over cells (n,) looks like a slower one:
    half of that at which the places that there are show one phase. Infinite where they fill the range, or
    where that is none of the first ``most``.

    Source: Deeming (1975), Astrophys. Space Sci. 36: the spectral window.
    """
    there = np.bincount(place) > 0
    if np.count_nonzero(there) > len(there) / 2.0:
        return float("inf")
    window = _lines(there, many, most) / np.count_nonzero(there)
    apart = int(np.argmax(window < ALIKE))
    again = np.flatnonzero(window[apart:] >= ALIKE)
    return (apart + again[0]) / 2.0 if len(again) else float("inf")
