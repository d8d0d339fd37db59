"""The sizes that an effect has one after the other, and the values that say so."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.parameter import FROM, MANY, NEVER, SPELL_NAMES, SPELLS


@dataclass(frozen=True)
class Course:
    """Sizes, from the beginning of a recording and from each of some moments [s] on."""

    sizes: tuple[float, ...]
    moments: tuple[float, ...] = ()

    @staticmethod
    def of(values: Mapping[str, float], prefix: str = "") -> Course:
        """As values say, whose names begin with ``prefix``; the effect's own value is for size 1. What begins
        before the recording, or before what comes first has ended, is what ``effects.lasting`` makes of it.
        """
        spells = [
            (
                values.get(prefix + begins, NEVER if k else FROM.null),
                values.get(prefix + ends, NEVER),
                values.get(prefix + times, 1.0),
            )
            for k, (begins, ends, times) in enumerate(SPELL_NAMES)
            if not k or prefix + begins in values
        ]
        moments = sorted({t for begins, ends, _ in spells for t in (begins, ends) if 0.0 < t < NEVER})

        def size(at: float) -> float:
            now = 0.0
            for begins, ends, times in spells:
                now = times if at >= begins else now
                now = 0.0 if at >= ends else now
            return now

        return Course(tuple(size(at) for at in (0.0, *moments)), tuple(moments)).plain()

    @property
    def first(self) -> float:
        """Its first size that is not 0; 0 where there is none."""
        return next((size for size in self.sizes if size), 0.0)

    def at(self, stamp: Array) -> Array:
        """(n,) its size at ``stamp`` (n,) s."""
        return np.array(self.sizes)[np.searchsorted(self.moments, stamp, "right")]

    def values(self, prefix: str = "") -> dict[str, float] | None:
        """What says so where the effect's own value is for its ``first`` size; None where that can not be
        said.
        """
        out: dict[str, float] = {}
        spells = 0
        for at, size in zip((0.0, *self.moments), self.sizes, strict=True):
            if not size:
                if spells:
                    out[prefix + SPELL_NAMES[spells - 1][1]] = at
                continue
            if spells == SPELLS or abs(size) > MANY * abs(self.first):
                return None
            begins, _, times = SPELL_NAMES[spells]
            if at > 0.0:
                out[prefix + begins] = at
            if spells and size != self.first:
                out[prefix + times] = size / self.first
            spells += 1
        return out if spells else None

    def plus(self, size: float, begin: float, until: float) -> Course:
        """With so much more from one moment until another; either may be infinite."""
        moments = sorted({*self.moments, *(t for t in (begin, until) if np.isfinite(t))})
        starts = (-np.inf, *moments)
        sizes = [self.sizes[int(np.searchsorted(self.moments, t, "right"))] for t in starts]
        return Course(
            tuple(s + size * (begin <= t < until) for s, t in zip(sizes, starts, strict=True)), tuple(moments)
        )

    def rounded(self) -> Course:
        """With each size at what is nearest to it: none, or the largest one."""
        return Course(tuple(map(self._nearest, self.sizes)), self.moments).plain()

    def _nearest(self, size: float) -> float:
        one = max(self.sizes, key=abs)
        return one if abs(size - one) < abs(size) else 0.0

    def without_the_least(self) -> Iterator[Course]:
        """With the least size at none, the two least ones, and so on but for the largest."""
        for most in sorted({*map(abs, self.sizes)} - {0.0})[:-1]:
            yield Course(tuple(s if abs(s) > most else 0.0 for s in self.sizes), self.moments).plain()

    def plain(self) -> Course:
        """Without moments at which nothing changes."""
        keep = [k for k in range(len(self.moments)) if self.sizes[k] != self.sizes[k + 1]]
        return Course(
            (self.sizes[0], *(self.sizes[k + 1] for k in keep)), tuple(self.moments[k] for k in keep)
        )

    def simpler(self) -> Iterator[Course]:
        """With one of its sizes at none or at the largest one, whichever is nearer; without one of its
        moments: the size before it goes on, or that after it was there before.
        """
        for k, size in enumerate(self.sizes):
            if size != self._nearest(size):
                sizes = *self.sizes[:k], self._nearest(size), *self.sizes[k + 1 :]
                yield Course(sizes, self.moments).plain()
        for k in range(len(self.moments)):
            moments = self.moments[:k] + self.moments[k + 1 :]
            for lost in (k, k + 1):
                simpler = Course(self.sizes[:lost] + self.sizes[lost + 1 :], moments).plain()
                if simpler.first:
                    yield simpler
