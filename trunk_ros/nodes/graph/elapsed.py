"""Time that only goes on, for simulations that live through pauses and clocks that are set."""

SECOND = 1_000_000_000  # ns
LONGEST_PAUSE = 5 * SECOND  # ns; a longer pause, or a step back, is left out
AFTER_JUMP = SECOND // 1000  # ns that pass in its place, since no two samples are of the same time


class Elapsed:
    """Seconds since the first stamp, without pauses."""

    def __init__(self) -> None:
        self.origin: int | None = None
        self._ns = 0

    def at(self, stamp: int) -> float:
        """Go on to a stamp [ns]; returns the time [s] there."""
        if self.origin is None:
            self.origin = stamp
        step = stamp - self.origin - self._ns
        if not 0 <= step <= LONGEST_PAUSE:
            self.origin += step - AFTER_JUMP
        self._ns = stamp - self.origin
        return self._ns / SECOND

    def of(self, stamp: int) -> float:
        """The time [s] of a stamp near the last one, without going there."""
        return (stamp - (stamp if self.origin is None else self.origin)) / SECOND
