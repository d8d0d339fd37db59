"""A look at some of the readings of recordings that have more than effects have to be chosen on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.data.excerpt import sparser
from trunk_ros.diagnosis.data.noise import Noise
from trunk_ros.diagnosis.data.span import Span
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
        found = thinned(self.denser.seen_with(hypothesis).weighed(hypothesis).noise, self.every)
        told = tuple(self.wanders.get(c, noise) for c, noise in enumerate(found))
        return replace(self, noise=told, shown_before={})


def thinned(noise: Sequence[Noise], every: int) -> tuple[Noise, ...]:
    """That of one of ``every`` so many readings, of each column."""
    return tuple(own.of_every(every) for own in noise)


def sparse(context: Context) -> Context:
    """The context, or what stands for it where its wires were read very often."""
    spans = [view.span for view in context.views]
    fewer, every = sparser(spans) if context.stage.name == "wire" else (spans, 1)
    return context if every == 1 else _over(context, fewer, every)


def apart(context: Context) -> list[Context]:
    """Each recording by itself, as often read as it is in ``sparse``."""
    spans = [view.span for view in context.views]
    fewer, every = sparser(spans) if context.stage.name == "wire" else (spans, 1)
    alone = [context.over([span]) for span in spans]
    return alone if every == 1 else [_over(c, [f], every) for c, f in zip(alone, fewer, strict=True)]


def _over(context: Context, spans: Sequence[Span], every: int) -> Sparse:
    there = context.over(spans)
    own = {f.name: getattr(there, f.name) for f in fields(Context) if f.init}
    return Sparse(**{**own, "noise": thinned(context.noise, every)}, denser=context, every=every)
