"""How much a search may simulate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.effects import effect

BESIDES = 0.25  # of the work granted: what is granted on top to end well, as where that is spent


@dataclass
class Work:
    """Simulated joint-steps, counted over all contexts of a search; one that takes longer counts as several.
    No decision reads a clock.
    """

    most: float = np.inf
    done: int = 0
    each: float = 0.0
    """What each effect that is found is granted besides: every further move is tried on it as well."""
    found: int = 0
    on_top: int = 0
    """Of what is done, what was granted on top: the next time no share of that is."""

    @property
    def over(self) -> bool:
        """Whether what was granted is spent."""
        return self.done >= self.most

    def finds(self, effects: int) -> None:
        """So many effects are found; what is granted once is not taken back."""
        self.most += self.each * max(effects - self.found, 0)
        self.found = max(effects, self.found)

    def besides(self) -> Work:
        """What is granted on top: it is not what ends a search early."""
        return Work(BESIDES * (self.most - self.on_top))

    def took(self, more: Work) -> None:
        """Count what was done on top; where that was not enough, the work that was granted is spent."""
        over = more.over
        self.was_beside(more)
        if over:
            self.most = self.done

    def was_beside(self, more: Work) -> None:
        """Count what was done beside: it is no part of what was granted."""
        self.done += more.done
        self.on_top += more.done
        self.most += more.done


def steps_of(hypothesis: Hypothesis, column: int) -> int:
    """As how many simulated steps one of a joint counts."""
    return max((effect(t.effect).dear.get(t.form, 1) for t in hypothesis.on(column)), default=1)
