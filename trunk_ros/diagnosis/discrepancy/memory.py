"""What no formula fits, as banks of shapes over the motion: curves and drags of other joints, plays of the joint's
own. Linear in their weights, few by marginal likelihood, and kept only where they win on blocks not seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.noise import alike
from trunk_ros.diagnosis.hypothesis import Explanation, Term
from trunk_ros.diagnosis.stage import Problem
from trunk_ros.effects import effect, registry
from trunk_ros.effects.bank import WEIGHTS, Bank, choices, motion, words_of

STANDS = 1e-3  # of a joint's angle [rad]: a source that moves less shows nothing
ROUNDS = 40
TELLS = 1.0  # values that the data must determine in a source's weights
FOLDS = 5
CUTS = 10  # blocks of time, each left out with those FOLDS further on


@dataclass(frozen=True)
class Source:
    """One motion in a bank, and the design (rows, WEIGHTS) of its weights on the whitened residual."""

    kind: type[Bank]
    word: str
    low: float
    high: float
    design: Array


@dataclass(frozen=True)
class Weighed:
    """Sources with their weights, (WEIGHTS,) each."""

    sources: list[Source]
    weights: list[Array]


def banks() -> list[type[Bank]]:
    """All banks."""
    return [kind for kind in registry().values() if issubclass(kind, Bank)]


def without_banks(explanation: Explanation, column: int) -> Explanation:
    """The explanation without its banks on a column."""
    there = [term.effect for term in explanation.on(column) if issubclass(effect(term.effect), Bank)]
    return explanation.less(there, column)


def sources(problem: Problem, column: int, like: Explanation | None = None) -> list[Source]:
    """What may be in the banks of a column; those that an explanation ``like`` has where there is one."""
    chosen = None if like is None else list(_used(like, column))
    found = _possible(problem, column) if chosen is None else chosen
    return [s for kind, word in found if (s := _source(problem, column, kind, word)) is not None]


def _possible(problem: Problem, column: int) -> Iterator[tuple[type[Bank], str]]:
    joint, unit = problem.joints[column], problem.units
    alike_ = tuple(j for j in problem.joints if unit.get(j, "rad") == unit.get(joint, "rad"))
    for kind in banks():
        for word in choices(alike_ if kind.own else problem.joints, joint, kind.own):
            yield kind, word


def _used(like: Explanation, column: int) -> Iterator[tuple[type[Bank], str]]:
    for term in like.on(column):
        kind = effect(term.effect)
        if issubclass(kind, Bank):
            for word in term.words[column].values():
                yield kind, word


def _source(problem: Problem, column: int, kind: type[Bank], word: str) -> Source | None:
    signals = [motion(word, problem.now(i, column, 0.0)) for i in range(len(problem.views))]
    together = np.concatenate(signals)
    if np.ptp(together) < STANDS:
        return None
    low, high = kind.range_of(together)
    parts = []
    for view, signal in zip(problem.views, signals, strict=True):
        parts.append(kind.shapes(signal, low, high)[view.span.rows])
    columns = [problem.whiten_change([p[:, k] for p in parts], column) for k in range(WEIGHTS)]
    return Source(kind, word, low, high, np.column_stack(columns))


def weighed(found: Sequence[Source], target: Array, worth: float = 1.0) -> Weighed:
    """The weights that a target (rows,) needs, and the sources that it needs; ``worth``: samples that are worth
    one.

    Each source has a precision of its own, of the largest marginal likelihood (MacKay 1992; Tipping 2001, J.
    Mach. Learn. Res. 1), which leaves those out that say nothing.
    """
    left = list(found)
    while left:
        weights, told = _likeliest([s.design for s in left], target, worth)
        silent = [k for k, values in enumerate(told) if values < TELLS]
        crowded = [k for k in range(len(left)) if _crowded(left, told, k)]
        gone = set(silent or crowded)
        if not gone:
            return Weighed(left, weights)
        left = [s for k, s in enumerate(left) if k not in gone]
    return Weighed([], [])


def _crowded(left: Sequence[Source], told: Sequence[float], k: int) -> bool:
    """Whether a bank has more sources than room, and this one of them tells least."""
    same = [i for i, s in enumerate(left) if s.kind is left[k].kind]
    return len(same) > left[k].kind.sources and min(same, key=lambda i: told[i]) == k


def _likeliest(designs: Sequence[Array], target: Array, worth: float) -> tuple[list[Array], list[float]]:
    """Weights of each design, and how many values the data determine of each."""
    every = np.column_stack(list(designs))
    ends = np.cumsum([d.shape[1] for d in designs])[:-1]
    normal, side, power = every.T @ every / worth, every.T @ target / worth, float(target @ target) / worth
    count = len(target) / worth
    group = np.repeat(np.arange(len(designs)), [d.shape[1] for d in designs])
    precision = np.full(len(designs), 1.0)
    sharp = count / max(power, 1e-300)
    weights = np.zeros(len(side))
    told = np.zeros(len(designs))
    for _ in range(ROUNDS):
        inside = sharp * normal + np.diag(precision[group])
        factor = cho_factor(inside + 1e-12 * float(np.trace(inside)) / len(side) * np.eye(len(side)))
        weights = sharp * cho_solve(factor, side)
        spread = np.diag(cho_solve(factor, np.eye(len(side))))
        told = np.bincount(group, 1.0 - precision[group] * spread)
        precision = np.clip(told / np.maximum(np.bincount(group, weights**2), 1e-12), 1e-3, 1e8)
        rest = power - 2.0 * float(weights @ side) + float(weights @ normal @ weights)
        sharp = max(count - float(told.sum()), 0.1 * count) / max(rest, 1e-300)
    return np.split(weights, ends), told.tolist()


def in_banks(bare: Explanation, column: int, found: Weighed) -> Explanation:
    """The explanation with weighed sources on a column."""
    out, taken = bare.copy(), dict[str, int]()
    for source, weights in zip(found.sources, found.weights, strict=True):
        kind = source.kind
        term = out.setdefault(kind.id, Term(kind.id, given=frozenset(p.name for p in kind.parameters)))
        k = taken[kind.id] = taken.get(kind.id, 0) + 1
        own = term.own.setdefault(column, {})
        own |= {f"weight_{k}_{i}": float(w) for i, w in enumerate(weights, start=1)}
        own |= {f"low_{k}": source.low, f"high_{k}": source.high}
        term.words.setdefault(column, {})[words_of(kind.sources)[k - 1]] = source.word
    return out


def drawn(problem: Problem, bare: Explanation, column: int, found: Sequence[Source]) -> Explanation:
    """The explanation with the banks that its rest on a column needs."""
    rest = problem.whitened(bare, column)
    first = weighed(found, rest)
    worth = alike([rest - _sum(first)]) if first.sources else 1.0
    return in_banks(bare, column, weighed(found, rest, worth))


def _sum(done: Weighed) -> Array:
    return np.asarray(sum(s.design @ w for s, w in zip(done.sources, done.weights, strict=True)))


def unseen(found: Sequence[Source], rest: Array, worth: float) -> Array:
    """(rows,) what is left of a whitened residual by banks that were fitted to other blocks of time."""
    block = np.arange(len(rest)) * CUTS // max(len(rest), 1)
    out = rest.copy()
    for fold in range(FOLDS):
        judged = block % FOLDS == fold
        seen = [replace(s, design=s.design[~judged]) for s in found]
        done = weighed(seen, rest[~judged], worth)
        places = [next(k for k, s in enumerate(seen) if s is chosen) for chosen in done.sources]
        for k, weights in zip(places, done.weights, strict=True):
            out[judged] -= found[k].design[judged] @ weights
    return out


def by_blocks(power: Array) -> Array:
    """(CUTS,) means of a power (rows,) over blocks of time."""
    return np.array([part.mean() for part in np.array_split(power, CUTS)])
