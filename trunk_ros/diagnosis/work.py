"""How much a search may simulate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class Work:
    """Simulated joint-steps, counted over all contexts of a search. No decision reads a clock."""

    most: float = np.inf
    done: int = 0

    @property
    def over(self) -> bool:
        """Whether what was granted is spent."""
        return self.done >= self.most
