"""Files that are whole or not there, however a process ends."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def write_whole(path: Path, value: Any) -> None:
    """Writes a value as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_text(json.dumps(value, indent=1))
    part.replace(path)
