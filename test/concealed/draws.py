"""What all draws of effects need: the register, and distributions of sizes, signs and forms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from test.concealed.hidden import Hidden
from test.concealed.nominal import COUNT, Array
from test.concealed.recipe import Look, Recipe, scaled

Rng: TypeAlias = np.random.Generator
Joints: TypeAlias = tuple[int, ...]
Draw: TypeAlias = Callable[[Rng, Joints, Look], Recipe]
ALL: Joints = tuple(range(COUNT))
CATALOGUE: dict[str, Draw] = {}


def drawn(draw: Draw) -> Draw:
    """Enters the draw of the effect of the function's name."""
    CATALOGUE[draw.__name__] = draw
    return draw


def logarithmic(rng: Rng, low: float, high: float, n: int | None = None) -> Any:
    """Log-uniform: a float, or (n,)."""
    return np.exp(rng.uniform(np.log(low), np.log(high), n))


def sizes(rng: Rng, n: int) -> Array:
    """Unequal sizes of about one on n joints."""
    return rng.uniform(0.6, 1.5, n)


def signed(rng: Rng, n: int) -> Array:
    """The same with either sign."""
    out: Array = sizes(rng, n) * rng.choice([-1.0, 1.0], n)
    return out


def sign(rng: Rng) -> float:
    """One or minus one."""
    return float(rng.choice([-1.0, 1.0]))


def one_of(rng: Rng, *forms: str) -> str:
    """One of the forms; named twice is twice as likely."""
    return forms[int(rng.integers(len(forms)))]


def shared(effect: str, form: str, name: str, value: float, start: float, limit: float) -> Recipe:
    """An effect with one parameter for all joints."""
    return scaled(Hidden(effect, ALL, form, {name: value}, (name,)), (name,), start, limit)
