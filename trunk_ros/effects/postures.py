"""What the banks share whose shapes go by the posture of the joint itself."""

from typing import ClassVar

from trunk_ros.compiled import Array
from trunk_ros.effects.bank import PATH_OF, Bank, parameters_of
from trunk_ros.effects.effect import Regime
from trunk_ros.parameter import Parameter

LEAST = 1e-9  # rad


def parameters_over_postures(weights: int, typical: float) -> tuple[Parameter, ...]:
    """Range and weights of the one source."""
    said = "where the postures begin", "where they end", "rad, shape"
    return parameters_of(1, *said, weights, typical=typical, start=-0.4)


class OverPostures(Bank):
    """Shapes over a joint's motor side, or over its path where neighbours drag it along."""

    stage = "wire"
    regime: ClassVar[Regime] = "reversal"
    remembers = True
    named = False
    sources, own, by_posture = 1, True, True
    texts = ("source",)

    @classmethod
    def choices(cls, joints: tuple[str, ...], joint: str) -> list[str]:
        return [joint, PATH_OF + joint]

    @classmethod
    def range_of(cls, s: Array) -> tuple[float, float]:
        return float(s.min()), float(s.max())
