"""How far long work is: a line that changes on a terminal, a line every ten seconds where it is piped."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from threading import Event, Thread

from trunk_ros.console.console import Level, asked

EVERY = 10.0  # s between lines where nobody watches
SURE = 0.5  # share of the work behind which it can be told how long the rest takes
Say = Callable[[str], None]


class Progress:
    """Stage, step and expected time of work in known stages."""

    def __init__(self, shares: Mapping[str, float], show: Say, clock: Callable[[], float] = time.monotonic):
        """``shares``: how much of the time passed before a stage begins, 0 to 1, as measured once.

        ``show`` is given a line at each step.
        """
        self.shares, self.show, self.clock = shares, show, clock
        self.began, self.text, self.done, self.total = clock(), "", 0.0, 0.0

    def step(self, text: str) -> None:
        """``text``: "stage" or "stage: step"."""
        stages = [stage for stage in self.shares if text == stage or text.startswith(f"{stage}: ")]
        if stages:
            self._reach(self.shares[max(stages, key=len)])
        self.text = text
        self.show(self.line())

    def _reach(self, share: float) -> None:
        """What all will take follows from when a stage began: within a stage it stays."""
        if share > self.done:
            self.done, self.total = share, (self.clock() - self.began) / share

    def line(self) -> str:
        """What goes on now, since when, and, once half is done, for how long."""
        passed = self.clock() - self.began
        left = self.total - passed
        expected = f", about {spoken(left)} to go" if self.done >= SURE and left > 1.0 else ""
        return f"{self.text} ({spoken(passed)}{expected})"


def spoken(seconds: float) -> str:
    """A length of time as one says it."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


@contextmanager
def progress(shares: Mapping[str, float]) -> Iterator[Say]:
    """Shows steps on the standard error while the block runs: give them to what is yielded.

    A line that changes on a terminal; else a line every ten seconds; with -v one for each step, with -q none.
    """
    if asked() == Level.QUIET:
        yield lambda _: None
    elif asked() == Level.VERBOSE:
        yield Progress(shares, lambda line: print(line, file=sys.stderr, flush=True)).step
    elif not sys.stderr.isatty():
        told = Progress(shares, lambda _: None)
        with every(EVERY, told.line):
            yield told.step
    else:
        from rich.console import Console

        with Console(stderr=True).status("") as status:
            yield Progress(shares, status.update).step


@contextmanager
def every(seconds: float, line: Callable[[], str]) -> Iterator[None]:
    """Prints what ``line`` says on the standard error each so many s, also while a step takes longer."""
    over = Event()

    def show() -> None:
        while not over.wait(seconds):
            print(line(), file=sys.stderr, flush=True)

    clock = Thread(target=show, daemon=True)
    clock.start()
    try:
        yield
    finally:
        over.set()
        clock.join()
