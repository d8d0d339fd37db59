"""Joints of which both topics have the same readings, digit by digit."""

from __future__ import annotations

import numpy as np

from trunk_ros.data.mix_ups.pair import MixUp, Pair
from trunk_ros.levels import ENOUGH


def copied(pair: Pair) -> list[MixUp]:
    """Joints whose readings are those of their motors; a remark where the model has them turn as far: an
    ideal simulator's do.
    """
    if pair.stage != "wire" or len(pair.stamp) < ENOUGH:
        return []
    same = np.all(pair.source == pair.target, axis=0) & (np.ptp(pair.source, axis=0) > 0.0)
    other = same & (pair.factor != 1.0)
    source, target = pair.topics
    out = []
    for which, certain in ((other, True), (same & ~other, False)):
        if which.any():
            said = (
                f"motors given for joints? {target} of {', '.join(pair.names(which))} has the readings of "
                f"{source}, digit by digit, and shows nothing of the wire. Give the joints' own sensors in "
                "the driver or the mapping, and diagnose again"
            )
            out.append(pair.found("copy", which, f"{said}{'.' if certain else ''}", certain))
    return out
