"""What a node says about itself once a second: rates, lateness, saturation, stale streams, oddities."""

from __future__ import annotations

from dataclasses import dataclass, field

from trunk_ros.nodes.graph.elapsed import SECOND

OK, WARN, ERROR, STALE = 0, 1, 2, 3


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
    _notes: dict[str, tuple[int, int]] = field(default_factory=dict)
    _since: int | None = None
    _ticks: int = 0
    _late: int = 0

    def note(self, text: str, level: int = WARN) -> None:
        """Say something with the next report; the same words are counted, not repeated."""
        times, worst = self._notes.get(text, (0, OK))
        self._notes[text] = times + 1, max(level, worst)

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
        level = ERROR if self.fault else max(levels)
        words = [f"no {name} for {self.silence(name, now):.1f} s" for name in stale] + notes
        words = [self.fault, *words] if self.fault else words
        values = self._rates(now) | self.values
        self._notes.clear()
        self._since, self._ticks, self._late = now, 0, 0
        return level, "; ".join(words) or "ok", values

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
