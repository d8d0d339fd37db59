"""A look at some of the readings of recordings that have more than effects have to be chosen on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

from trunk_ros.data.excerpt import sparser
from trunk_ros.data.noise import Noise
from trunk_ros.data.span import Span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis


@dataclass(frozen=True, eq=False)
class Sparse(Context):
    """One of ``every`` so many readings of a ``denser`` context, in all of which its noise is seen: from one
    to the next of these a joint moves further than noise goes.
    """

    denser: Context | None = None
    every: int = 1

    def weighed(self, hypothesis: Hypothesis) -> Context:
        """With the noise that a hypothesis leaves in all readings."""
        assert self.denser is not None
        denser = replace(self.denser, work=self.work)
        seen = denser.seen_with(hypothesis).weighed(hypothesis)
        found = noise_of_every(seen.noise, self.every)
        told = tuple(self.wanders.get(c, noise) for c, noise in enumerate(found))
        return replace(self.in_noise(told), resolution=seen.resolution)


def noise_of_every(noise: Sequence[Noise], every: int) -> tuple[Noise, ...]:
    """That of one of ``every`` so many readings, of each column."""
    return tuple(own.of_every(every) for own in noise)


def sparse(context: Context) -> Context:
    """The context, or what stands for it where its wires were read very often."""
    found = _sparser(context)
    return context if found is None else _over(context, *found)


def apart(context: Context) -> list[Context]:
    """Each recording by itself, as often read as it is in ``sparse``."""
    found, alone = _sparser(context), [context.over([view.span]) for view in context.views]
    if found is None:
        return alone
    fewer, every = found
    return [_over(c, [f], every) for c, f in zip(alone, fewer, strict=True)]


def _sparser(context: Context) -> tuple[list[Span], int] | None:
    return sparser([view.span for view in context.views]) if context.stage.name == "wire" else None


def _over(context: Context, spans: Sequence[Span], every: int) -> Sparse:
    there = context.over(spans)
    there.stage.stands = [max(samples / every, 1.0) for samples in there.stage.stands]
    own = {f.name: getattr(there, f.name) for f in fields(Context) if f.init}
    return Sparse(**{**own, "noise": noise_of_every(context.noise, every)}, denser=context, every=every)
