"""A wire that stretches before the friction, behind it, or in part on either side."""

from __future__ import annotations

from typing import Self

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect
from trunk_ros.parameter import Parameter

UPSTREAM = Parameter(
    "upstream", "1", (0.0, 1.0), "share of the stretch that lies between gearbox and friction", typical=0.5,
    shared=True, optional=True,
)  # fmt: skip


class OnBothSides(Effect):
    """What stretches by a ``compliance``. What lies before the friction moves the joint only where that
    slides: a load that changes within the dead band shows nothing of it.
    """

    def upstream(self) -> Effect | None:
        return self._share(self["upstream"]) if np.any(self["upstream"] > 0.0) else None

    def downstream(self) -> Effect | None:
        before = self["upstream"]
        if np.all(before == 1.0):
            return None
        return self._share(1.0 - before) if np.any(before > 0.0) else self

    def _share(self, share: Array) -> Self:
        return type(self)({**self.values, "compliance": share * self["compliance"]}, self.words, self.form)
