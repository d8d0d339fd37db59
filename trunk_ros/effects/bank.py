"""Shapes over the motion of several sources, each times a weight: what is linear and not known by a
formula.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now, Regime
from trunk_ros.effects.sources import check_source, others
from trunk_ros.errors import ModelError
from trunk_ros.parameter import ANY, Parameter

WEIGHTS = 8  # of each source, where a bank does not say otherwise
# Of a joint's own motion: what follows it more closely has no inverse that settles. Below it the inverse is
# right up to this share of a dead band, within which a bank moves the joint and the wire does not.
STEEPEST = 0.9
PATH_OF = "path of "  # a joint: where the names before a bank take it, its neighbours' drags included
TOGETHER = "*"  # between two joints: where both stand, not where their sum or difference does
SAME, ROUNDS = 1e-9, 100  # rad, times: back from where a joint's own path led it to


def parameters_of(
    sources: int,
    low: str,
    high: str,
    weight: str,
    weights: int = WEIGHTS,
    typical: float = 2e-4,
    start: float = 0.02,
) -> tuple[Parameter, ...]:
    """Range, from ``start`` where nothing else is said, and weights of each source, and what they mean."""
    out: list[Parameter] = []
    for k in range(1, sources + 1):
        out += [
            Parameter(f"weight_{k}_{i}", "1", ANY, f"{weight} {i}, source {k}", typical=typical)
            for i in range(1, weights + 1)
        ]
        out.append(Parameter(f"low_{k}", "rad", ANY, f"{low}, source {k}", typical=start, null=start))
        out.append(Parameter(f"high_{k}", "rad", ANY, f"{high}, source {k}", typical=0.4, null=0.4))
    return tuple(out)


def words_of(sources: int) -> tuple[str, ...]:
    """Names of the words that say what the sources are."""
    return ("source", *(f"source_{k}" for k in range(2, sources + 1)))


class Bank(Effect):
    """theta += sum of weight x shape(s), s the motor side's angle (ratio phi) of a joint, or the sum or the
    difference of two, or the joint's own angle as the effects before it have it (``PATH_OF``), or the angles
    of two (n, 2), of which low and high then are pairs.
    """

    regime: ClassVar[Regime] = "posture"
    tried = False
    scalable = False
    sources: ClassVar[int]
    weights: ClassVar[int] = WEIGHTS
    """Of each source."""
    groups: ClassVar[tuple[int, ...]] = (WEIGHTS,)
    """How many of them, in their order, are of one size."""
    own: ClassVar[bool] = False
    """Whether a source may be the joint itself, alone or together with another."""
    fades: ClassVar[bool] = False
    """Whether it is there at first and no longer later: chosen after all that stays."""
    axes: ClassVar[int] = 1
    """Motions of a source that are not one: more than one where it is two joints ``TOGETHER``."""
    by_posture: ClassVar[bool] = False
    """Whether it can follow nearly anything that is smooth: weighed once the names have been."""

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        moved, state = self.moved(now, state, range(len(self._links)), x)
        return x + moved, state

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        along = any(word.startswith(PATH_OF) for _, word, *_ in self._links)
        x = y
        for _ in range(ROUNDS if along else 1):
            moved, after = self.moved(now, state, self._invertible, x)
            before, x = x, y - moved
            if not along or np.abs(x - before).max() < SAME:
                break
        return x, after

    @classmethod
    def said(cls, k: int, low: Any, high: Any, weights: Array) -> dict[str, float]:
        """A source's values by their names, ``k`` from 1 on."""
        each = {f"weight_{k}_{i}": float(weight) for i, weight in enumerate(weights, start=1)}
        return each | {f"low_{k}": low, f"high_{k}": high}

    @classmethod
    def read(cls, values: Mapping[str, Any], k: int) -> tuple[Any, Any, Array]:
        """Its range and weights (weights, ...), of values as they are named."""
        weights = np.array([values[f"weight_{k}_{i}"] for i in range(1, cls.weights + 1)])
        return values[f"low_{k}"], values[f"high_{k}"], weights

    @classmethod
    @abstractmethod
    def ready(cls, low: Any, high: Any, weights: Array) -> Any:
        """What ``add`` needs of a source's range and weights (weights,)."""

    @classmethod
    @abstractmethod
    def add(cls, s: Array, ready: Any, state: Any, out: Array) -> Any:
        """Add the weighed shapes over a source's motion (n,) to ``out`` (n,); returns their memory."""

    @classmethod
    def columns(cls, s: Array, low: Any, high: Any) -> Iterator[Array]:
        """Each shape (n,) over a source's motion (n,), from its beginning."""
        for weights in np.eye(cls.weights):
            out = np.zeros(len(s))
            cls.add(s, cls.ready(low, high, weights), None, out)
            yield out

    @classmethod
    def shapes(cls, s: Array, low: Any, high: Any) -> Array:
        """(n, weights) all of them."""
        return np.column_stack(list(cls.columns(s, low, high)))

    @classmethod
    @abstractmethod
    def range_of(cls, s: Array) -> tuple[Any, Any]:
        """``low`` and ``high`` for a source that moves as (n,)."""

    @classmethod
    def swing(cls, low: Any, high: Any) -> tuple[Any, Any]:
        """Ends of a motion over a source's whole range."""
        return low, high

    @classmethod
    def steepness(cls, low: Any, high: Any, weights: Array) -> float:
        """rad per rad that a source adds at most, for shapes that are no steeper than 1."""
        return float(np.abs(weights).sum())

    @classmethod
    def choices(cls, joints: tuple[str, ...], joint: str) -> list[str]:
        """What may be a source for a joint."""
        far = others(joints, joint)
        return [joint, *(f"{joint}{sign}{o}" for o in far for sign in "+-")] if cls.own else far

    def check(self, joints: tuple[str, ...]) -> None:
        super().check(joints)
        for text, words in self.words.items():
            for column, word in enumerate(words):
                if word:
                    check_source(self.id, text, joints[column], word, self.choices(joints, joints[column]))

    def moved(self, now: Now, state: Any, links: Any, x: Array) -> tuple[Array, Any]:
        """(n, columns) rad that some of the sources add to ``x`` (n, columns), and the memory of all."""
        out = np.zeros((len(now.ratio), len(now.stamp)))
        memory = [None] * len(self._links) if state is None else list(state)
        for k, (column, word, _, ready) in enumerate(self._links):
            if k in links:
                path = word.startswith(PATH_OF)
                s = np.ascontiguousarray(x[:, column]) if path else motion(word, now)
                memory[k] = self.add(s, ready, memory[k], out[column])
        return out.T, memory

    @cached_property
    def _links(self) -> list[tuple[int, str, float, Any]]:
        """Column, source, slope and what ``add`` needs of them."""
        out = []
        for k, text in enumerate(words_of(self.sources), start=1):
            for column, word in enumerate(self.words.get(text, ())):
                lows, highs, each = self.read(self.values, k)
                weights = np.ascontiguousarray(each[:, column])
                if word and np.any(weights):
                    low, high = lows[column], highs[column]
                    slope = self.steepness(low, high, weights)
                    out.append((column, word, slope, self.ready(low, high, weights)))
        return out

    @property
    def _invertible(self) -> list[int]:
        """The sources whose share can be taken off: those in which a joint does not follow itself too
        closely.
        """
        if not self.own:
            return list(range(len(self._links)))
        steep: dict[int, float] = {}
        for column, _, slope, _ in self._links:
            steep[column] = steep.get(column, 0.0) + slope
        return [k for k, link in enumerate(self._links) if steep[link[0]] < STEEPEST]


def joints_of(word: str) -> list[str]:
    """What a source's word stands for, each motion for itself."""
    return word.split(TOGETHER)


def motion(word: str, now: Now) -> Array:
    """(n,) rad, what a source's word stands for; (n, 2) of two joints together."""
    wires = now.wires
    if word in now.joints:
        return np.ascontiguousarray(wires[:, now.joints.index(word)])
    for column, joint in enumerate(now.joints):
        if word.startswith(joint) and word[len(joint) + 1 :] in now.joints:
            sign, own = word[len(joint)], wires[:, column]
            other = wires[:, now.joints.index(word[len(joint) + 1 :])]
            if sign == TOGETHER:
                return np.column_stack([own, other])
            if sign in "+-":
                return np.asarray(own + other if sign == "+" else own - other)
    raise ModelError(f"{word!r} is no source: the joints are {', '.join(now.joints)}")
