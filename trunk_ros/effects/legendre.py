"""Legendre polynomials, one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

import numpy as np

from trunk_ros.compiled import Array


def legendre(x: Array) -> Iterator[Array]:
    """Legendre polynomials at ``x`` (n,), one after the other: of a long recording all of them are larger
    than all else.
    """
    before, last = np.ones_like(x), x
    yield before
    for k in count(2):
        yield last
        before, last = last, (last * x * (2 * k - 1) - before * (k - 1)) / k
