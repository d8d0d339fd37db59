"""How a process is asked to end; needs nothing, so that it holds before all else is imported."""

from __future__ import annotations

import signal
from typing import Any

ASKED = (signal.SIGINT, signal.SIGTERM)


class Stop:
    """Turns SIGINT and SIGTERM into a flag, so that a process ends in good order."""

    asked = False  # of the process, whoever set up the handlers

    def __init__(self) -> None:
        for number in ASKED:
            signal.signal(number, self._ask)

    def _ask(self, *_: Any) -> None:
        Stop.asked = True

    def ignore(self) -> None:
        """The end has begun: Python would give up its handlers on the way, and a second signal kill it."""
        for number in ASKED:
            signal.signal(number, signal.SIG_IGN)
