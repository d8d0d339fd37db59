"""What the physics of the wire may look at while it is worked out."""

from __future__ import annotations

from dataclasses import dataclass

from test.concealed.nominal import RATIO, STEP, Array


@dataclass(frozen=True)
class Scene:
    """Everything at 2 ms: t (n,), phi and v of the gearbox shaft, theta and tau of the joints, (n, 5)."""

    t: Array
    phi: Array
    v: Array
    theta: Array
    tau: Array
    step: float = STEP

    @property
    def speed(self) -> Array:
        """Joint-side speed r v, rad/s."""
        return RATIO * self.v
