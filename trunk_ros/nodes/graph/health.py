"""What a node says about itself once a second: rates, lateness, saturation, stale streams, oddities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from trunk_ros.nodes.graph.elapsed import SECOND

OK, WARN, ERROR, STALE = 0, 1, 2, 3
REFUSED = "refused"
"""The value under which a node says what it last refused to do, until it does what it is asked."""
LOGGED = 5  # different words that one report lets into the log; diagnostics have all


def unheard(level: int, text: str) -> None:
    """Where nobody wants a log."""


@dataclass
class Stream:
    """An input that should not dry up: it is stale when silent for ``timeout`` s after it has begun."""

    timeout: float
    last: int | None = None
    uncounted: list[int] = field(default_factory=list)

    def arrived(self, now: int) -> None:
        """Note a message at ``now`` ns."""
        self.last = now
        self.uncounted.append(now)

    def count(self, now: int) -> int:
        """Messages from before ``now`` since the last count."""
        later = [at for at in self.uncounted if at >= now]
        number = len(self.uncounted) - len(later)
        self.uncounted = later
        return number

    def stale(self, now: int) -> bool:
        """Whether it has begun and dried up."""
        return self.last is not None and now - self.last > self.timeout * SECOND


@dataclass
class Health:
    """Counts since the last report; times are ns of the node's clock, so that simulated runs repeat."""

    streams: dict[str, Stream] = field(default_factory=dict)
    values: dict[str, str] = field(default_factory=dict)
    """Lasting facts, such as the model's hash."""
    fault: str = ""
    """Why the node refuses to act, as long as it does."""
    troubles: dict[str, str] = field(default_factory=dict)
    """What is wrong as long as it lasts, though the node acts: an error, by what it is about."""
    log: Callable[[int, str], None] = unheard
    """Takes level and words of what is new."""
    _notes: dict[str, tuple[int, int]] = field(default_factory=dict)
    _before: set[str] = field(default_factory=set)
    """What the last report said."""
    _since: int | None = None
    _ticks: int = 0
    _late: int = 0

    def note(self, text: str, level: int = WARN) -> None:
        """Say something with the next report; the same words are counted, not repeated."""
        times, worst = self._notes.get(text, (0, OK))
        self._notes[text] = times + 1, max(level, worst)
        if not times and text not in self._before and len(self._notes) <= LOGGED:
            self.log(max(level, WARN), text)

    def trouble(self, about: str, text: str) -> None:
        """Say an error with each report until it is over, which empty words say."""
        if not text:
            self.troubles.pop(about, None)
        elif self.troubles.get(about) != text:
            self.troubles[about] = text
            self.log(ERROR, text)

    def ticked(self, late: int = 0) -> None:
        """Note a step of the node's loop that came ``late`` ns."""
        self._ticks += 1
        self._late = max(self._late, late)

    def due(self, now: int) -> bool:
        """Whether a second has passed since the last report."""
        if self._since is None or now < self._since:
            self._since = now
        return now - self._since >= SECOND

    def report(self, now: int) -> tuple[int, str, dict[str, str]]:
        """Level, message, values; then counting starts anew."""
        stale = [name for name, stream in self.streams.items() if stream.stale(now)]
        notes = [
            text if times == 1 else f"{text} ({times} times)" for text, (times, _) in self._notes.items()
        ]
        levels = [OK, *(level for _, level in self._notes.values()), *(WARN for _ in stale)]
        errors = [*([self.fault] if self.fault else []), *self.troubles.values()]
        level = ERROR if errors else max(levels)
        words = [*errors, *(f"no {name} for {self.silence(name, now):.1f} s" for name in stale), *notes]
        values = self._rates(now) | self.values
        self._log_stale(stale)
        self._before = {*self._notes, *stale}
        self._notes.clear()
        self._since, self._ticks, self._late = now, 0, 0
        return level, "; ".join(words) or "ok", values

    def _log_stale(self, stale: list[str]) -> None:
        for name in stale:
            if name not in self._before:
                self.log(WARN, f"{name} is stale: nothing for more than {self.streams[name].timeout:g} s")
        for name in self._before & self.streams.keys() - set(stale):
            self.log(OK, f"{name} is back")

    def silence(self, name: str, now: int) -> float:
        """Seconds since the last message of a stream; infinite before the first."""
        last = self.streams[name].last
        return float("inf") if last is None else (now - last) / SECOND

    def _rates(self, now: int) -> dict[str, str]:
        span = max(now - (now if self._since is None else self._since), 1) / SECOND
        values = {"rate [Hz]": f"{self._ticks / span:.1f}", "worst lateness [ms]": f"{self._late / 1e6:.3f}"}
        for name, stream in self.streams.items():
            values[f"{name} [Hz]"] = f"{stream.count(now) / span:.1f}"
        return values
