"""A drawn effect whose strength is still open, and the search for the size that gives the wanted strength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from test.concealed.hidden import Hidden
from test.concealed.nominal import Array
from test.concealed.plant import Motion


@dataclass(frozen=True)
class Recipe:
    """``make(size)`` gives the effect, stronger with size, up to ``limit``. ``fixed``: take it as it is."""

    make: Callable[[float], Hidden]
    start: float
    limit: float
    fixed: bool = False


@dataclass(frozen=True)
class Look:
    """What a draw may know: the motion of the arm without the effect, and which joints move."""

    motion: Motion
    moving: tuple[int, ...]

    def top(self, what: str, joints: tuple[int, ...]) -> Array:
        """Largest size of phi, v or tau on each joint."""
        peak: Array = np.abs(getattr(self.motion, what)[:, list(joints)]).max(axis=0)
        return peak


def scaled(base: Hidden, names: tuple[str, ...], start: float, limit: float) -> Recipe:
    """The usual recipe: the named parameters of ``base`` times the size."""

    def make(size: float) -> Hidden:
        grown: dict[str, Any] = {name: base.parameters[name] * size for name in names}
        return replace(base, parameters={**base.parameters, **grown})

    return Recipe(make, start, limit)


def sized(recipe: Recipe, strength: Callable[[Hidden], float], level: float) -> Hidden:
    """The effect at the wanted strength (within 3 %), or at the recipe's limit where that is weaker."""
    if recipe.fixed:
        return recipe.make(recipe.start)
    low, high = recipe.limit * 1e-5, recipe.limit
    size = min(recipe.start, high)
    for _ in range(14):
        got = strength(recipe.make(size))
        if abs(got - level) < 0.03 * level or (got < level and size >= 0.999 * recipe.limit):
            break
        low, high = (size, high) if got < level else (low, size)
        guess = size * level / max(got, 1e-9)
        size = guess if low < guess < high else float(np.sqrt(low * high))
        if guess >= recipe.limit and high == recipe.limit:
            size = recipe.limit
    return recipe.make(size)
