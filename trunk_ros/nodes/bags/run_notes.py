"""What a bag says of the run beside its messages: who recorded how, and when the clock was set."""

from __future__ import annotations

import json
import platform
import shlex
import sys
import time
from pathlib import Path
from typing import Any

from trunk_ros import __version__
from trunk_ros.errors import TrunkError
from trunk_ros.nodes.graph.elapsed import SECOND

JUMP = SECOND // 10  # ns between two looks that no clock drifts


def manifest(recorder: Any) -> str:
    """JSON of command, versions and the recorder's parameters, with what the parameter ``manifest`` adds.

    Raises TrunkError where that is no JSON object.
    """
    try:
        given = json.loads(recorder.value("manifest"))
    except ValueError:
        given = None
    if not isinstance(given, dict):
        raise TrunkError(f"manifest: {recorder.value('manifest')[:40]!r} is no JSON object")
    names = [each.name for each in recorder.OWN if each.name != "manifest"]
    said = {
        "command": command(sys.argv),
        "version": __version__,
        "python": platform.python_version(),
        "recorder": {name: recorder.value(name) for name in names},
    }
    return json.dumps(said | given)


def command(argv: list[str]) -> str:
    """What was typed, without where it is installed."""
    program = Path(argv[0])
    name = program.parent.name if program.name == "__main__.py" else program.name
    return shlex.join([name, *argv[1:]])


class WallClock:
    """Sees the wall's clock being set; ``jumps`` says by how much, in sentences."""

    def __init__(self) -> None:
        self.jumps: list[str] = []
        self._seen = self._before = time.monotonic_ns()
        self._offset = time.time_ns() - self._seen

    def look(self) -> str:
        """Compare with the steady clock; words on a jump since the last look, "" where there is none."""
        wall, self._before, self._seen = time.time_ns(), self._seen, time.monotonic_ns()
        step = wall - self._seen - self._offset
        self._offset += step
        if abs(step) < JUMP:
            return ""
        said = f"the clock was set {'forward' if step > 0 else 'back'} by {abs(step) / SECOND:.3f} s"
        self.jumps.append(f"{said} at {(wall - step) / SECOND:.3f}")
        return said

    def steady(self, wall: int) -> int:
        """ns of the steady clock at a time of the wall's [ns] since the look before the last."""
        return max(min(wall - self._offset, self._seen), self._before)
