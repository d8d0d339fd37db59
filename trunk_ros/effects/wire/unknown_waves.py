"""Something that comes back in time ahead of the friction, whatever the arm does, and that no name fits."""

from typing import ClassVar

from trunk_ros.effects.wire.unknown_cycle import UnknownCycle


class UnknownWaves(UnknownCycle):
    """u += curve(t mod period), period = high - low, t since the start of the recording."""

    id = "unknown_waves"
    place = 60
    linear = False
    ahead = True
    signature = "The residual swings in time with one period, as far as the backlash lets it through."
    of = "what the wire hands on, again and again,"
    swings = "what the wire hands on swings with {}"
    whenever = ", as far as the backlash lets it through"
    confused_with: ClassVar[tuple[tuple[str, str], ...]] = (
        ("unknown_cycle", "stand still: what happens before the friction waits for a motion"),
    )
