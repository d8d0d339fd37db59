"""What clocks, sensors and knocks did to a recording that showed only beside the physics: it is said, and the
tones are taken out of what else is compared.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from trunk_ros.data.sensing.hum import Hum
from trunk_ros.data.sensing.pairs import told
from trunk_ros.data.sensing.readings import taken_out
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.disturbances.knocks import knocks_told
from trunk_ros.diagnosis.pace import skew_told
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.levels import CLEARLY
from trunk_ros.recording.observed import Observed
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import TOPICS
from trunk_ros.units import sized


def bursts_told(context: Context, index: int) -> Iterator[Observed]:
    """What to say of the bursts in a recording."""
    for begin, end, times in context.views[index].span.bursts:
        said = (
            f"{TOPICS['joint_states']} is {times:.1f} times as loud as else from {begin:.1f} to {end:.1f} s: "
            "readings there count as much less"
        )
        yield told("burst", (TOPICS["joint_states"], context.joints), times, None, "1", said)


def wandering_told(context: Context, index: int) -> Iterator[Observed]:
    """What to say of noise that wanders much further than it goes from sample to sample: physics may hide in
    it. It is that of all recordings, and said with the first.
    """
    clear = (c for c in context.wanders if context.noise[c].std > CLEARLY * context.noise[c].roughness)
    for c in sorted(clear) if index == 0 else ():
        joint, noise, unit = context.joints[c], context.noise[c], context.stage.unit(c)
        std, rough = sized(noise.std, unit), sized(noise.roughness, unit)
        said = (
            f"the noise of {joint} wanders: {std}, {rough} from sample to sample. It goes with nothing that "
            "the arm does, but smaller physics may be hidden in it"
        )
        where = TOPICS["joint_states"], (joint,)
        yield Observed("wandering_noise", *where, noise.std, None, unit, False, (), said)


@dataclass(frozen=True)
class Beside:
    """What was seen of a recording beside the physics: tones of some joints, and what to say of it."""

    tones: tuple[tuple[list[str], Hum], ...]
    observed: tuple[Observed, ...]

    def put_right(self, recording: Recording) -> Recording:
        """The recording with it."""
        for joints, hum in self.tones:
            recording = taken_out(recording, joints, hum)
        return replace(recording, observed=recording.observed + self.observed)


def beside(state: Fit) -> list[Beside]:
    """Of each of a fit's spans."""
    return [_beside(state, index) for index in range(len(state.context.views))]


def _beside(state: Fit, index: int) -> Beside:
    context = state.context
    tones = (([context.joints[c] for c in columns], hum) for columns, hum in context.views[index].hums)
    seen = (
        *bursts_told(context, index),
        *wandering_told(context, index),
        *skew_told(context, state.hypothesis, index),
        *knocks_told(context, state.hypothesis, index),
    )
    return Beside(tuple(tones), seen)
