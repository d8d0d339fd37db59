"""How much a search may simulate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

BESIDES = 0.25  # of the work granted: what is granted on top to end well, as where that is spent


@dataclass
class Work:
    """Simulated joint-steps, counted over all contexts of a search. No decision reads a clock."""

    most: float = np.inf
    done: int = 0

    @property
    def over(self) -> bool:
        """Whether what was granted is spent."""
        return self.done >= self.most

    def besides(self) -> Work:
        """What is granted on top: it is not what ends a search early."""
        return Work(BESIDES * self.most)

    def took(self, more: Work) -> None:
        """Count what was done on top; where that was not enough, the work that was granted is spent."""
        self.done += more.done
        self.most = self.done if more.over else self.most + more.done
