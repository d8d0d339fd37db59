"""Where the joints stand: as measured where joint_states come, else as the model says from the gearbox."""

from __future__ import annotations

from collections import deque

import numpy as np

from trunk_ros.chain import Chain
from trunk_ros.chain import State as Memory
from trunk_ros.model import Model
from trunk_ros.nodes.control.goal import State
from trunk_ros.nodes.graph.elapsed import Elapsed

KEPT = 4  # samples of a stream


class Newest:
    """The newest sample of a stream, with its stamp [ns].

    ``strict``: of those from before the step under way, so that simulated runs repeat whatever comes first.
    """

    def __init__(self, strict: bool):
        self.strict = strict
        self._samples: deque[tuple[int, State]] = deque(maxlen=KEPT)

    def put(self, stamp: int, sample: State) -> None:
        """Take a sample; one that is older than the last means that time was set back."""
        if self._samples and stamp < self._samples[-1][0]:
            self._samples.clear()
        self._samples.append((stamp, sample))

    def clear(self) -> None:
        """Forget all samples."""
        self._samples.clear()

    def at(self, now: int) -> tuple[int, State] | None:
        """The sample to use in the step at ``now`` ns."""
        for stamp, sample in reversed(self._samples):
            if not self.strict or stamp < now:
                return stamp, sample
        return None


class Measured:
    """Both streams of the arm's state, and the model run forward for joints without a sensor."""

    def __init__(self, model: Model, strict: bool):
        self.gearbox, self.joints = Newest(strict), Newest(strict)
        self._none = State(*(np.full(len(model.arm.joints), np.nan) for _ in range(2)))
        self.use(model)

    def use(self, model: Model) -> None:
        """Another model, memory at its centre."""
        self._chain = Chain(model, "wire", hold_time=True)
        self._memory: Memory | None = None
        self._elapsed = Elapsed()
        self._last: tuple[int, float, State] | None = None

    def state(self, now: int, fresh: bool) -> tuple[int, State]:
        """The joints and the stamp [ns] of the sample that says so; NaN where nothing does.

        ``fresh``: whether joint_states come; a joint that they leave out is the model's.
        """
        measured = self.joints.at(now) if fresh else None
        if measured is not None and np.isfinite(measured[1].position).all():
            return measured
        gearbox = self.gearbox.at(now)
        if gearbox is None or not np.isfinite(gearbox[1].position).all():
            return measured or (now, self._none)
        modelled = self._modelled(*gearbox)
        if measured is None:
            return gearbox[0], modelled
        known = np.isfinite(measured[1].position)
        position = np.where(known, measured[1].position, modelled.position)
        return measured[0], State(position, np.where(known, measured[1].velocity, modelled.velocity))

    def _modelled(self, stamp: int, gearbox: State) -> State:
        last = self._last
        if last is not None and stamp == last[0]:
            return last[2]
        at = self._elapsed.at(stamp)
        (angle,), self._memory = self._chain.run(gearbox.position[None], np.array([at]), self._memory)
        speed = np.zeros_like(angle) if last is None else (angle - last[2].position) / (at - last[1])
        self._last = stamp, at, State(angle, speed)
        return self._last[2]
