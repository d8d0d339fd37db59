"""A wire whose zero jumps about for no reason that has a name."""

from typing import ClassVar

from trunk_ros.effects.wire.unknown_jumps import UnknownJumps


class UnknownSlips(UnknownJumps):
    """u += value_k from moment_k on, until the next; t since the start of the recording."""

    id = "unknown_slips"
    place = 60
    linear = False
    ahead = True
    signature = "The residual's mean jumps between levels, as far as the backlash lets it through."
    of = "what the wire hands on, by jumps,"
    confused_with: ClassVar[tuple[tuple[str, str], ...]] = (
        ("unknown_jumps", "stand still: what happens before the friction waits for a motion"),
    )
