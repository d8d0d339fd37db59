"""What a drive does that no first-order loop can: fitted while its loop is found, whose numbers would else
make up for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from trunk_ros.arm.arm import SERVO_OF_EACH
from trunk_ros.compiled import Array
from trunk_ros.data.excerpt import moving
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import Candidate, extended, usable
from trunk_ros.diagnosis.search.score import SIGNIFICANT
from trunk_ros.diagnosis.search.starts import Starts
from trunk_ros.diagnosis.servos.servo_loop import (
    FED,
    STEPS,
    TOPS,
    Loop,
    cost_of,
    fastest_of,
    in_its_valley,
    is_explained,
    numbers_of,
    solved,
    usual_loops,
)
from trunk_ros.effects import Effect
from trunk_ros.levels import CLEARLY, HARDLY, SEVERAL
from trunk_ros.parameter import Parameter, leading

Beside = tuple["Further", Array, float]
"""What a drive does besides, what is fitted of it and its loop, and what is left of its squared residual."""


def beside_more(loop: Loop, numbers: Array, cost: float, others: Iterable[Beside]) -> Beside:
    """A loop beside what else its drive does: as the ``others`` of its arm where that explains all, or one
    thing after the other while that leaves clearly less. With its own ``numbers`` (5,), which leave a
    ``cost``, beside nothing where nothing does.
    """
    best, at = Further(loop, ()), loop.at(numbers)[: 5 if numbers[-1] else 4]
    alike = like_others((best, at, cost), others)
    if is_explained(loop, alike[2]):
        return alike
    begin = Starts(loop.context, loop.context.known, [loop.column])
    sizes = dict[Part, list[float]]()
    for kind in filter(_is_further, usable(loop.context)):
        for start in begin.on(kind, kind.apart, loop.column):
            rest = {name: value for name, value in start.items() if name != _lead(kind).name}
            sizes.setdefault(Part(kind, tuple(rest.items())), []).append(float(start[_lead(kind).name]))
    most = moving([view.span for view in loop.context.views], loop.column)
    part_of_it = replace(loop, context=loop.context.over(most)) if most else loop
    while sizes and not is_explained(loop, cost):
        rough = Further(part_of_it, best.parts)
        each = [(part, rough.and_with(part).begun(at, some)) for part, some in sizes.items()]
        part, near = min(each, key=lambda one: cost_of(one[1]))
        further = best.and_with(part)
        found = further.fitted(near.x)
        if CLEARLY**2 * 2.0 * cost_of(found) >= cost:
            break
        best, found = further, further.settled(found)
        at, cost = found.x, 2.0 * cost_of(found)
        sizes = {part: some for part, some in sizes.items() if part.kind is not best.parts[-1].kind}
    return best, at, cost


def like_others(own: Beside, others: Iterable[Beside]) -> Beside:
    """What is found of a drive, or what that of the ``others`` of its arm leads to whose numbers leave least,
    where that leaves clearly less.
    """
    further, _, cost = own
    if is_explained(further.loop, cost):
        return own
    each = (
        (there := Further(further.loop, other.parts), there.fitted(at, rough=True))
        for other, at, _ in others
        if other.parts and other is not further
    )
    there, near = min(each, key=lambda one: cost_of(one[1]), default=(further, None))
    if near is None:
        return own
    found = there.settled(near)
    return (there, found.x, 2.0 * cost_of(found)) if CLEARLY**2 * 2.0 * cost_of(found) < cost else own


def _is_further(kind: type[Effect]) -> bool:
    """Whether an effect is one number of a drive that no loop has without it."""
    if not kind.everywhere or not kind.apart or kind.changes in SERVO_OF_EACH or kind.bears(kind.apart):
        return False
    return sum(not p.optional for p in kind.own_parameters(kind.apart)) == 1


def _lead(kind: type[Effect]) -> Parameter:
    return leading(kind.own_parameters(kind.apart))


@dataclass(frozen=True)
class Part:
    """One of these effects, with options as they are tried from the beginning."""

    kind: type[Effect]
    options: tuple[tuple[str, float], ...] = ()

    @property
    def log(self) -> bool:
        """Whether its size is fitted as a logarithm."""
        return _lead(self.kind).scale == "log"

    @property
    def bounds(self) -> Array:
        """(2,) of what is fitted."""
        return np.log(_lead(self.kind).bounds) if self.log else np.array(_lead(self.kind).bounds)

    @property
    def step(self) -> float:
        """A step of that, for slopes."""
        return HARDLY * (1.0 if self.log else _lead(self.kind).typical)

    def on(self, column: int, fitted: float) -> Candidate:
        """As a candidate, from what is fitted."""
        size = {_lead(self.kind).name: float(np.exp(fitted) if self.log else fitted)}
        return Candidate(self.kind.id, self.kind.apart, column, size | dict(self.options))


@dataclass(frozen=True)
class Further:
    """A loop with some of these effects. What is fitted is (4,) as in ``Loop``, or (5,) of a drive that is
    told the speed of its setpoints, and the size of each effect.
    """

    loop: Loop
    parts: tuple[Part, ...]

    def and_with(self, part: Part) -> Further:
        """With another one."""
        return replace(self, parts=(*self.parts, part))

    def hypothesis(self, x: Array) -> Hypothesis:
        """What is known, and the effects."""
        out = self.loop.context.known
        for part, size in zip(self.parts, self._of_loop(x)[1], strict=True):
            out = extended(self.loop.context, out, part.on(self.loop.column, size))
        return out

    def _of_loop(self, x: Array) -> tuple[Array, Array]:
        """What is fitted of the loop, and of the effects."""
        n = len(x) - len(self.parts)
        return x[:n], x[n:]

    def _residuals(self, some: Sequence[Array]) -> list[Array]:
        numbers = [numbers_of(self._of_loop(x)[0]) for x in some]
        return self.loop.residuals(numbers, [self.hypothesis(x) for x in some])

    def begun(self, at: Array, sizes: Sequence[float]) -> Any:
        """The best rough fit from one without the last effect, or from usual loops, with ``sizes`` of it."""
        others = at[len(at) - len(self.parts) + 1 :]
        usual = [np.append(x, others) for x in usual_loops(float(np.exp(at[2])))]
        log = self.parts[-1].log
        starts = [np.append(x, np.log(size) if log else size) for x in (at, *usual) for size in sizes]
        left = [float(rest @ rest) for rest in self._residuals(starts)]
        near = {*range(len(sizes)), *np.argsort(left, kind="stable")[:SEVERAL].tolist()}
        return min((self.fitted(starts[k], rough=True) for k in sorted(near)), key=cost_of)

    def fitted(self, start: Array, rough: bool = False) -> Any:
        """From a start."""
        loop, n = self.loop, len(start) - len(self.parts)
        bounds = np.vstack([np.column_stack([loop.low, loop.high])[:n], *(p.bounds for p in self.parts)]).T
        steps = np.append(STEPS[:n], [part.step for part in self.parts])
        return solved(self._residuals, start, steps, bounds, rough=rough)

    def settled(self, best: Any) -> Any:
        """The best fit from one on, from where its top speed is reached as well, and by the delay; with what
        the drive may be told of the setpoint's speed where much is left without.
        """
        reached, roughly = best.x.copy(), partial(self.fitted, rough=True)
        reached[2] = np.log(fastest_of(self.loop.context, self.loop.column))
        best = self.fitted(in_its_valley(min(best, roughly(reached), key=cost_of), roughly).x)
        if is_explained(self.loop, 2.0 * cost_of(best)) or len(best.x) - len(self.parts) > 4:
            return best
        told = (roughly(np.insert(x, 4, share)) for x in (best.x, reached) for share in FED)
        nearest = self.fitted(in_its_valley(min(told, key=cost_of), roughly).x)
        return nearest if CLEARLY**2 * nearest.cost < best.cost else best

    def numbers(self, x: Array) -> Array:
        """(5,) of the loop, with a top speed that is left open where none shows."""
        there = x.copy()
        there[2] = max(x[2], np.log(TOPS[-1] * fastest_of(self.loop.context, self.loop.column)))
        left, rest = (float(one @ one) for one in self._residuals([x, there]))
        return numbers_of(self._of_loop(x if rest - left > SIGNIFICANT else there)[0])
