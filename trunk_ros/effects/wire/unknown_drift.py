"""A wire whose zero wanders in a way that no name fits."""

from typing import ClassVar

from trunk_ros.effects.curve import Curve


class UnknownDrift(Curve):
    """u += curve(t), t since the start of the recording; held beyond its ends."""

    id = "unknown_drift"
    stage = "wire"
    place = 60
    ahead = True
    signature = "The residual's mean wanders with time, as far as the backlash lets it through."
    of = "what the wire hands on"
    confused_with: ClassVar[tuple[tuple[str, str], ...]] = (
        ("unknown", "stand still: what happens before the friction waits for a motion"),
    )

    @classmethod
    def over(cls, variables: list[str], own: list[str]) -> list[str]:
        return [variable for variable in own if variable == "time"]
