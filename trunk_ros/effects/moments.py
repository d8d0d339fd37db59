"""When something begins and ends, and how much of it is there; and what an arm takes up and puts down."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from trunk_ros.compiled import Array, compiled, copied
from trunk_ros.parameter import FROM, GROWN, LATER, NEVER, SPELL_NAMES, UNTIL

RISE = 0.02  # s, so that a fit can move a moment
LASTING = (FROM, UNTIL, GROWN, *LATER)
NULLS = {p.name: p.null for p in LASTING}


class Payload(NamedTuple):
    """A mass [kg] at the tip, and by the names of an effect's moments when [s] how much of it is there."""

    mass: float = 0.0
    when: tuple[tuple[str, float], ...] = ()

    @property
    def always(self) -> bool:
        """Whether it is there from beginning to end."""
        return not self.when

    @property
    def own(self) -> float:
        """kg that the arm has from beginning to end."""
        return self.mass if self.always else 0.0

    def at(self, stamp: Array) -> Array:
        """(n, 1) kg at ``stamp`` (n,) s."""
        return self.mass * self.share(stamp)

    def share(self, stamp: Array) -> Array:
        """(n, 1): how much of it is there at ``stamp`` (n,) s."""
        return share(stamp, {name: np.array([value]) for name, value in self.when}, 1)


NOTHING = Payload()


def share(stamp: Array, values: Mapping[str, Any], columns: int) -> Array:
    """(n, columns): how much of its size acts at ``stamp`` (n,) s, by moments that are (columns,) or one."""
    first, *later = SPELL_NAMES
    said = [first, *(names for names in later if names[0] in values)]

    def of(name: str) -> Array:
        out = np.empty(columns)
        out[:] = values.get(name, NULLS[name])
        return out

    begin, until = (np.array([of(names[which]) for names in said]) for which in (0, 1))
    times = np.array([np.ones(columns), *(of(times) for *_, times in said[1:])])
    out = np.empty((columns, len(stamp))).T
    _share(stamp, begin, until, times, of(GROWN.name), out)
    return out


@compiled
def _ramp(stamp: float, middle: float, rise: float) -> float:
    if abs(stamp - middle) > rise:  # mostly: a division costs more than all the rest
        return 0.0 if stamp < middle else 1.0
    return min(max((stamp - middle) / rise + 0.5, 0.0), 1.0)


@compiled
def _alike(begin: Array, until: Array, times: Array, j: int) -> bool:
    """Whether a column (spells, columns) is as the one before."""
    for i in range(len(begin)):
        if begin[i, j] != begin[i, j - 1] or until[i, j] != until[i, j - 1] or times[i, j] != times[i, j - 1]:
            return False
    return True


@compiled
def _share(stamp: Array, begin: Array, until: Array, times: Array, grown: Array, out: Array) -> None:
    for j in range(len(grown)):
        if j and _alike(begin, until, times, j) and grown[j] == grown[j - 1]:
            copied(out[:, j - 1], out[:, j])
            continue
        rise = max(grown[j] - begin[0, j], RISE)
        middle = begin[0, j] + rise / 2 if grown[j] > begin[0, j] else begin[0, j]
        always = begin[0, j] <= 0.0 and grown[j] <= 0.0
        for k in range(len(stamp)):
            size = 1.0 if always else _ramp(stamp[k], middle, rise)
            for i in range(len(begin)):
                if i and begin[i, j] < NEVER:
                    begun = _ramp(stamp[k], begin[i, j], RISE) if begin[i, j] > 0.0 else 1.0
                    size += begun * (times[i, j] - size)
                if until[i, j] < NEVER:
                    size *= 1.0 - _ramp(stamp[k], until[i, j], RISE)
            out[k, j] = size
