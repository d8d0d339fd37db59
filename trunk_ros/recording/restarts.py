"""Stamps of several runs in a row, each of a clock that began anew."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

_RUN = 100  # samples of a run in the mean: what falls back more often is disorder
_MOST = 200  # runs that somebody may have in a row
_NAMED = 5  # of them, in a message
_BEHIND = 20  # samples in a row that are earlier than one before them: of fewer, some came late


def restarts(stamp_ns: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """(k,) places of samples at which the clock began anew, of stamps (n,) ns as they were recorded.

    None where stamps fall back often, or for a few samples, or to where no sample was yet: such are sorted.
    """
    back = np.flatnonzero(np.diff(stamp_ns) < 0) + 1
    if not 0 < len(back) <= min(_MOST, len(stamp_ns) / _RUN):
        return np.empty(0, dtype=np.int64)
    behind = stamp_ns < np.maximum.accumulate(stamp_ns)
    found = []
    for begin in back:
        on = np.flatnonzero(~behind[begin:])
        end = begin + int(on[0]) if len(on) else len(stamp_ns)
        before, run = stamp_ns[:begin], stamp_ns[begin:end]
        mixed = int(((before > run.min()) & (before < run.max())).sum())
        found += [begin] if min(mixed, len(run)) >= _BEHIND else []
    return np.array(found, dtype=np.int64)


def began_anew(stamp_ns: npt.NDArray[np.int64], where: Callable[[int], str]) -> str:
    """Where the clock of stamps (n,) ns began anew, in one line, by what ``where`` calls a place; "" where it
    did not.
    """
    at = restarts(stamp_ns).tolist()
    if not at:
        return ""
    some = [f"{where(k)} ({(stamp_ns[k - 1] - stamp_ns[k]) / 1e9:.3g} s back)" for k in at[:_NAMED]]
    more = f", and {len(at) - _NAMED} times more" if len(at) > _NAMED else ""
    return f"time begins anew at {', '.join(some)}{more}: these are several runs"
