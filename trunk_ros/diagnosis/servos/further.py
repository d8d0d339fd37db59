"""What a drive does that no first-order loop can: fitted while its loop is found, whose numbers would else
make up for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from trunk_ros.arm.arm import SERVO_OF_EACH
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import Candidate, extended, usable
from trunk_ros.diagnosis.search.score import SIGNIFICANT
from trunk_ros.diagnosis.search.starts import Starts
from trunk_ros.diagnosis.servos.servo_loop import (
    FED,
    STARTS,
    STEPS,
    TOPS,
    Loop,
    cost_of,
    fastest_of,
    in_its_valley,
    is_explained,
    numbers_of,
    solved,
)
from trunk_ros.effects import Effect
from trunk_ros.levels import CLEARLY, HARDLY, SEVERAL
from trunk_ros.parameter import Parameter, leading

Beside = tuple["Further", Array, float]
"""What a drive does besides, what is fitted of it and its loop, and what is left of its squared residual."""


def beside_more(loop: Loop, numbers: Array, cost: float) -> Beside:
    """A loop beside what else its drive does, one thing after the other while that leaves clearly less. With
    its own ``numbers`` (5,), which leave a ``cost``, beside nothing where nothing does.
    """
    begin = Starts(loop.context, loop.context.known, [loop.column])
    kinds = {
        kind: sorted({float(s[_lead(kind).name]) for s in begin.on(kind, kind.apart, loop.column)})
        for kind in usable(loop.context)
        if _is_further(kind)
    }
    best, at = Further(loop, ()), loop.at(numbers)[: 5 if numbers[-1] else 4]
    while kinds and not is_explained(loop, cost):
        each = [(other := best.and_with(kind), other.begun(at, sizes)) for kind, sizes in kinds.items()]
        further, found = min(each, key=lambda one: cost_of(one[1]))
        if CLEARLY**2 * 2.0 * cost_of(found) >= cost:
            break
        best, found = further, further.settled(found)
        at, cost = found.x, 2.0 * cost_of(found)
        del kinds[best.kinds[-1]]
    return best, at, cost


def like_others(own: Beside, others: Iterable[Beside]) -> Beside:
    """What is found of a drive, or what the ``others`` of its arm lead to where that leaves clearly less."""
    further, _, cost = own
    if is_explained(further.loop, cost):
        return own
    for other, at, _ in others:
        there = Further(further.loop, other.kinds)
        found = there.settled(there.fitted(at))
        if CLEARLY**2 * 2.0 * cost_of(found) < own[-1]:
            own = there, found.x, 2.0 * cost_of(found)
    return own


def _lead(kind: type[Effect]) -> Parameter:
    return leading(kind.own_parameters(kind.apart))


def _is_further(kind: type[Effect]) -> bool:
    """Whether an effect is one number of a drive that no loop has without it."""
    if not kind.everywhere or not kind.apart or kind.changes in SERVO_OF_EACH or kind.bears(kind.apart):
        return False
    return len(kind.own_parameters(kind.apart)) == 1


@dataclass(frozen=True)
class Further:
    """A loop with some of these effects. What is fitted is (4,) as in ``Loop``, or (5,) of a drive that is
    told the speed of its setpoints, and the size of each effect.
    """

    loop: Loop
    kinds: tuple[type[Effect], ...]

    def and_with(self, kind: type[Effect]) -> Further:
        """With another one."""
        return replace(self, kinds=(*self.kinds, kind))

    def hypothesis(self, x: Array) -> Hypothesis:
        """What is known, and the effects."""
        out = self.loop.context.known
        for kind, size in zip(self.kinds, self._of_loop(x)[1], strict=True):
            value = float(np.exp(size) if _is_log(kind) else size)
            there = Candidate(kind.id, kind.apart, self.loop.column, {_lead(kind).name: value})
            out = extended(self.loop.context, out, there)
        return out

    def _of_loop(self, x: Array) -> tuple[Array, Array]:
        """What is fitted of the loop, and of the effects."""
        n = len(x) - len(self.kinds)
        return x[:n], x[n:]

    def _residuals(self, some: Sequence[Array]) -> list[Array]:
        numbers = [numbers_of(self._of_loop(x)[0]) for x in some]
        return self.loop.residuals(numbers, [self.hypothesis(x) for x in some])

    def begun(self, at: Array, sizes: Sequence[float]) -> Any:
        """The best fit from one without the last effect, or from usual loops, with some ``sizes`` of it."""
        top, others = at[2], at[len(at) - len(self.kinds) + 1 :]
        usual = [
            np.array([*np.log([kp, swings]), top, late, *others]) for kp, swings, late in product(*STARTS)
        ]
        log = _is_log(self.kinds[-1])
        starts = [np.append(x, np.log(size) if log else size) for x in (at, *usual) for size in sizes]
        left = [float(rest @ rest) for rest in self._residuals(starts)]
        near = [starts[k] for k in np.argsort(left, kind="stable")[:SEVERAL]]
        return min(map(self.fitted, [*starts[: len(sizes)], *near]), key=cost_of)

    def fitted(self, start: Array) -> Any:
        """From a start."""
        loop, n = self.loop, len(start) - len(self.kinds)
        bounds = np.array([np.log(_lead(k).bounds) if _is_log(k) else _lead(k).bounds for k in self.kinds])
        bounds = np.vstack([np.column_stack([loop.low, loop.high])[:n], bounds.reshape(-1, 2)])
        steps = [HARDLY * (1.0 if _is_log(kind) else _lead(kind).typical) for kind in self.kinds]
        return solved(self._residuals, start, np.append(STEPS[:n], steps), bounds.T)

    def settled(self, best: Any) -> Any:
        """The best fit from one on, from where its top speed is reached as well, and by the delay; with what
        the drive may be told of the setpoint's speed where much is left without.
        """
        reached = best.x.copy()
        reached[2] = np.log(fastest_of(self.loop.context, self.loop.column))
        best = in_its_valley(min(best, self.fitted(reached), key=cost_of), self.fitted, self.loop)
        if is_explained(self.loop, 2.0 * cost_of(best)) or len(best.x) - len(self.kinds) > 4:
            return best
        told = (self.fitted(np.insert(x, 4, share)) for x in (best.x, reached) for share in FED)
        nearest = in_its_valley(min(told, key=cost_of), self.fitted, self.loop)
        return nearest if CLEARLY**2 * nearest.cost < best.cost else best

    def numbers(self, x: Array) -> Array:
        """(5,) of the loop, with a top speed that is left open where none shows."""
        there = x.copy()
        there[2] = max(x[2], np.log(TOPS[-1] * fastest_of(self.loop.context, self.loop.column)))
        left, rest = (float(one @ one) for one in self._residuals([x, there]))
        return numbers_of(self._of_loop(x if rest - left > SIGNIFICANT else there)[0])


def _is_log(kind: type[Effect]) -> bool:
    return _lead(kind).scale == "log"
